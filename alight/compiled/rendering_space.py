"""Rendering space: the world, shifted so that what is far from its origin is near to it.

Numbers of float32 are a part in 2^24 of their size apart. Where a scene lies much further from the
origin than it is wide, as with coordinates of a map, surfaces would be rounded to steps that can be
seen, and rays would start too far from them. Such a scene is compiled around its own middle; what
tells places of the world (the layer ``position``, traces) adds it again.

Source: PBR4 section 5.1.1, "Camera Coordinate Spaces".
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from alight.scene.flatten import FlatScene, PlacedCamera, PlacedLight, PlacedShape
from alight.scene.motion import Link, Motion
from alight.scene.transform import Matrix

#: From so many radii on the middle of a scene counts as far from the origin: four bits are lost.
FAR = 16.0

#: A space that is the world.
WORLD = np.zeros(3)

_Placed = TypeVar("_Placed", PlacedShape, PlacedLight, PlacedCamera)


class Ball(NamedTuple):
    """A ball around all finite shapes: (3,) float64 and float, metres."""

    center: NDArray[np.float64]
    radius: float


def origin_for(flat: FlatScene, ball: Ball | None) -> NDArray[np.float64]:
    """Where in the world the origin of rendering space is, (3,) metres: `WORLD` where it may be.

    It is rounded to a power of two about as large as the scene with its camera, so that it rarely
    changes with what is moved in it.
    """
    placed = flat.camera
    camera = placed.to_world if placed.motion is None else placed.motion.at(0.0) @ placed.to_world
    if ball is None:
        return WORLD
    # A camera that is far from the shapes, as from a sun, sees what is around it, too.
    reach = max(ball.radius, float(np.linalg.norm(camera[:3, 3] - ball.center)))
    if np.linalg.norm(ball.center) <= FAR * reach:
        return WORLD
    if any(medium.moved(WORLD) is None for medium in flat.media):
        return WORLD
    step = 2.0 ** np.ceil(np.log2(reach))
    return step * np.round(ball.center / step)


def in_rendering_space(flat: FlatScene, origin: NDArray[np.float64]) -> FlatScene:
    """The scene with everything that has a place shifted by -origin."""
    if not origin.any():
        return flat
    return replace(
        flat,
        shapes=[shifted(placed, origin) for placed in flat.shapes],
        lights=[shifted(placed, origin) for placed in flat.lights],
        camera=shifted(flat.camera, origin),
        media=[medium.moved(-origin) for medium in flat.media],
    )


def shifted(placed: _Placed, origin: NDArray[np.float64]) -> _Placed:
    """What is placed in the world, in rendering space."""
    if not origin.any():
        return placed
    back, motion = np.eye(4), placed.motion
    back[:3, 3] = -origin
    if motion is None or _only_shifts(motion, origin):
        return placed._replace(to_world=back @ placed.to_world)
    return placed._replace(motion=_after(motion, back))


def _only_shifts(motion: Motion, origin: NDArray[np.float64]) -> bool:
    """Whether a motion only shifts what is far away already, so that the order does not matter."""
    if not motion.is_rigid or len(motion.links) != 1:
        return False
    frames = motion.links[0].track.frames
    turns = any(not np.array_equal(np.abs(f.turn), [1.0, 0.0, 0.0, 0.0]) for f in frames)
    to_there = any(np.linalg.norm(f.shift - origin) < np.linalg.norm(f.shift) for f in frames)
    return not turns and not to_there


def _after(motion: Motion, back: Matrix) -> Motion:
    """A motion, and then a shift; what only shifts and turns stays so."""
    (before, track), *others = motion.links
    if not np.array_equal(before, np.eye(4)):
        return Motion((Link(back @ before, track), *others))
    frames = tuple(f._replace(shift=f.shift + back[:3, 3]) for f in track.frames)
    return Motion((Link(before, track._replace(frames=frames)), *others))
