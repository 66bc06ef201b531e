r"""Disk: x^2 + y^2 <= 1 at z = 0 with normal +z and parameters (u, v) = (r, phi / 2 pi).

Size and place come from the transform of its node; a non-uniform scale makes it an ellipse.

Source: PBR4 section 6.4; canonical placement as in Mitsuba 3.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.constants import INV_TWO_PI, TWO_PI
from alight.core.maths import arctan2
from alight.core.spec import Shape
from alight.core.vec import cross, dot, gather_vec3, length_squared
from alight.core.warps import disk_to_square_concentric, square_to_disk_concentric
from alight.shapes.flat import (
    AREA,
    E1,
    E2,
    circle,
    flat_geometry,
    flat_point,
    local_coordinates,
    meet_plane,
    pack_flat,
)
from alight.shapes.hit import INFO, AreaSample, Geometry, ShapeSample, area_to_solid_angle
from lanewise.jit import kernel
from lanewise.simd import gather, lanes_u32, maximum, sqrt, where


class Disk(Shape):
    """Unit disk in the plane z = 0.

    Parameters
    ----------
    flip_normals : bool, default False
        Point the normal to -z.
    """

    type: Literal["disk"] = "disk"

    def edges(self) -> np.ndarray:
        """Points of its circle."""
        return circle()


EXAMPLES = (Disk(), Disk(flip_normals=True))


#: Itself, seen from the front.
PROJECTION = 1.0


def pack(spec: Disk, matrix: np.ndarray) -> np.ndarray:
    """The row of the table, see `alight.shapes.flat`."""
    row = pack_flat(matrix, spec.flip_normals, extent=1.0)
    # An ellipse covers pi / 4 of the parallelogram around it.
    row[AREA] *= np.pi / 4.0
    return row


def area(row: np.ndarray) -> float:
    """Surface area in m^2 from a packed row."""
    return float(row[AREA])


def bounds(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the bounding box from a packed row: |x e1 + y e2| <= hypot(e1, e2)."""
    half = np.hypot(row[16:19], row[20:23]) * np.float32(1.0 + 1e-6) + row[15]
    return row[12:15] - half, row[12:15] + half


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one disk with rays; see `alight.shapes.rectangle.intersect`."""
    t, x, y = meet_plane(data, k, o, d)
    return t, x, y, (x * x + y * y <= 1.0) & (t > 0.0) & (t <= t_max)


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data = tables.data
    x, y = hit.u, hit.v
    r = sqrt(x * x + y * y)
    turn = arctan2(y, x) * INV_TWO_PI
    turn = where(turn < 0.0, turn + 1.0, turn)
    g = flat_geometry(data, k, x, y, gather(data, k + 15), r, turn)
    # dp/dr is radial; at the centre any direction will do, and e1 is there.
    radial = x * gather_vec3(data, k + E1) + y * gather_vec3(data, k + E2)
    size = sqrt(length_squared(radial))
    s = where(size > 0.0, radial * (1.0 / maximum(size, 1e-30)), g.s)
    return Geometry(
        p=g.p, error=g.error, ng=g.ng, ns=g.ns, s=s, t=cross(g.ng, s), u=g.u, v=g.v, color=g.color
    )


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point uniformly by area; see `alight.shapes.rectangle.sample`."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    x, y = square_to_disk_concentric(u2)
    to_light = flat_point(data, k, x, y) - p
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / distance)
    cosine = -dot(wi, gather_vec3(data, k))
    density = area_to_solid_angle(1.0 / gather(data, k + AREA), distance, cosine)
    return ShapeSample(wi, distance, cosine, gather(data, k + 15), density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    k = gather(tables.info, shape * INFO + 3)
    return area_to_solid_angle(1.0 / gather(tables.data, k + AREA), hit.distance, hit.cosine)


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose a point uniformly by area; see `alight.shapes.rectangle.sample_area`."""
    k = gather(tables.info, shape * INFO + 3)
    x, y = square_to_disk_concentric(u2)
    p = flat_point(tables.data, k, x, y)
    return AreaSample(p, x, y, lanes_u32(0), 1.0 / gather(tables.data, k + AREA))


@kernel
def square(tables, cdf, start, shape, prim, q):
    """Where `sample_area` has a point q from; see `alight.shapes.rectangle.square`."""
    k = gather(tables.info, shape * INFO + 3)
    x, y = disk_to_square_concentric(*local_coordinates(tables.data, k, q))
    return x, y, 1.0 / gather(tables.data, k + AREA)


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    # u is the radius, v the angle.
    e1, e2 = gather_vec3(tables.data, k + E1), gather_vec3(tables.data, k + E2)
    x, y = local_coordinates(tables.data, k, surface.p)
    r = sqrt(x * x + y * y)
    per_r = 1.0 / where(r > 0.0, r, 1.0)
    return (x * per_r) * e1 + (y * per_r) * e2, TWO_PI * (x * e2 - y * e1)


@kernel
def coordinates(tables, cdf, start, shape, q, u, u2):
    """Local coordinates of a sampled point q, as `intersect` reports them."""
    k = gather(tables.info, shape * INFO + 3)
    x, y = local_coordinates(tables.data, k, q)
    return x, y, lanes_u32(0)


def facing(row: np.ndarray) -> tuple[np.ndarray, float]:
    """The one outer normal."""
    return row[0:3].astype(float), 0.0
