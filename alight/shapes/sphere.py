r"""Sphere: the points at distance `radius` from `center`.

.. math:: |p - c|^2 = r^2, \qquad n = (p - c) / r

A transform makes it an ellipsoid :math:`p = c + A q` with \|q\| = 1, met as a unit sphere in the
space of q. True spheres are met in world space. Rows of the table:

=======  ======================================================================
0-3      center, radius (1 for an ellipsoid)
4, 5     1 for an ellipsoid, else 0; 1 or -1: the outer side, -1 if flipped
6, 7     1 / \|det A\|, area
8-16     M = A^-1, row by row
17-25    A, row by row
=======  ======================================================================

**Roots.** With f = o - c, a = d . d, b = -f . d and C = f . f - r^2, the roots are q / a and C / q
with q = b + sign(b) sqrt(b^2 - a C), which never cancels. What does cancel:

- C, for an origin near the surface. It is formed in twice the precision (error-free sums and
  products), so that a sphere of radius 1e4 knows on which side of it a point lies to 1e-9 m.
- b^2 - a C, for a sphere that is small and far. There a (r^2 - \|f + (b / a) d\|^2) is used, a
  distance instead of a difference of squares (Haines et al. 2019).

**Error bound.** A hit o + t d is moved along the normal by g = \|f\| - r = C / (\|f\| + r), with
the exact C: left are the rounding of p and of the moved origin, gamma(4) sum \|n_i p_i\|, of the
step, gamma(8) \|g\|, and of C, 64 epsilon^2 r. A ray that leaves along a tangent has b within
rounding of 0 and C > 0, so that no root is found. The bound grows with the distance from the
*origin of the world*, not with the radius: near the origin, a ground sphere of 1e4 m is as fine as
a floor. For an ellipsoid C has no exact form. Its error and that of q = M (p - c), at most
gamma(32) + sum \|q_i M_ij\| (gamma(4) \|p_j\| + gamma(12) (\|A\| \|q\|)_j), go to world space by
1 / \|M^T q\|.

Sources: PBR4 sections 6.2 and 6.8; Haines, Günther and Akenine-Möller 2019, Precision Improvements
for Ray/Sphere Intersection, Ray Tracing Gems, chapter 7; Ogita, Rump and Oishi 2005, Accurate Sum
and Dot Product, for the error-free steps; Shirley, Wang and Zimmerman 1996, Monte Carlo Techniques
for Direct Lighting Calculations, for sampling the cone.
"""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np

from alight.core.constants import (
    INV_PI,
    INV_TWO_PI,
    MACHINE_EPSILON,
    PI,
    TWO_PI,
    gamma,
)
from alight.core.field_types import Positive, Vector3
from alight.core.frame import frame_from_normal, frame_from_tangent, to_world
from alight.core.maths import arccos, arctan2, sincos
from alight.core.spec import Shape
from alight.core.vec import (
    Vec3,
    absolute_vec3,
    dot,
    gather_vec3,
    length_squared,
    row_vec3,
)
from alight.core.warps import square_to_uniform_cone, square_to_uniform_sphere, uniform_cone_pdf
from alight.shapes.ellipsoid import INVERSE, area_density
from alight.shapes.ellipsoid import square as square
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
    any_lane,
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


class Sphere(Shape):
    """Sphere with outward normals.

    Parameters
    ----------
    center : (3,) float, metres, default origin
        In the space of its node.
    radius : float > 0, metres, default 1
        In the space of its node.
    flip_normals : bool, default False
        Point the normals inwards.
    """

    closed: ClassVar[bool] = True
    type: Literal["sphere"] = "sphere"
    center: Vector3 = (0.0, 0.0, 0.0)
    radius: Positive = 1.0


EXAMPLES = (
    Sphere(),
    Sphere(center=(1.0, -2.0, 3.0), radius=0.5),
    Sphere(radius=1e-3, flip_normals=True),
    Sphere(radius=1e4),
)

STRIDE = 32

#: A disk of its radius.
PROJECTION = 0.25
KNOWS_VIEW = True
IS_ELLIPSOID, SIDE, AREA, MATRIX = 4, 5, 7, 17

_GAMMA_4, _GAMMA_8, _GAMMA_12, _GAMMA_32 = gamma(4), gamma(8), gamma(12), gamma(32)
_SQUARED = 64.0 * MACHINE_EPSILON * MACHINE_EPSILON

#: Seen from within this part of the radius, the cone is nearly a half space and its opening angle
#: mostly rounding: points are chosen by area.
NEAREST = 2.0**-14


def pack(spec: Sphere, matrix: np.ndarray) -> np.ndarray:
    """The row of the table from the (4, 4) float64 matrix, object to world."""
    placed = matrix[:3, :3] * spec.radius
    center = matrix[:3, :3] @ np.asarray(spec.center) + matrix[:3, 3]
    metric = placed.T @ placed
    radius = np.sqrt(np.trace(metric) / 3.0)
    round_ = np.abs(metric - radius**2 * np.eye(3)).max() <= 1e-6 * radius**2
    row = np.zeros(STRIDE)
    row[0:3], row[3] = center, radius if round_ else 1.0
    row[4:6] = not round_, -1.0 if spec.flip_normals else 1.0
    row[6:8] = 1.0 / abs(np.linalg.det(placed)), ellipsoid_area(placed)
    row[8:17], row[17:26] = np.linalg.inv(placed).ravel(), placed.ravel()
    return row.astype(np.float32)


def ellipsoid_area(matrix: np.ndarray) -> float:
    r"""Area of the image of the unit sphere under a 3 x 3 matrix, m^2.

    With half axes a, b, c it is :math:`4 \pi R_G(a^2 b^2, a^2 c^2, b^2 c^2)`: R_G is the mean of
    the stretch :math:`|\det A| \, |A^{-T} q|` over the unit sphere.

    Notes
    -----
    Carlson 1995, Numerical computation of real or complex elliptic integrals: R_F and R_D by
    duplication, R_G from the two.
    """
    a, b, c = np.linalg.svd(matrix, compute_uv=False)
    scale = (a * b) ** 2
    x, y, z = sorted((float((b * c) ** 2 / scale), float((a * c) ** 2 / scale), 1.0))
    total, power, parts = 0.0, 1.0, (x, y, z)
    # Each step brings the three closer by a factor of 4. NumPy takes four times as long for three.
    for _ in range(40):
        root_x, root_y, root_z = map(math.sqrt, parts)
        step = root_x * root_y + root_y * root_z + root_z * root_x
        total += power / (root_z * (parts[2] + step))
        power, parts = power / 4.0, tuple((part + step) / 4.0 for part in parts)
    r_f = 1.0 / np.sqrt(parts[2])
    r_d = 3.0 * total + power / parts[2] ** 1.5
    r_g = 0.5 * (z * r_f - (x - z) * (y - z) * r_d / 3.0 + np.sqrt(x * y / z))
    return float(4.0 * np.pi * a * b * r_g)


def area(row: np.ndarray) -> float:
    """Surface area in m^2 from a packed row."""
    return float(row[AREA])


def bounds(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the bounding box from a packed row."""
    # The row of A is the gradient of a coordinate over the unit sphere.
    half = np.linalg.norm(row[17:26].reshape(3, 3).astype(np.float64), axis=1)
    half = half * (1.0 + 1e-6) + 4e-7 * np.abs(row[0:3])
    return (row[0:3] - half).astype(np.float32), (row[0:3] + half).astype(np.float32)


# ---------------------------------------------------------------- intersection


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one sphere or ellipsoid with rays; see `alight.shapes.rectangle.intersect`.

    Local coordinates are not needed: u and v are 0.
    """
    radius = data[k + 3]
    f, low = from_center(o, row_vec3(data, k))
    if data[k + 4] != 0.0:
        m0, m1 = row_vec3(data, k + 8), row_vec3(data, k + 11)
        m2 = row_vec3(data, k + 14)
        f = Vec3(dot(m0, f), dot(m1, f), dot(m2, f))
        d = Vec3(dot(m0, d), dot(m1, d), dot(m2, d))
        low = 0.0 * low
    a, b, ff = dot(d, d), -dot(f, d), dot(f, f)
    c = excess(f, low, radius)
    nearest = f + (b / a) * d
    far = a * (radius * radius - dot(nearest, nearest))
    discriminant = where(ff < 16.0 * radius * radius, b * b - a * c, far)
    q = b + copysign(sqrt(maximum(discriminant, 0.0)), b)
    t0, t1 = c / q, q / a
    first, last = minimum(t0, t1), maximum(t0, t1)
    t = where(first > 0.0, first, last)
    return t, lanes(0.0), lanes(0.0), (discriminant >= 0.0) & (t > 0.0) & (t <= t_max)


# ---------------------------------------------------------------- surface


@kernel(strict=True)
def on_sphere(data, k, o, d, t):
    """Point, unit outward normal, point of the unit sphere and error bound, for true spheres."""
    center, radius = gather_vec3(data, k), gather(data, k + 3)
    p = Vec3(fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z))
    f, low = from_center(p, center)
    size = sqrt(dot(f, f))
    n = f * (1.0 / size)
    step = excess(f, low, radius) / (size + radius)
    p = p - step * n
    error = _GAMMA_4 * dot(absolute_vec3(n), absolute_vec3(p)) + _SQUARED * radius
    return p, n, times(data, k + INVERSE, f), error + _GAMMA_8 * maximum(step, -step)


@kernel(strict=True)
def on_ellipsoid(data, k, o, d, t):
    """The same for ellipsoids."""
    f = Vec3(fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z)) - gather_vec3(data, k)
    q = times(data, k + INVERSE, f)
    q = q * (1.0 / sqrt(dot(q, q)))
    p = gather_vec3(data, k) + times(data, k + MATRIX, q)
    gradient = transposed_times(data, k + INVERSE, q)
    size = sqrt(dot(gradient, gradient))
    qa = absolute_vec3(q)
    weight = Vec3(
        dot(qa, absolute_vec3(column(data, k + INVERSE))),
        dot(qa, absolute_vec3(column(data, k + INVERSE + 1))),
        dot(qa, absolute_vec3(column(data, k + INVERSE + 2))),
    )
    reach = Vec3(
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX))),
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX + 3))),
        dot(qa, absolute_vec3(gather_vec3(data, k + MATRIX + 6))),
    )
    error = _GAMMA_4 * dot(weight, absolute_vec3(p)) + _GAMMA_12 * dot(weight, reach) + _GAMMA_32
    return p, gradient * (1.0 / size), q, error / size


@specialised
def local_uv(program):
    """``local_uv(q)``: (phi / 2 pi, theta / pi) of a unit vector, where the program reads them."""
    if not needs_uv(program):

        @kernel
        def unused(q):
            return lanes(0.0), lanes(0.0)

        return unused

    @kernel
    def angles(q):
        u = arctan2(q.y, q.x) * INV_TWO_PI
        return where(u < 0.0, u + 1.0, u), arccos(q.z) * INV_PI

    return angles


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data = tables.data
    p, n, q, error = on_sphere(data, k, o, d, hit.t)
    stretched = gather(data, k + IS_ELLIPSOID) > 0.0
    if any_lane(stretched):
        p1, n1, q1, error1 = on_ellipsoid(data, k, o, d, hit.t)
        p, n, q = where(stretched, p1, p), where(stretched, n1, n), where(stretched, q1, q)
        error = where(stretched, error1, error)
    n = n * gather(data, k + SIDE)
    # dp/du = A (dq / dphi); at the poles it vanishes, and any tangent will do.
    s, t = frame_from_tangent(n, times(data, k + MATRIX, Vec3(-q.y, q.x, 0.0)))
    u, v = local_uv(q)
    return Geometry(p=p, error=error, ng=n, ns=n, s=s, t=t, u=u, v=v, color=lanes_vec3(1.0))


# ---------------------------------------------------------------- sampling


@kernel
def cone_of(data, k, p):
    """How a true sphere is seen from p.

    Returns
    -------
    f : Vec3
        From p to the centre.
    squared : float
        |f|^2.
    sin2 : float
        Squared sine of the half angle of the cone around the sphere.
    one_minus_cos : float
    by_cone : mask
        p lies outside, far enough; true for no ellipsoid.
    """
    f, radius = gather_vec3(data, k) - p, gather(data, k + 3)
    squared, r2 = length_squared(f), radius * radius
    by_cone = (squared > r2 * (1.0 + NEAREST)) & (gather(data, k + IS_ELLIPSOID) <= 0.0)
    sin2 = where(by_cone, r2 / where(by_cone, squared, 1.0), 0.5)
    return f, squared, sin2, sin2 / (1.0 + sqrt(1.0 - sin2)), by_cone


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point; see `alight.shapes.rectangle.sample`.

    True spheres seen from outside: uniform in the cone of directions that meet them. From inside or
    very near, and ellipsoids: the image of a uniform point of the unit sphere.
    """
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    f, squared, sin2, one_minus_cos, by_cone = cone_of(data, k, p)
    # Cone: with x = 1 - cos(theta) = u one_minus_cos, sin^2(theta) = x (2 - x) has no cancellation.
    size = sqrt(squared)
    axis = f * (1.0 / maximum(size, 1e-30))
    s, t = frame_from_normal(axis)
    w = to_world(s, t, axis, square_to_uniform_cone(u2, one_minus_cos))
    x = u2[0] * one_minus_cos
    # Law of sines: the sine of the angle at the sphere is sin(theta) |f| / r.
    cos_light = sqrt(maximum(0.0, 1.0 - x * (2.0 - x) / sin2))
    distance = size * (1.0 - x) - gather(data, k + 3) * cos_light
    # Area.
    q = square_to_uniform_sphere(u2)
    to_light = f + times(data, k + MATRIX, q)
    n = transposed_times(data, k + INVERSE, q)
    length = sqrt(length_squared(to_light))
    w1 = to_light * (1.0 / maximum(length, 1e-30))
    cos1 = -dot(w1, n) / sqrt(length_squared(n))
    distance = where(by_cone, distance, length)
    cosine = where(by_cone, cos_light, cos1)
    by_area = area_to_solid_angle(area_density(data, k, q), length, cos1)
    density = where(by_cone, uniform_cone_pdf(one_minus_cos), by_area)
    error = _GAMMA_12 * dot(absolute_vec3(gather_vec3(data, k)), lanes_vec3(1.0))
    reach = absolute_vec3(gather_vec3(data, k + MATRIX))
    reach = reach + absolute_vec3(gather_vec3(data, k + MATRIX + 3))
    reach = reach + absolute_vec3(gather_vec3(data, k + MATRIX + 6))
    error = error + _GAMMA_32 * dot(reach, lanes_vec3(1.0))
    return ShapeSample(
        where(by_cone, w, w1), distance, cosine * gather(data, k + SIDE), error, density
    )


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    f, _, _, one_minus_cos, by_cone = cone_of(data, k, p)
    q = times(data, k + INVERSE, hit.distance * hit.wi - f)
    q = q * (1.0 / sqrt(length_squared(q)))
    by_area = area_to_solid_angle(area_density(data, k, q), hit.distance, hit.cosine)
    return where(by_cone, uniform_cone_pdf(one_minus_cos), by_area)


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose the image of a uniform point; see `alight.shapes.rectangle.sample_area`.

    Uniform by area on true spheres.
    """
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    q = square_to_uniform_sphere(u2)
    p = gather_vec3(data, k) + times(data, k + MATRIX, q)
    return AreaSample(p, lanes(0.0), lanes(0.0), lanes_u32(0), area_density(data, k, q))


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    s, c = sincos(TWO_PI * surface.u)
    sine, cosine = sincos(PI * surface.v)
    around = Vec3(-TWO_PI * sine * s, TWO_PI * sine * c, lanes(0.0))
    down = Vec3(PI * cosine * c, PI * cosine * s, -PI * sine)
    k = k + MATRIX
    return times(tables.data, k, around), times(tables.data, k, down)
