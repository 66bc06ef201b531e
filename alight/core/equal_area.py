r"""An equal-area map between the unit square and the sphere of directions.

The square is an octahedron unfolded: its inner diamond is the upper hemisphere, its corners are the
lower one. Within an octant the distance from the pole, :math:`r = \sqrt{1 - |z|}`, and the angle
are the coordinates, so that equal areas stay equal: a density per unit of area of the square is
:math:`4 \pi` times that per steradian. Neither poles nor edges stretch what is round by more than a
small factor.

Source: Clarberg, Fast equal-area mapping of the (hemi)sphere using SIMD, Journal of Graphics Tools
13(3), 2008.
"""

from __future__ import annotations

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.maths import arctan2, sincos_octant
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, copysign, maximum, minimum, sqrt, where

_QUARTER_PI = 0.785398163397448310
_TWO_OVER_PI = 0.636619772367581343


@kernel
def square_to_sphere(x, y):
    """The unit direction of the point (x, y) of [0, 1]^2."""
    a, b = 2.0 * x - 1.0, 2.0 * y - 1.0
    u, v = absolute(a), absolute(b)
    height = 1.0 - (u + v)
    r = 1.0 - absolute(height)
    # From the diagonal, an octant to either side.
    turn = where(r > 0.0, (v - u) / where(r > 0.0, r, 1.0), 0.0)
    s, c = sincos_octant(_QUARTER_PI * turn)
    # sin and cos of the angle that is pi / 4 more.
    ring = r * sqrt(maximum(2.0 - r * r, 0.0)) * 0.707106781186547524
    return Vec3(
        copysign(ring * (c - s), a), copysign(ring * (c + s), b), copysign(1.0 - r * r, height)
    )


@kernel
def around_edges(x, y):
    """The point of [0, 1)^2 of a point (x, y) that is up to 1/2 beyond it.

    The square's edges are seams of the octahedron: beyond one, the map goes on from the same edge,
    turned about its middle.
    """
    beyond = (x < 0.0) | (x >= 1.0)
    x, y = _folded(x), where(beyond, 1.0 - y, y)
    beyond = (y < 0.0) | (y >= 1.0)
    return _folded(where(beyond, 1.0 - x, x)), _folded(y)


@kernel
def _folded(x):
    x = where(x < 0.0, -x, x)
    return minimum(maximum(where(x >= 1.0, 2.0 - x, x), 0.0), ONE_MINUS_EPSILON)


@kernel
def sphere_to_square(w):
    """The point (x, y) of [0, 1)^2 of a unit direction."""
    u, v = absolute(w.x), absolute(w.y)
    angle = arctan2(v, u) * _TWO_OVER_PI
    # The same as sqrt(1 - |z|), without its cancellation near the poles.
    flat = u * u + v * v
    r = sqrt(flat / (1.0 + absolute(w.z)))
    b = angle * r
    a = r - b
    below = w.z < 0.0
    a, b = where(below, 1.0 - b, a), where(below, 1.0 - a, b)
    x, y = 0.5 + 0.5 * copysign(a, w.x), 0.5 + 0.5 * copysign(b, w.y)
    return (
        minimum(maximum(x, 0.0), ONE_MINUS_EPSILON),
        minimum(maximum(y, 0.0), ONE_MINUS_EPSILON),
    )
