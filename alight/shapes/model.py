"""What the renderer takes from the file of a shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from alight.core.constants import PI
from alight.core.registry import Kernel, Record, Records

#: Most numbers of a shape's row: how far kernels read.
MOST_NUMBERS = 64


def everywhere(row: np.ndarray) -> tuple[np.ndarray, float]:
    """Normals of all directions."""
    return np.array([0.0, 0.0, 1.0]), PI


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapeModel(Record):
    """A shape: a formula, the triangles of a mesh, or (without `surface`) made of others.

    Attributes
    ----------
    pack : (spec, (4, 4) float64) -> (n,) float32
        The row of the table from the matrix object to world; at most `MOST_NUMBERS`. Of a shape of
        many primitives the rows (m, n), all of them in the place of one in what follows.
    area, bounds, facing : functions of a packed row
        Surface area, m^2; corners of the box, metres; unit axis and half angle of a cone around all
        outer normals, radians.
    extremes : function of the packed rows and of directions (k, 3)
        Least and largest values (m, k) of each primitive along the directions, metres. A shape that
        has this is made of many, which are met from outside only: what enters one passes its far
        side. It cannot move while the shutter is open.
    intersect : kernel ``(data, k, o, d, t_max) -> (t, u, v, hit)``
        Nearest hits of a shape with a formula, 0 < t <= t_max, with d of any length. k: uniform
        offset of the row; u, v: whatever `surface` finds useful in a `Hit`. Full description:
        `alight.shapes.rectangle.intersect`.
    meet_alone : kernel ``(data, k, o, d, t_max) -> (t, u, v, bits)``
        The same of one of many primitives for one ray, given by scalars; bits 0 for a miss.
    surface : kernel ``(tables, k, hit, o, d) -> Geometry``
        The surface at the `Hit`s of rays, in the world: the point, a bound of its distance from the
        true surface (how to derive it: `alight.shapes.hit`), the unit normals on the outer side,
        tangents and texture coordinates. k: offsets of the rows in ``tables.data``, lanes.
    derivatives : kernel ``(tables, k, surface) -> (dp/du, dp/dv)``
        In the world, metres; without it the tangents of the surface.
    sample : kernel ``(tables, cdf, start, shape, p, u, u2) -> ShapeSample``
        Samples a point of an emissive shape as seen from p; see `alight.shapes.rectangle.sample`.
    pdf : kernel ``(tables, cdf, start, shape, p, hit)``
        Density of `sample` per solid angle at a `ShapeHit`.
    coordinates : kernel ``(tables, cdf, start, shape, q, u, u2) -> (u, v, prim)``
        The sampled point q as `intersect` reports it; without it all are 0.
    sample_area : kernel ``(tables, cdf, start, shape, u, u2) -> AreaSample``
        Samples a point of an emissive shape by area, whoever looks at it; without it no light path
        starts there.
    square : kernel ``(tables, cdf, start, shape, prim, q) -> (x, y, density)``
        The pair of numbers that `sample_area` takes to the point q of the primitive `prim`, and
        its density per square metre; without it points of textured lamps are chosen as if they
        shone evenly.
    KNOWS_VIEW : bool
        Its `sample` chooses points by where it is seen from, and not by area alone.
    PROJECTION : float
        Area of its largest shadow over its surface area; the light tree estimates by it how much a
        lamp of this shape sends one way.
    """

    pack: Callable[..., np.ndarray] | None = None
    area: Callable[[np.ndarray], float] | None = None
    bounds: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    extremes: Callable[..., tuple[np.ndarray, np.ndarray]] | None = None
    facing: Callable[[np.ndarray], tuple[np.ndarray, float]] = everywhere
    intersect: Kernel | None = None
    meet_alone: Kernel | None = None
    surface: Kernel | None = None
    derivatives: Kernel | None = None
    sample: Kernel | None = None
    pdf: Kernel | None = None
    coordinates: Kernel | None = None
    sample_area: Kernel | None = None
    square: Kernel | None = None
    KNOWS_VIEW: bool = False
    PROJECTION: float = 0.25

    @property
    def has_formula(self) -> bool:
        """Whether rays meet it by a formula, and not triangle by triangle."""
        return self.intersect is not None

    @property
    def is_many(self) -> bool:
        """Whether it is made of many primitives."""
        return self.extremes is not None


#: All shapes, by name.
SHAPES = Records("shapes", ShapeModel)
