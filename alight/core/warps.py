"""Maps from the unit square to the domains that renderers sample, each with its density.

`u2` is a pair of numbers in [0, 1). Densities are per steradian, per unit of area for the disk and
the triangle. Directions have unit length within 4 rounding errors.

Sources: Shirley and Chiu 1997 (concentric disk); PBR4 appendix A.5; Heitz 2019, A Low-Distortion
Map Between Triangle and Square; Urena, Fajardo and King 2013, An Area-Preserving Parametrization
for Spherical Rectangles.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_FOUR_PI, INV_PI, INV_TWO_PI, TWO_PI
from alight.core.maths import arctan2, sincos, sincos_2pi, sincos_octant
from alight.core.vec import Vec3, cross, dot
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    bits_float,
    copysign,
    float_bits,
    maximum,
    minimum,
    rsqrt,
    sqrt,
    where,
)

_QUARTER_PI = 0.785398163397448310


# ---------------------------------------------------------------- disk


@kernel
def square_to_disk_concentric(u2):
    """Point (x, y) of the unit disk; squares around the centre become circles (low distortion)."""
    a, b = 2.0 * u2[0] - 1.0, 2.0 * u2[1] - 1.0
    steep = absolute(a) > absolute(b)
    r = where(steep, a, b)
    ratio = where(steep, b, a) / where(r == 0.0, 1.0, r)
    s, c = sincos_octant(_QUARTER_PI * ratio)
    return r * where(steep, c, s), r * where(steep, s, c)


@kernel
def disk_to_square_concentric(x, y):
    """The numbers that `square_to_disk_concentric` takes to the point (x, y)."""
    steep = absolute(x) > absolute(y)
    along, across = where(steep, x, y), where(steep, y, x)
    r = copysign(sqrt(x * x + y * y), along)
    # The angle off the nearer axis, in [-pi / 4, pi / 4], over pi / 4.
    turned = arctan2(copysign(1.0, along) * across, absolute(along)) / _QUARTER_PI
    a, b = where(steep, r, r * turned), where(steep, r * turned, r)
    return 0.5 * a + 0.5, 0.5 * b + 0.5


@kernel
def square_to_disk_polar(u2):
    """Point (x, y) of the unit disk: radius sqrt(u2[0]), angle 2 pi u2[1]."""
    # The area within radius r is r^2 of the whole, so r is the square root.
    r = sqrt(u2[0])
    s, c = sincos_2pi(u2[1])
    return r * c, r * s


@kernel
def disk_pdf(x, y):
    """1 / pi per unit of area within the unit disk."""
    return where(x * x + y * y <= 1.0, INV_PI, 0.0)


# ---------------------------------------------------------------- hemisphere and sphere


@kernel
def square_to_cosine_hemisphere(u2):
    """Direction with z >= 0, density proportional to cos theta.

    Malley's method: a uniform point of the disk, projected up to the hemisphere.
    """
    x, y = square_to_disk_concentric(u2)
    return Vec3(x, y, sqrt(maximum(0.0, 1.0 - x * x - y * y)))


@kernel
def cosine_hemisphere_pdf(w):
    """cos theta / pi per steradian, above the surface."""
    return INV_PI * maximum(0.0, w.z)


@kernel
def direction_around_z(one_minus_z, u):
    """The unit direction with cosine 1 - one_minus_z against the z axis and azimuth 2 pi u."""
    # 1 - z^2 = (1 - z)(1 + z) does not cancel near the pole.
    r = sqrt(maximum(0.0, one_minus_z * (2.0 - one_minus_z)))
    s, c = sincos_2pi(u)
    return Vec3(r * c, r * s, 1.0 - one_minus_z)


@kernel
def square_to_uniform_hemisphere(u2):
    """Direction with z > 0, all equally likely."""
    return direction_around_z(u2[0], u2[1])


@kernel
def uniform_hemisphere_pdf(w):
    """1 / (2 pi) per steradian, above the surface."""
    return where(w.z > 0.0, INV_TWO_PI, 0.0)


@kernel
def square_to_uniform_sphere(u2):
    """Direction, all equally likely."""
    # The area of a zone depends on its height only (Archimedes).
    return direction_around_z(2.0 * u2[0], u2[1])


@kernel
def uniform_sphere_to_square(w):
    """The numbers that `square_to_uniform_sphere` takes to the unit direction w."""
    turn = arctan2(w.y, w.x) * INV_TWO_PI
    return 0.5 - 0.5 * w.z, where(turn < 0.0, turn + 1.0, turn)


@kernel
def uniform_sphere_pdf():
    """1 / (4 pi) per steradian."""
    return INV_FOUR_PI


@kernel
def square_to_uniform_cone(u2, one_minus_cos):
    """Direction within a cone about z, all equally likely.

    `one_minus_cos` = 1 - cos(half angle), in (0, 2]: narrow cones keep their accuracy.
    """
    return direction_around_z(u2[0] * one_minus_cos, u2[1])


@kernel
def uniform_cone_pdf(one_minus_cos):
    """1 / solid angle, per steradian, for directions within the cone."""
    return INV_TWO_PI / one_minus_cos


# ---------------------------------------------------------------- triangle


@kernel
def square_to_triangle(u2):
    """Barycentric coordinates (b1, b2) of a point of a triangle; density 1 / area."""
    # The square is folded along its diagonal, without tearing neighbours apart.
    a, b = 0.5 * u2[0], 0.5 * u2[1]
    d = b - a
    up = d > 0.0
    return where(up, a, a - d), where(up, b + d, b)


@kernel
def triangle_to_square(b1, b2):
    """The numbers that `square_to_triangle` takes to the barycentric coordinates (b1, b2)."""
    up, total = b2 > b1, b1 + b2
    return where(up, 2.0 * b1, total), where(up, total, 2.0 * b2)


# ---------------------------------------------------------------- spherical rectangle

#: A rectangle as seen from a point p. x, y: its unit directions, z its unit normal away from p;
#: x0 < x1, y0 < y1: its extent along them relative to p; z0 >= 0: distance of its plane; cosine,
#: sine: of the angle at which the sweep begins; solid_angle in steradians; area in square metres;
#: by_area: mask, the solid angle is too small to distinguish from rounding.
SphericalRectangle = namedtuple(
    "SphericalRectangle", "x y z x0 x1 y0 y1 z0 cosine sine solid_angle area by_area"
)

# The solid angle carries an absolute error of some 2^-22, from a dozen roundings. Below this it
# could be wrong by more than 2e-4; the rectangle is then so small, so far away or so steeply seen
# that sampling its area costs hardly any variance.
_SMALLEST_SOLID_ANGLE = 2e-3

_EXPONENT_BITS, _TWICE_BIAS = 0x7F800000, 0x7F000000


@kernel
def spherical_rectangle(corner, edge_x, edge_y, p):
    """The rectangle corner + [0, 1] edge_x + [0, 1] edge_y (edges at right angles) seen from p."""
    # Square roots and quotients by way of 1 / sqrt, for which processors have a fast instruction.
    width2, height2 = dot(edge_x, edge_x), dot(edge_y, edge_y)
    per_width, per_height = rsqrt(width2), rsqrt(height2)
    x, y = edge_x * per_width, edge_y * per_height
    width, height = width2 * per_width, height2 * per_height
    z = cross(x, y)
    d = corner - p
    distance = dot(d, z)
    z, z0 = where(distance < 0.0, -z, z), absolute(distance)
    x0, y0 = dot(d, x), dot(d, y)
    x1, y1 = x0 + width, y0 + height
    # Seen from p the rectangle is the difference of four with one corner at the foot of p, whose
    # solid angles are those of complex numbers: sums of angles are products.
    size = absolute(x0) + absolute(x1) + absolute(y0) + absolute(y1) + z0
    scale = _power_of_two_below_inverse(size)  # or products of eight lengths would overflow
    u0, u1, v0, v1, w = x0 * scale, x1 * scale, y0 * scale, y1 * scale, z0 * scale
    first = _times_conjugate(_corner(u1, v1, w), _corner(u1, v0, w))
    second = _times_conjugate(_corner(u0, v1, w), _corner(u0, v0, w))
    re, im = _times_conjugate(first, second)
    angle = arctan2(im, re)
    # Only a rectangle that p nearly touches shows more than half a sphere.
    around = (angle < 0.0) & (x0 * x1 < 0.0) & (y0 * y1 < 0.0)
    solid_angle = where(around, angle + TWO_PI, angle)
    per_length = rsqrt(maximum(second[0] * second[0] + second[1] * second[1], 1e-36))
    cosine, sine = second[0] * per_length, second[1] * per_length
    by_area = solid_angle <= _SMALLEST_SOLID_ANGLE
    return SphericalRectangle(
        x=x,
        y=y,
        z=z,
        x0=x0,
        x1=x1,
        y0=y0,
        y1=y1,
        z0=z0,
        cosine=cosine,
        sine=sine,
        solid_angle=solid_angle,
        area=width * height,
        by_area=by_area,
    )


@kernel
def _power_of_two_below_inverse(a):
    """2^-k where a = m 2^k with 1 <= m < 2: scaling by it is exact."""
    return bits_float(_TWICE_BIAS - (float_bits(a) & _EXPONENT_BITS))


@kernel
def _root(a):
    """sqrt(a), at least 1e-18."""
    a = maximum(a, 1e-36)
    return a * rsqrt(a)


@kernel
def _corner(x, y, z):
    """A complex number whose angle is the solid angle of [0, x] times [0, y] at distance z."""
    return z * _root(x * x + y * y + z * z), x * y


@kernel
def _times_conjugate(a, b):
    """The complex number a times the conjugate of b: its angle is the difference of theirs."""
    return a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]


@kernel
def _over_length(a, squared):
    """a / sqrt(a^2 + squared)."""
    return a * rsqrt(maximum(a * a + squared, 1e-36))


@kernel
def square_to_spherical_rectangle(rectangle, u2):
    """Vector from p to a point of the rectangle, uniform in the solid angle seen from p."""
    r = rectangle
    # The first number turns a plane through p that holds the y direction across the rectangle,
    # until it has swept that part of the solid angle: the angle of the sum above, from its start.
    s, c = sincos(u2[0] * r.solid_angle)
    c, s = c * r.cosine - s * r.sine, s * r.cosine + c * r.sine
    zz = r.z0 * r.z0
    # Normals of the planes through p and the sides y = y0 and y = y1: their z, and the first's y.
    b0, b1, e0 = -_over_length(r.y0, zz), _over_length(r.y1, zz), _over_length(r.z0, r.y0 * r.y0)
    # The equation of Urena et al. for x / z, multiplied out so that s may be zero.
    g = c * b0 + b1
    remainder = maximum((g - s * e0) * (g + s * e0), 1e-36)
    xu = r.z0 * where(g < 0.0, -s, s) * rsqrt(remainder)
    xu = minimum(maximum(xu, r.x0), r.x1)
    # The second one moves along the cut, uniform in the sine of the elevation.
    dd = xu * xu + zz
    h0, h1 = _over_length(r.y0, dd), _over_length(r.y1, dd)
    h = h0 + u2[1] * (h1 - h0)
    yv = h * rsqrt(maximum((1.0 - h) * (1.0 + h), 1e-36)) * _root(dd)
    yv = minimum(maximum(yv, r.y0), r.y1)
    xv = where(r.by_area, r.x0 + u2[0] * (r.x1 - r.x0), xu)
    yv = where(r.by_area, r.y0 + u2[1] * (r.y1 - r.y0), yv)
    return xv * r.x + yv * r.y + r.z0 * r.z


@kernel
def spherical_rectangle_pdf(rectangle, d):
    """Density per steradian of the point at p + d of the rectangle."""
    r = rectangle
    squared = dot(d, d)
    # Per area to per solid angle: dA cos theta / d^2 = d omega, with cos theta = z0 / d.
    projected = r.z0 * r.area
    by_area = projected > 0.0
    over = where(r.by_area, where(by_area, projected, 1.0), r.solid_angle)
    under = where(r.by_area, where(by_area, squared * _root(squared), 0.0), 1.0)
    return under / over
