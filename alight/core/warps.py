"""Maps from the unit square to the domains that renderers sample, each with its density.

`u2` is a pair of numbers in [0, 1). Densities are per steradian, per unit of area for the disk and
the triangle. Directions have unit length within 4 rounding errors.

Sources: Shirley and Chiu 1997 (concentric disk); PBR4 appendix A.5; Heitz 2019, A Low-Distortion
Map Between Triangle and Square; Urena, Fajardo and King 2013, An Area-Preserving Parametrization
for Spherical Rectangles.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_FOUR_PI, INV_PI, INV_TWO_PI
from alight.core.jit import kernel
from alight.core.maths import arctan2, sincos, sincos_2pi, sincos_octant
from alight.core.simd import absolute, maximum, minimum, sqrt, where
from alight.core.vec import Vec3, cross, dot

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


# ---------------------------------------------------------------- spherical rectangle

#: A rectangle as seen from a point p. x, y: its unit directions, z its unit normal away from p;
#: x0 < x1, y0 < y1: its extent along them relative to p; z0 < 0: minus the distance of its plane;
#: b0, b1: z of the unit normals of the planes through p and the sides y = y0 and y = y1;
#: start: angle at which the sweep begins; solid_angle in steradians; area in square metres;
#: by_area: mask, the solid angle is too small to be told from rounding.
SphericalRectangle = namedtuple(
    "SphericalRectangle", "x y z x0 x1 y0 y1 z0 b0 b1 start solid_angle area by_area"
)

# The four angles below carry relative errors of some 2^-23 each. Where what is left of them is less
# than this part, the solid angle could be wrong by more than 2e-4; the rectangle is then so small,
# or so far aside, that sampling its area costs hardly any variance.
_SMALLEST_SHARE = 1e-3


@kernel(strict=True)
def spherical_rectangle(corner, edge_x, edge_y, p):
    """The rectangle corner + [0, 1] edge_x + [0, 1] edge_y (edges at right angles) seen from p."""
    width, height = sqrt(dot(edge_x, edge_x)), sqrt(dot(edge_y, edge_y))
    x, y = edge_x * (1.0 / width), edge_y * (1.0 / height)
    z = cross(x, y)
    d = corner - p
    distance = dot(d, z)
    z = where(distance > 0.0, -z, z)
    z0 = -absolute(distance)
    x0, y0 = dot(d, x), dot(d, y)
    x1, y1 = x0 + width, y0 + height
    # Seen from p the rectangle is the difference of four with a corner at the foot of p, whose
    # solid angles have a closed form. Where that foot lies inside, nothing cancels.
    a00, a10 = _solid_angle_of_corner(x0, y0, z0), _solid_angle_of_corner(x1, y0, z0)
    a01, a11 = _solid_angle_of_corner(x0, y1, z0), _solid_angle_of_corner(x1, y1, z0)
    solid_angle = (a11 - a10) + (a00 - a01)
    sizes = (absolute(a00) + absolute(a10)) + (absolute(a01) + absolute(a11))
    by_area = solid_angle <= _SMALLEST_SHARE * sizes
    # Of the planes through p and the sides y = y0 and y = y1.
    b0, b1 = -_over_length(y0, z0 * z0), _over_length(y1, z0 * z0)
    area = width * height
    return SphericalRectangle(
        x, y, z, x0, x1, y0, y1, z0, b0, b1, a01 - a00, solid_angle, area, by_area
    )


@kernel(strict=True)
def _solid_angle_of_corner(x, y, z):
    """Of [0, x] times [0, y] at distance |z|, negative if x y is."""
    return arctan2(x * y, absolute(z) * sqrt(x * x + y * y + z * z))


@kernel(strict=True)
def _over_length(a, zz):
    """a / sqrt(a^2 + zz), 0 for 0 / 0."""
    squared = a * a + zz
    return where(squared > 0.0, a / sqrt(where(squared > 0.0, squared, 1.0)), 0.0)


@kernel(strict=True)
def square_to_spherical_rectangle(rectangle, u2):
    """Vector from p to a point of the rectangle, uniform in the solid angle seen from p."""
    r = rectangle
    # The first number sweeps a plane through p that holds the y direction over the rectangle.
    s, c = sincos(r.start + u2[0] * r.solid_angle)
    f = (c * r.b0 + r.b1) / where(s == 0.0, 1e-30, s)
    cu = 1.0 / sqrt(f * f + r.b0 * r.b0)
    cu = where(f > 0.0, cu, -cu)
    xu = -(cu * r.z0) / sqrt(maximum(1e-30, 1.0 - cu * cu))
    xu = minimum(maximum(xu, r.x0), r.x1)
    # The second one moves along the cut, uniform in the sine of the elevation.
    dd = xu * xu + r.z0 * r.z0
    h0, h1 = _over_length(r.y0, dd), _over_length(r.y1, dd)
    h = h0 + u2[1] * (h1 - h0)
    yv = h * sqrt(dd) / sqrt(maximum(1e-30, 1.0 - h * h))
    yv = minimum(maximum(yv, r.y0), r.y1)
    xv = where(r.by_area, r.x0 + u2[0] * (r.x1 - r.x0), xu)
    yv = where(r.by_area, r.y0 + u2[1] * (r.y1 - r.y0), yv)
    return xv * r.x + yv * r.y + r.z0 * r.z


@kernel(strict=True)
def spherical_rectangle_pdf(rectangle, d):
    """Density per steradian of the point at p + d of the rectangle."""
    r = rectangle
    squared = dot(d, d)
    # Per area to per solid angle: dA cos theta / d^2 = d omega, with cos theta = |z0| / d.
    projected = absolute(r.z0) * r.area
    flat = projected <= 0.0
    by_area = where(flat, 0.0, squared * sqrt(squared) / where(flat, 1.0, projected))
    by_angle = 1.0 / where(r.by_area, 1.0, r.solid_angle)
    return where(r.by_area, by_area, by_angle)
