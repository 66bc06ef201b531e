r"""How far a scene reaches, and from where a camera sees all of it.

The camera looks at the model from the front (glTF's and most programs' front is +z, up is +y), 30
degrees to the right and 20 above, and stands so near that the model fills the picture but for a
margin. With the camera's axes u, v, w (w backwards) and :math:`t_x, t_y`, the tangents of half the
opening angles within the margin, a point p is in the picture if

.. math:: |p_u - c_u| \le t_x (c_w - p_w), \qquad |p_v - c_v| \le t_y (c_w - p_w)

so the nearest camera c follows from four largest values over all points: for one side,
:math:`A_\pm = \max(\pm p_u + t_x p_w)`, :math:`c_w = (A_+ + A_-) / (2 t_x)` and
:math:`c_u = (A_+ - A_-) / 2`. Of both sides the one that asks for more distance wins.

The largest value of a shape with a formula along a direction d is a side of its own box in a space
of which d is an axis. So whatever tells its box, as every shape does, is seen whole, and a sphere
is not framed as its box would be.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.cameras.basis import perspective_half_extents
from alight.core.fields import Model
from alight.core.spec import Shape
from alight.scene.build import Builder
from alight.scene.motion import Motion
from alight.shapes.arrays import TriangleShape
from alight.shapes.model import SHAPES

Array = NDArray[np.float64]

FOV, TO_THE_RIGHT, ABOVE = 40.0, 30.0, 20.0  # degrees
#: Of both sides, so that wide and high pictures are not distorted at their ends.
FOV_AXIS = "larger"
#: Part of the picture's sides that is left free on each edge.
MARGIN = 0.05
#: Least depth of a point, in radii of the sphere around the box: from nearer, a rod that points at
#: the camera would be all tip.
NEAREST = 0.5


@dataclass
class Bounds:
    """What an automatic camera must see, and the axis-aligned box around it.

    Attributes
    ----------
    low, high : (3,) float64, metres
    parts : list of ((n, 3) array or Shape, (4, 4) float64)
        Points or shapes as they were added, and the matrix to the world.
    """

    low: Array = field(default_factory=lambda: np.full(3, np.inf))
    high: Array = field(default_factory=lambda: np.full(3, -np.inf))
    parts: list[tuple[ArrayLike | Shape, Array]] = field(default_factory=list)

    def add(
        self,
        points: ArrayLike | Shape | Mapping[str, Any],
        to_world: Array,
        motion: Motion | None = None,
    ) -> None:
        """Enclose something.

        Parameters
        ----------
        points : (n, 3) array, Shape or mapping
            Points, a mesh of arrays or a shape with a formula, or the description of one; infinite
            ones are left out, as is what is wrong: building the scene reports it.
        to_world : (4, 4) float64
        motion : Motion, optional
            What moves it further; the box of its way is enclosed.
        """
        if isinstance(points, Mapping):
            builder = Builder()
            points = cast("Shape", builder.model(Model("shape", "shapes"), points, ""))
            if builder.issues:
                return
        if isinstance(points, TriangleShape):
            assert points.vertices is not None
            points = points.vertices
        elif isinstance(points, Shape) and not points.finite:
            return
        low, high = _extremes(points, to_world, np.eye(3))
        if motion is not None:
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                return
            low, high = motion.bounds(low, high)
            points, to_world = corners(low, high), np.eye(4)
        self.parts.append((points, to_world))
        self.low, self.high = np.minimum(self.low, low), np.maximum(self.high, high)

    @property
    def sphere(self) -> tuple[Array, float]:
        """Centre and radius of the sphere through the corners; a unit one around nothing."""
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            return np.zeros(3), 1.0
        radius = 0.5 * float(np.linalg.norm(self.high - self.low))
        return 0.5 * (self.low + self.high), radius if radius > 0.0 else 1.0

    def viewpoint(self, size: tuple[int, int]) -> tuple[list[float], list[float]]:
        """Origin and target of the camera that shows everything in a picture of this size."""
        center, radius = self.sphere
        axes = camera_axes()
        tangents = np.array(perspective_half_extents(FOV, FOV_AXIS, *size)) * (1.0 - 2.0 * MARGIN)
        # Largest values of p_u + t_x p_w, -p_u + t_x p_w, the same of v, and of p_w.
        sides = np.array([axes[0], -axes[0], axes[1], -axes[1], axes[2]])
        sides[:4] += np.repeat(tangents, 2)[:, None] * axes[2]
        largest = np.full(5, -np.inf)
        for points, to_world in self.parts:
            largest = np.maximum(largest, _extremes(points, to_world, sides)[1])
        if not np.isfinite(largest).all() or not (self.low < self.high).any():
            # A unit sphere, where there is nothing or a point.
            largest = sides @ center + np.linalg.norm(sides, axis=1)
        plus, minus = largest[:4:2], largest[1:4:2]
        nearest = largest[4] + NEAREST * radius
        distance = max(nearest, *((plus + minus) / (2.0 * tangents)))
        origin = np.array([*(0.5 * (plus - minus)), distance]) @ axes
        target = origin - (distance - center @ axes[2]) * axes[2]
        return origin.tolist(), target.tolist()


def corners(low: ArrayLike, high: ArrayLike) -> Array:
    """The (8, 3) corners of a box."""
    return np.array(list(itertools.product(*np.stack([low, high]).T)))


def camera_axes() -> Array:
    """Rows u, v, w of the automatic camera."""
    right, above = math.radians(TO_THE_RIGHT), math.radians(ABOVE)
    w = np.array(
        [math.sin(right) * math.cos(above), math.sin(above), math.cos(right) * math.cos(above)]
    )
    u = np.array([math.cos(right), 0.0, -math.sin(right)])
    return np.array([u, np.cross(w, u), w])


def _extremes(points: ArrayLike | Shape, to_world: Array, directions: Array) -> tuple[Array, Array]:
    """Least and largest values of world points along directions (m, 3)."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        if isinstance(points, Shape):
            return _extremes_of_shape(points, to_world, directions)
        # Directions are taken to the points' space, not a million points to the world's.
        along = np.asarray(points) @ (directions @ to_world[:3, :3]).T
        shift = directions @ to_world[:3, 3]
        return along.min(axis=0) + shift, along.max(axis=0) + shift


def _extremes_of_shape(spec: Shape, to_world: Array, directions: Array) -> tuple[Array, Array]:
    parts = spec.parts()
    if parts:
        found = [_extremes_of_shape(part, to_world @ place, directions) for part, place in parts]
        lows, highs = zip(*found, strict=True)
        return np.min(lows, axis=0), np.max(highs, axis=0)
    model = SHAPES[spec.type_name()]
    assert model.pack is not None
    assert model.bounds is not None
    if model.extremes is not None:
        lows, highs = model.extremes(model.pack(spec, to_world), directions)
        return lows.min(axis=0), highs.max(axis=0)
    low, high = np.zeros(len(directions)), np.zeros(len(directions))
    for start in range(0, len(directions), 3):
        rows = directions[start : start + 3]
        space = np.eye(4)
        space[:3, :3] = _completed(rows)
        try:
            box = model.bounds(model.pack(spec, space @ to_world))
        except np.linalg.LinAlgError:
            # Flat: compiling the scene reports it.
            box = (space @ to_world)[:3, 3], (space @ to_world)[:3, 3]
        low[start : start + 3], high[start : start + 3] = (side[: len(rows)] for side in box)
    return low, high


def _completed(rows: Array) -> Array:
    """At most three independent rows, and others at right angles to them."""
    return np.concatenate([rows, np.linalg.svd(rows)[2][len(rows) :]])
