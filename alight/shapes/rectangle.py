r"""Rectangle [-1, 1]^2 at z = 0 with normal +z and parameters (u, v) = ((x + 1)/2, (y + 1)/2).

Size and place come from the transform of its node; a shear makes it a parallelogram.

Source: the plug-in ``rectangle`` of Mitsuba 3 for the canonical placement.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.spec import Shape
from alight.core.vec import cross, dot, gather_vec3, length_squared
from alight.core.warps import (
    spherical_rectangle,
    spherical_rectangle_pdf,
    square_to_spherical_rectangle,
)
from alight.shapes.flat import (
    AREA,
    CENTER,
    E1,
    E2,
    ERROR,
    IS_RECTANGLE,
    flat_point,
    local_coordinates,
    meet_plane,
    pack_flat,
    point_on_plane,
)
from alight.shapes.hit import INFO, AreaSample, Geometry, ShapeSample, area_to_solid_angle
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    absolute,
    gather,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    rsqrt,
    where,
)


class Rectangle(Shape):
    """Square of side 2 in the plane z = 0.

    Parameters
    ----------
    flip_normals : bool, default False
        Point the normal to -z.
    """

    type: Literal["rectangle"] = "rectangle"

    def edges(self) -> np.ndarray:
        """Its corners."""
        return np.array([[x, y, 0.0] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])


EXAMPLES = (Rectangle(), Rectangle(flip_normals=True))

#: Rectangles reach a little over their edges, so that rays do not slip through where two of them
#: (the faces of a cube) share one: 2^-20 of the half side, above the rounding of local coordinates.
REACH = 1.0 + 2.0**-20


#: Itself, seen from the front.
PROJECTION = 1.0
KNOWS_VIEW = True


def pack(spec: Rectangle, matrix: np.ndarray) -> np.ndarray:
    """The row of the table, see `alight.shapes.flat`."""
    return pack_flat(matrix, spec.flip_normals, extent=1.0)


def area(row: np.ndarray) -> float:
    """Surface area in m^2 from a packed row."""
    return float(row[AREA])


def bounds(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the bounding box from a packed row."""
    center, half = row[12:15], np.abs(row[16:19]) + np.abs(row[20:23])
    half = half * np.float32(REACH) + row[15]
    return center - half, center + half


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one rectangle with rays.

    Parameters
    ----------
    data : View
        Table of rows.
    k : int
        Offset of the row, uniform.
    o, d : Vec3
        Origins and directions (of any length).
    t_max : float
        End of the rays.

    Returns
    -------
    t, u, v : float
        Ray parameter and local coordinates in [-1, 1].
    hit : mask
        0 < t <= t_max and inside.
    """
    t, x, y = meet_plane(data, k, o, d)
    inside = (absolute(x) <= REACH) & (absolute(y) <= REACH)
    return t, x, y, inside & (t > 0.0) & (t <= t_max)


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data = tables.data
    n = gather_vec3(data, k)
    p = point_on_plane(data, k, n, hit.t, o, d)
    s = gather_vec3(data, k + E1) * gather(data, k + 24)
    x = maximum(minimum(hit.u, 1.0), -1.0)
    y = maximum(minimum(hit.v, 1.0), -1.0)
    error = gather(data, k + 15)
    return Geometry(
        p=p,
        error=error,
        ng=n,
        ns=n,
        s=s,
        t=cross(n, s),
        u=0.5 * x + 0.5,
        v=0.5 * y + 0.5,
        color=lanes_vec3(1.0),
    )


@kernel
def seen_from(data, k, p):
    """The rectangle as `alight.core.warps` describes it; meaningless for a parallelogram.

    Seen from one of its own points it would fill half of all directions, and rounding would choose
    which half: a lamp whose back reflects would light it through itself. There points are chosen by
    area, and the cosine takes their light.
    """
    e1, e2 = gather_vec3(data, k + E1), gather_vec3(data, k + E2)
    corner = gather_vec3(data, k + CENTER) - e1 - e2
    seen = spherical_rectangle(corner, 2.0 * e1, 2.0 * e2, p)
    # Of the point, and of its distance from the plane.
    error = 2.0 * gather(data, k + 15) + ERROR * (seen.x1 - seen.x0 + seen.y1 - seen.y0)
    return replace(seen, by_area=seen.by_area | (seen.z0 <= error))


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point: uniform in the solid angle, on parallelograms uniform in the area.

    Parameters
    ----------
    tables : ShapeTables
    cdf, start, u
        Not used: for meshes.
    shape : uint32
        Index of the shape.
    p : Vec3
        Where it is seen from.
    u2 : tuple of 2 floats
        Uniform in [0, 1).

    Returns
    -------
    ShapeSample
    """
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    seen = seen_from(data, k, p)
    by_angle = square_to_spherical_rectangle(seen, u2)
    x, y = 2.0 * u2[0] - 1.0, 2.0 * u2[1] - 1.0
    by_area = flat_point(data, k, x, y) - p
    to_light = where(gather(data, k + IS_RECTANGLE) > 0.0, by_angle, by_area)
    squared = length_squared(to_light)
    per_distance = rsqrt(squared)
    distance, wi = squared * per_distance, to_light * per_distance
    cosine = -dot(wi, gather_vec3(data, k))
    density = density_of(data, k, seen, to_light, distance, cosine)
    return ShapeSample(wi, distance, cosine, gather(data, k + 15), density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    k = gather(tables.info, shape * INFO + 3)
    seen = seen_from(tables.data, k, p)
    return density_of(tables.data, k, seen, hit.distance * hit.wi, hit.distance, hit.cosine)


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose a point uniformly by area.

    Parameters
    ----------
    tables, cdf, start, shape, u, u2
        As for `sample`.

    Returns
    -------
    AreaSample
    """
    k = gather(tables.info, shape * INFO + 3)
    x, y = 2.0 * u2[0] - 1.0, 2.0 * u2[1] - 1.0
    p = flat_point(tables.data, k, x, y)
    return AreaSample(p, x, y, lanes_u32(0), 1.0 / gather(tables.data, k + AREA))


@kernel
def square(tables, cdf, start, shape, prim, q):
    """Where `sample_area` has a point q from: (x, y in [0, 1], density per square metre)."""
    k = gather(tables.info, shape * INFO + 3)
    x, y = local_coordinates(tables.data, k, q)
    return 0.5 * x + 0.5, 0.5 * y + 0.5, 1.0 / gather(tables.data, k + AREA)


@kernel
def density_of(data, k, seen, to_light, distance, cosine):
    """Density per solid angle of the point `to_light` away."""
    by_area = area_to_solid_angle(1.0 / gather(data, k + AREA), distance, cosine)
    by_angle = spherical_rectangle_pdf(seen, to_light)
    return where(gather(data, k + IS_RECTANGLE) > 0.0, by_angle, by_area)


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    # u and v run from 0 to 1 over twice the half edges.
    return 2.0 * gather_vec3(tables.data, k + E1), 2.0 * gather_vec3(tables.data, k + E2)


@kernel
def coordinates(tables, cdf, start, shape, q, u, u2):
    """Local coordinates of a sampled point q, as `intersect` reports them."""
    k = gather(tables.info, shape * INFO + 3)
    x, y = local_coordinates(tables.data, k, q)
    return x, y, lanes_u32(0)


def facing(row: np.ndarray) -> tuple[np.ndarray, float]:
    """The one outer normal."""
    return row[0:3].astype(float), 0.0
