"""What a model needs to be seen, where its file has none: light around it, and a camera.

The light is the picture ``builtin:studio``, turned such that it is the same as seen from any
camera; `alight.formats.geometry.bounds` tells where the camera stands. A file that has neither
shows an object, not a place: it stands on the studio's floor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.fields import LARGEST
from alight.core.spec import Bsdf
from alight.formats.geometry.bounds import FOV, FOV_AXIS, TO_THE_RIGHT, Bounds
from alight.formats.reading.names import free_name
from alight.formats.reading.report import Report

STUDIO, FLOOR = "builtin:studio", "builtin:studio-floor"
#: Radius of the floor, and its distance below the object, in radii of the sphere around that.
FLOOR_RADIUS, GAP = 20.0, 0.002
NO_LIGHT = "the file has no light: a soft studio stands around it (environment)"
FAINT_LIGHT = (
    "what shines in the file is too faint to see it by: a soft studio stands around it "
    "(environment)"
)
NO_CAMERA = "the file has no camera: one was placed that sees all of it (camera)"
SIZE = (800, 600)


def add_light(
    data: dict[str, Any],
    report: Report,
    *,
    shines: bool,
    view: NDArray[np.float64] | None = None,
) -> None:
    """Put the studio around a scene.

    Parameters
    ----------
    shines : bool
        Whether anything in the scene shines, too faintly (`glow`).
    view : (4, 4) float64, optional
        Camera to world of the file's own camera: the studio's front is then turned to it.
    """
    data["environment"] = {"type": "environment", "file": STUDIO}
    if view is not None and (rotation := studio_rotation(view)) != 0.0:
        data["environment"]["rotate"] = rotation
    report.assume("environment.file", FAINT_LIGHT if shines else NO_LIGHT)


def add_floor(nodes: dict[str, Any], bounds: Bounds) -> None:
    """Put the studio's floor under an object; none under nothing."""
    center, radius = bounds.sphere
    if not bounds.parts or not np.isfinite(bounds.low).all():
        return
    place = [center[0], bounds.low[1] - GAP * radius, center[2]]
    if np.abs(place).max() + FLOOR_RADIUS * radius > LARGEST:
        return
    # A disk's u is its radius.
    albedo = {"type": "bitmap", "file": FLOOR, "wrap": "clamp"}
    nodes[free_name("studio floor", nodes, "floor")] = {
        "shape": {"type": "disk"},
        "bsdf": {"type": "diffuse", "reflectance": albedo},
        "transform": [
            {"rotate": {"axis": "x", "angle": -90.0}},
            {"scale": FLOOR_RADIUS * radius},
            {"translate": [float(x) for x in place]},
        ],
    }


def is_floor(bsdf: Bsdf | str | None) -> bool:
    """Whether this is the material of the studio's floor."""
    return getattr(getattr(bsdf, "reflectance", None), "file", None) == FLOOR


def studio_rotation(view: NDArray[np.float64]) -> float:
    """Degrees by which the studio is turned for a camera (4, 4); 0 if it looks up or down."""
    if np.hypot(view[0, 2], view[2, 2]) <= 1e-3 * np.linalg.norm(view[:3, 2]):
        return 0.0
    return math.degrees(math.atan2(view[0, 2], view[2, 2])) - TO_THE_RIGHT


def say_if_empty(report: Report, bounds: Bounds) -> None:
    """Say that a file shows nothing, which its picture would not explain."""
    if not bounds.parts:
        report.approximate("the file holds no surface: there is nothing to see but light")


def add_camera(data: dict[str, Any], report: Report, bounds: Bounds) -> None:
    """Place a camera that sees all of a scene."""
    origin, target = bounds.viewpoint(SIZE)
    data["camera"] = {
        "type": "pinhole",
        "fov": FOV,
        "fov_axis": FOV_AXIS,
        "transform": {"look_at": {"origin": origin, "target": target}},
    }
    data.setdefault("film", {})["size"] = list(SIZE)
    report.assume("camera.transform", NO_CAMERA)


def use_first_camera(data: dict[str, Any], report: Report, paths: Sequence[str]) -> None:
    """Show what the first camera of a file sees, and say so if there are others."""
    data["camera"] = paths[0]
    if len(paths) > 1:
        report.assume(
            "camera",
            f"the picture is that of the first camera, {paths[0]}; others: {', '.join(paths[1:])} "
            "(choose with --camera)",
        )
