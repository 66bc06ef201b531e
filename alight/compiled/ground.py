"""The level ground on which a scene stands, where shadows are to be caught on one."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.compiled.program import Program
from alight.compiled.shapes import CompiledShapes
from alight.core.errors import Issue, SceneError
from alight.lights.ground import POINTS, Ground, measured_ground
from alight.scene.flatten import FlatScene

_WHAT = 'shadows are caught (background "shadow", layer "shadow")'


def ground_of(flat: FlatScene, shapes: CompiledShapes, program: Program, tables: tuple) -> Ground:
    """Put the ground at the lowest point of all finite shapes, +y being up.

    Raises
    ------
    SceneError
        If there is no such point, for media, for lights that move, whose light on open ground is
        another at each time, and for shapes that shine: how much light they would bring to open
        ground is not known.
    """
    issues = [
        Issue(placed.name, f"shines; {_WHAT} of lights at points and at infinity only")
        for placed in flat.shapes
        if placed.light is not None
    ]
    issues += [
        Issue(placed.name, f"moves while the shutter is open; {_WHAT} of lights at rest only")
        for placed in flat.lights
        if placed.motion is not None
    ]
    if program.media:
        issues.append(Issue("media", f"{_WHAT} in empty space only"))
    if shapes.lowest is None:
        issues.append(Issue("nodes", f"{_WHAT} below finite shapes; there are none"))
    if issues:
        raise SceneError(issues[:1])
    if program.motion:
        # Kernels of scenes with motion ask for a time.
        now = namedtuple("Now", (*tables._fields, "time"))  # type: ignore[attr-defined]
        tables = now(*tables, np.zeros(POINTS, np.float32))
    point = np.array([shapes.center[0], shapes.lowest, shapes.center[2]])
    return measured_ground(program, tables, point)
