r"""Cylinder: the points at distance `radius` from the axis between two points, open at both ends.

.. math:: p = c + A q, \qquad q = (\cos\varphi, \sin\varphi, z), \qquad z \in [0, 1]

c is the first point, the third column of A leads to the second one. A transform may make it
elliptic or slanted. Parameters are (u, v) = (phi / 2 pi, z), the normal points away from the axis.
Rows of the table:

=======  ======================================================================
0-2      c
5        1 or -1: the outer side, -1 if flipped
6, 7     1 / \|det A\|, area
8-16     M = A^-1, row by row
17-25    A, row by row
=======  ======================================================================

**Roots.** Rays are met in the space of q. With f = M (o - c) and w = M d, only the parts across the
axis count: a = w . w, b = -f . w and C = f . f - 1 give the roots q / a and C / q with
q = b + sign(b) sqrt(b^2 - a C), see `alight.shapes.sphere`. The nearest positive root whose z lies
in [0, 1] is the hit. A ray along the axis has a = 0 and infinite roots, whose z is not in there.

**Error bound.** As for an ellipsoid (`alight.shapes.sphere`), with the gradient of the radius in
the place of q: gamma(32) + sum \|n_i M_ij\| (gamma(4) \|p_j\| + gamma(12) (\|A\| \|q\|)_j) over
\|M^T n\|, with n = (cos phi, sin phi, 0).

Source: PBR4 section 6.3; canonical placement as in Mitsuba 3, its frame by Duff et al. 2017,
Building an orthonormal basis, revisited.
"""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.constants import INV_TWO_PI, PI, TWO_PI, gamma
from alight.core.field_types import Positive, Vector3
from alight.core.fields import invalid
from alight.core.frame import frame_from_tangent
from alight.core.maths import arctan2, sincos, sincos_2pi
from alight.core.spec import Shape
from alight.core.vec import Vec3, absolute_vec3, dot, gather_vec3, length_squared, row_vec3
from alight.shapes.flat import circle
from alight.shapes.hit import (
    INFO,
    AreaSample,
    Geometry,
    ShapeSample,
    area_to_solid_angle,
    needs_uv,
)
from alight.shapes.quadric import column, excess, from_center, times, transposed_times
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    copysign,
    fma,
    gather,
    lanes,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    where,
)


class Cylinder(Shape):
    """Open cylinder with outward normals.

    Parameters
    ----------
    p0, p1 : (3,) float, metres, defaults (0, 0, 0) and (0, 0, 1)
        Ends of the axis, in the space of its node; different.
    radius : float > 0, metres, default 1
        In the space of its node.
    flip_normals : bool, default False
        Point the normals inwards.
    """

    type: Literal["cylinder"] = "cylinder"
    p0: Vector3 = (0.0, 0.0, 0.0)
    p1: Vector3 = (0.0, 0.0, 1.0)
    radius: Positive = 1.0

    def edges(self) -> np.ndarray:
        """Points of the circles at both ends."""
        start, end = np.array(self.p0), np.array(self.p1)
        along = end - start
        around = self.radius * circle()[:, :2] @ np.stack(_across(along / np.linalg.norm(along)))
        return np.concatenate([start + around, end + around])

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        if self.p0 == self.p1:
            raise invalid(f"p0 and p1 must differ, got {list(self.p0)} for both")
        return self


EXAMPLES = (
    Cylinder(),
    Cylinder(p0=(1.0, -2.0, 3.0), p1=(1.5, 0.0, 2.0), radius=0.5),
    Cylinder(p1=(0.0, 0.0, 1e-2), radius=10.0, flip_normals=True),
)

STRIDE = 32

#: A rectangle, seen from the side.
PROJECTION = 1.0 / PI
SIDE, DENSITY, AREA, INVERSE, MATRIX = 5, 6, 7, 8, 17

_GAMMA_4, _GAMMA_12, _GAMMA_32 = gamma(4), gamma(12), gamma(32)

#: Angles at which the perimeter of an ellipse is summed up; the sum converges exponentially.
_ANGLES = 4096


def pack(spec: Cylinder, matrix: np.ndarray) -> np.ndarray:
    """The row of the table from the (4, 4) float64 matrix, object to world."""
    p0, axis = np.asarray(spec.p0), np.subtract(spec.p1, spec.p0)
    s, t = _across(axis / np.linalg.norm(axis))
    placed = matrix[:3, :3] @ np.stack([spec.radius * s, spec.radius * t, axis], axis=1)
    row = np.zeros(STRIDE)
    row[0:3] = matrix[:3, :3] @ p0 + matrix[:3, 3]
    row[5] = -1.0 if spec.flip_normals else 1.0
    row[6:8] = 1.0 / abs(np.linalg.det(placed)), mantle_area(placed)
    row[8:17], row[17:26] = np.linalg.inv(placed).ravel(), placed.ravel()
    return row.astype(np.float32)


def _across(n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors at right angles to n, where Mitsuba has its x and y."""
    x, y, z = (float(component) for component in n)
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return (
        np.array([1.0 + sign * x * x * a, sign * b, -sign * x]),
        np.array([b, sign + y * y * a, -y]),
    )


def mantle_area(matrix: np.ndarray) -> float:
    """Area of the image of the unit cylinder under a 3 x 3 matrix, m^2."""
    phi = (np.arange(_ANGLES) + 0.5) * (2.0 * np.pi / _ANGLES)
    along = matrix[:, :1] * -np.sin(phi) + matrix[:, 1:2] * np.cos(phi)
    heights = np.linalg.norm(np.cross(along, matrix[:, 2:3], axis=0), axis=0)
    return float(2.0 * np.pi * heights.mean())


def area(row: np.ndarray) -> float:
    """Surface area in m^2 from a packed row."""
    return float(row[AREA])


def bounds(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the bounding box from a packed row."""
    matrix, c = row[17:26].reshape(3, 3).astype(np.float64), row[0:3].astype(np.float64)
    axis = matrix[:, 2]
    # |x e1 + y e2| <= hypot(e1, e2) on the unit circle.
    half = np.hypot(matrix[:, 0], matrix[:, 1])
    margin = 1e-6 * (half + np.abs(axis)) + 4e-7 * np.abs(c)
    low = c + np.minimum(axis, 0.0) - half - margin
    high = c + np.maximum(axis, 0.0) + half + margin
    return low.astype(np.float32), high.astype(np.float32)


# ---------------------------------------------------------------- intersection


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one cylinder with rays; see `alight.shapes.rectangle.intersect`.

    Local coordinates are not needed: u and v are 0.
    """
    m0, m1, m2 = row_vec3(data, k + 8), row_vec3(data, k + 11), row_vec3(data, k + 14)
    offset, _ = from_center(o, row_vec3(data, k))
    f = Vec3(dot(m0, offset), dot(m1, offset), 0.0 * offset.x)
    w = Vec3(dot(m0, d), dot(m1, d), 0.0 * d.x)
    height, rate = dot(m2, offset), dot(m2, d)
    a, b, ff = dot(w, w), -dot(f, w), dot(f, f)
    c = excess(f, 0.0 * f, 1.0)
    # Far away b^2 - a C cancels; the distance of the ray from the axis does not.
    nearest = f + (b / a) * w
    far = a * (1.0 - dot(nearest, nearest))
    discriminant = where(ff < 16.0, b * b - a * c, far)
    q = b + copysign(sqrt(maximum(discriminant, 0.0)), b)
    t0, t1 = c / q, q / a
    first, last = minimum(t0, t1), maximum(t0, t1)
    z_first, z_last = fma(first, rate, height), fma(last, rate, height)
    first_hits = (first > 0.0) & (z_first >= 0.0) & (z_first <= 1.0)
    last_hits = (last > 0.0) & (z_last >= 0.0) & (z_last <= 1.0)
    t = where(first_hits, first, last)
    hit = (discriminant >= 0.0) & (first_hits | last_hits) & (t <= t_max)
    return t, lanes(0.0), lanes(0.0), hit


# ---------------------------------------------------------------- surface


@kernel(strict=True)
def local_point(data, k, p):
    """The q of a point p on the surface or very near it."""
    q = times(data, k + INVERSE, p - gather_vec3(data, k))
    scale = 1.0 / sqrt(q.x * q.x + q.y * q.y)
    return Vec3(q.x * scale, q.y * scale, q.z)


@kernel(strict=True)
def error_at(data, k, p, q, n):
    """The error bound at p, along the gradient M^T n, not yet divided by its length."""
    na, qa = absolute_vec3(n), absolute_vec3(q)
    weight = Vec3(
        dot(na, absolute_vec3(column(data, k + INVERSE))),
        dot(na, absolute_vec3(column(data, k + INVERSE + 1))),
        dot(na, absolute_vec3(column(data, k + INVERSE + 2))),
    )
    reach = Vec3(
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX))),
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX + 3))),
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX + 6))),
    )
    return _GAMMA_4 * dot(weight, absolute_vec3(p)) + _GAMMA_12 * dot(weight, reach) + _GAMMA_32


@specialised
def turn_of(program):
    """``turn_of(q)``: phi / 2 pi in [0, 1), where the program reads it."""
    if not needs_uv(program):

        @kernel
        def unused(q):
            return lanes(0.0)

        return unused

    @kernel
    def angle(q):
        turn = arctan2(q.y, q.x) * INV_TWO_PI
        return where(turn < 0.0, turn + 1.0, turn)

    return angle


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data = tables.data
    t = hit.t
    q = local_point(data, k, Vec3(fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z)))
    p = gather_vec3(data, k) + times(data, k + MATRIX, q)
    across = Vec3(q.x, q.y, lanes(0.0))
    gradient = transposed_times(data, k + INVERSE, across)
    size = sqrt(dot(gradient, gradient))
    error = error_at(data, k, p, q, across) / size
    n = gradient * (gather(data, k + SIDE) / size)
    # dp/dphi = A (-y, x, 0)
    s, t = frame_from_tangent(n, times(data, k + MATRIX, Vec3(-q.y, q.x, lanes(0.0))))
    return Geometry(
        p=p, error=error, ng=n, ns=n, s=s, t=t, u=turn_of(q), v=q.z, color=lanes_vec3(1.0)
    )


# ---------------------------------------------------------------- sampling


@kernel
def area_density(data, k, q):
    """Density per area of A q for q uniform on the unit cylinder: 1 / (2 pi |det A| |M^T n|)."""
    n = Vec3(q.x, q.y, lanes(0.0))
    stretch = sqrt(length_squared(transposed_times(data, k + INVERSE, n)))
    return INV_TWO_PI * gather(data, k + DENSITY) / stretch


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point, the image of a uniform one; see `alight.shapes.rectangle.sample`."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    sine, cosine = sincos_2pi(u2[0])
    q = Vec3(cosine, sine, u2[1])
    to_light = gather_vec3(data, k) - p + times(data, k + MATRIX, q)
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / maximum(distance, 1e-30))
    n = transposed_times(data, k + INVERSE, Vec3(cosine, sine, lanes(0.0)))
    cos_light = -dot(wi, n) * gather(data, k + SIDE) / sqrt(length_squared(n))
    density = area_to_solid_angle(area_density(data, k, q), distance, cos_light)
    error = _GAMMA_12 * dot(absolute_vec3(gather_vec3(data, k)), lanes_vec3(1.0))
    reach = absolute_vec3(gather_vec3(data, k + MATRIX))
    reach = reach + absolute_vec3(gather_vec3(data, k + MATRIX + 3))
    reach = reach + absolute_vec3(gather_vec3(data, k + MATRIX + 6))
    error = error + _GAMMA_32 * dot(reach, lanes_vec3(1.0))
    return ShapeSample(wi, distance, cos_light, error, density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    q = local_point(data, k, p + hit.distance * hit.wi)
    return area_to_solid_angle(area_density(data, k, q), hit.distance, hit.cosine)


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose the image of a uniform point; see `alight.shapes.rectangle.sample_area`."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    sine, cosine = sincos_2pi(u2[0])
    q = Vec3(cosine, sine, u2[1])
    p = gather_vec3(data, k) + times(data, k + MATRIX, q)
    return AreaSample(p, lanes(0.0), lanes(0.0), lanes_u32(0), area_density(data, k, q))


@kernel
def square(tables, cdf, start, shape, prim, q):
    """Where `sample_area` has a point q from; see `alight.shapes.rectangle.square`."""
    k = gather(tables.info, shape * INFO + 3)
    w = local_point(tables.data, k, q)
    turn = arctan2(w.y, w.x) * INV_TWO_PI
    turn = where(turn < 0.0, turn + 1.0, turn)
    return turn, w.z, area_density(tables.data, k, w)


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    s, c = sincos(TWO_PI * surface.u)
    around, up = Vec3(-TWO_PI * s, TWO_PI * c, lanes(0.0)), Vec3(0.0 * s, 0.0 * s, lanes(1.0))
    k = k + MATRIX
    return times(tables.data, k, around), times(tables.data, k, up)
