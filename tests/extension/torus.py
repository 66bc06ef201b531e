r"""A user's shape, one file: the torus, a quartic.

.. math:: \left(\sqrt{x^2 + y^2} - R\right)^2 + z^2 = r^2

A transform makes it any affine image. Rays are intersected in the space of q = p / R with
a = r / R, from the point c of the ray that is nearest to the middle, along the unit direction d:

.. math:: f(s) = (s^2 + k)^2 - 4 (A s^2 + 2 B s + E), \quad k = c \cdot c + 1 - a^2

has no cubic term. Its three stationary points are bracketed by those of f', which are known;
between them f is monotone, and a change of sign is halved until float32 has no more digits.
"""

from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.constants import INV_TWO_PI, PI, TWO_PI, gamma
from alight.core.field_types import Positive
from alight.core.fields import invalid
from alight.core.frame import frame_from_tangent
from alight.core.maths import arctan2, sincos_2pi
from alight.core.spec import Shape
from alight.core.vec import Vec3, absolute_vec3, cross, dot, gather_vec3, length_squared, row_vec3
from alight.shapes.hit import INFO, Geometry, ShapeSample, area_to_solid_angle
from lanewise.jit import kernel
from lanewise.simd import gather, lanes, lanes_vec3, maximum, minimum, sqrt, where


class Torus(Shape):
    """Ring around z.

    Parameters
    ----------
    major, minor : float > 0, metres, defaults 1 and 0.3
        Radius of the circle in its middle, and of the tube; the first is the larger one.
    """

    closed: ClassVar[bool] = True
    type: Literal["torus"] = "torus"
    major: Positive = 1.0
    minor: Positive = 0.3

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.minor >= self.major:
            raise invalid(
                f"minor must be smaller than major, got {self.minor:g} and {self.major:g}"
            )
        return self


EXAMPLES = (Torus(), Torus(major=2.0, minor=0.2, flip_normals=True), Torus(minor=0.7))

#: Numbers of the row: middle, a, outer side, area, largest error in the space of q, the matrix from
#: the world to that, and its inverse.
STRIDE = 32
MINOR, SIDE, AREA, ERROR, INVERSE, MATRIX = 3, 4, 5, 6, 8, 17
HALVINGS = 28

#: Seen along its axis a ring of 4 pi R r, of 4 pi^2 R r in all.
PROJECTION = 1.0 / PI
GAMMA = gamma(24)


def pack(spec: Torus, matrix: np.ndarray) -> np.ndarray:
    """The row of the table."""
    placed, a = matrix[:3, :3] * spec.major, spec.minor / spec.major
    row = np.zeros(STRIDE)
    row[0:3], row[MINOR] = matrix[:3, 3], a
    row[SIDE] = -1.0 if spec.flip_normals else 1.0
    row[AREA] = _area_of(placed, a)
    # What rounding leaves of f, over its slope across the surface, 8 a (1 - a) at least.
    row[ERROR] = gamma(32) * (1.0 + a) ** 4 / (8.0 * a * (1.0 - a))
    row[INVERSE : INVERSE + 9] = np.linalg.inv(placed).ravel()
    row[MATRIX : MATRIX + 9] = placed.ravel()
    return row.astype(np.float32)


def _area_of(matrix: np.ndarray, a: float, n: int = 512) -> float:
    u, v = np.meshgrid(*2 * [(np.arange(n) + 0.5) * (2.0 * np.pi / n)])
    ring = 1.0 + a * np.cos(v)
    along = matrix @ np.stack([-ring * np.sin(u), ring * np.cos(u), 0.0 * u]).reshape(3, -1)
    across = np.stack([-np.sin(v) * np.cos(u), -np.sin(v) * np.sin(u), np.cos(v)]).reshape(3, -1)
    normal = np.cross(along, matrix @ (a * across), axis=0)
    return float(np.linalg.norm(normal, axis=0).mean() * 4.0 * np.pi**2)


def area(row: np.ndarray) -> float:
    """Surface area, m^2."""
    return float(row[AREA])


def bounds(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The box: how far the circle reaches along each axis, and the ball around its points."""
    m = row[MATRIX : MATRIX + 9].reshape(3, 3).astype(np.float64)
    half = np.hypot(m[:, 0], m[:, 1]) + row[MINOR] * np.linalg.norm(m, axis=1)
    half = half * (1.0 + 1e-6) + 1e-6 * np.abs(row[0:3])
    return (row[0:3] - half).astype(np.float32), (row[0:3] + half).astype(np.float32)


# ---------------------------------------------------------------- intersection


@kernel(strict=True)
def quartic(s, p2, p1, p0):
    """f by Horner's scheme."""
    return ((s * s + p2) * s + p1) * s + p0


@kernel(strict=True)
def stationary(low, high, p2, p1, rising):
    """Where f' = 4 s^3 + 2 p2 s + p1 changes its sign between two places; one of them if not."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        slope = (4.0 * middle * middle + 2.0 * p2) * middle + p1
        before = where(rising, slope < 0.0, slope > 0.0)
        low, high = where(before, middle, low), where(before, high, middle)
    return 0.5 * (low + high)


@kernel(strict=True)
def look(state, right, p2, p1, p0):
    """Bracket the first change of sign, if it lies before `right`: the state goes on from there."""
    found, low, high, f_low, left, f_left = state
    f_right = quartic(right, p2, p1, p0)
    falls, rises = (f_left > 0.0) & (f_right <= 0.0), (f_left < 0.0) & (f_right >= 0.0)
    crosses = ~found & (falls | rises)
    low, high = where(crosses, left, low), where(crosses, right, high)
    f_low = where(crosses, f_left, f_low)
    return found | crosses, low, high, f_low, right, f_right


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Nearest hits of rays; see `alight.shapes.rectangle.intersect`."""
    m0, m1 = row_vec3(data, k + INVERSE), row_vec3(data, k + INVERSE + 3)
    m2 = row_vec3(data, k + INVERSE + 6)
    f = o - row_vec3(data, k)
    offset = Vec3(dot(m0, f), dot(m1, f), dot(m2, f))
    w = Vec3(dot(m0, d), dot(m1, d), dot(m2, d))
    size = sqrt(length_squared(w))
    w = w * (1.0 / size)
    start = dot(offset, w)
    c = offset - start * w
    # Once more: c must be at right angles to w, however far the ray comes from.
    more = dot(c, w)
    c, start = c - more * w, start + more
    a = data[k + MINOR]
    m = length_squared(c)
    reach = (1.0 + a) * (1.0 + a) - m
    end = sqrt(maximum(reach, 0.0)) * 1.001
    k0 = m + 1.0 - a * a
    p2 = 2.0 * k0 - 4.0 * (w.x * w.x + w.y * w.y)
    p1 = -8.0 * (c.x * w.x + c.y * w.y)
    # f(0) as a product of two differences: near the surface it does not cancel.
    ring = 2.0 * sqrt(c.x * c.x + c.y * c.y)
    p0 = (k0 - ring) * (k0 + ring)
    turn = minimum(sqrt(maximum(p2 * (-1.0 / 6.0), 0.0)), end)
    s1 = stationary(-end, -turn, p2, p1, True)
    s2 = stationary(-turn, turn, p2, p1, False)
    s3 = stationary(turn, end, p2, p1, True)
    first = minimum(maximum(-end, start), end)
    low, high, found = first, first, reach < 0.0
    left, f_left = first, quartic(first, p2, p1, p0)
    state = (found, low, high, f_left, left, f_left)
    state = look(state, maximum(s1, first), p2, p1, p0)
    state = look(state, maximum(s2, first), p2, p1, p0)
    state = look(state, maximum(s3, first), p2, p1, p0)
    found, low, high, f_low, _, _ = look(state, end, p2, p1, p0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        value = quartic(middle, p2, p1, p0)
        before = where(f_low > 0.0, value > 0.0, value < 0.0)
        low, high = where(before, middle, low), where(before, high, middle)
    t = (0.5 * (low + high) - start) / size
    hit = (reach >= 0.0) & found & (t > 0.0) & (t <= t_max)
    return t, lanes(0.0), lanes(0.0), hit


# ---------------------------------------------------------------- surface


@kernel(strict=True)
def times(data, k, v):
    """The 3 x 3 matrix at k times v."""
    return Vec3(
        dot(gather_vec3(data, k), v),
        dot(gather_vec3(data, k + 3), v),
        dot(gather_vec3(data, k + 6), v),
    )


@kernel(strict=True)
def to_rows(data, k, v):
    """Its transpose times v."""
    sums = v.x * gather_vec3(data, k) + v.y * gather_vec3(data, k + 3)
    return sums + v.z * gather_vec3(data, k + 6)


@kernel(strict=True)
def at(data, k, p):
    """The point of the circle in the middle next to p, and the unit normal, in the space of q."""
    q = times(data, k + INVERSE, p - gather_vec3(data, k))
    scale = 1.0 / sqrt(maximum(q.x * q.x + q.y * q.y, 1e-30))
    middle = Vec3(q.x * scale, q.y * scale, 0.0 * q.z)
    n = q - middle
    return middle, n * (1.0 / sqrt(maximum(length_squared(n), 1e-30)))


@kernel(strict=True)
def slopes(a, e, n):
    """dq/du and dq/dv at the point of the circle e with the normal n."""
    out = e.x * n.x + e.y * n.y
    ring = TWO_PI * (1.0 + a * out)
    across = Vec3(-n.z * e.x, -n.z * e.y, out)
    return Vec3(-ring * e.y, ring * e.x, 0.0 * out), (TWO_PI * a) * across


@kernel(strict=True)
def error_at(data, k, p, n, gradient):
    """How far off the surface rounding may leave a hit at p."""
    reach = absolute_vec3(p) + absolute_vec3(gather_vec3(data, k))
    inside = dot(absolute_vec3(gradient), reach)
    return (gather(data, k + ERROR) + GAMMA * inside) / sqrt(length_squared(gradient))


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data = tables.data
    e, n = at(data, k, o + hit.t * d)
    a = gather(data, k + MINOR)
    p = gather_vec3(data, k) + times(data, k + MATRIX, e + a * n)
    gradient = to_rows(data, k + INVERSE, n)
    error = error_at(data, k, p, n, gradient)
    ng = gradient * (gather(data, k + SIDE) / sqrt(length_squared(gradient)))
    along, _ = slopes(a, e, n)
    s, t = frame_from_tangent(ng, times(data, k + MATRIX, along))
    u = arctan2(e.y, e.x) * INV_TWO_PI
    v = arctan2(n.z, e.x * n.x + e.y * n.y) * INV_TWO_PI
    u, v = where(u < 0.0, u + 1.0, u), where(v < 0.0, v + 1.0, v)
    return Geometry(p, error, ng, ng, s, t, u, v, lanes_vec3(1.0))


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    e, n = at(tables.data, k, surface.p)
    along, across = slopes(gather(tables.data, k + MINOR), e, n)
    return times(tables.data, k + MATRIX, along), times(tables.data, k + MATRIX, across)


# ---------------------------------------------------------------- sampling


@kernel
def area_density(data, k, e, n):
    """Density per area of both angles uniform: 1 / |dp/du x dp/dv|."""
    along, across = slopes(gather(data, k + MINOR), e, n)
    normal = cross(times(data, k + MATRIX, along), times(data, k + MATRIX, across))
    return 1.0 / sqrt(maximum(length_squared(normal), 1e-30))


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose both angles uniformly; see `alight.shapes.rectangle.sample`."""
    data, k = tables.data, gather(tables.info, shape * INFO + 3)
    sin_u, cos_u = sincos_2pi(u2[0])
    sin_v, cos_v = sincos_2pi(u2[1])
    e, n = Vec3(cos_u, sin_u, 0.0 * sin_u), Vec3(cos_u * cos_v, sin_u * cos_v, sin_v)
    q = gather_vec3(data, k) + times(data, k + MATRIX, e + gather(data, k + MINOR) * n)
    to_light = q - p
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / maximum(distance, 1e-30))
    gradient = to_rows(data, k + INVERSE, n)
    cosine = -dot(wi, gradient) * gather(data, k + SIDE) / sqrt(length_squared(gradient))
    density = area_to_solid_angle(area_density(data, k, e, n), distance, cosine)
    return ShapeSample(wi, distance, cosine, error_at(data, k, q, n, gradient), density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    data, k = tables.data, gather(tables.info, shape * INFO + 3)
    e, n = at(data, k, p + hit.distance * hit.wi)
    return area_to_solid_angle(area_density(data, k, e, n), hit.distance, hit.cosine)
