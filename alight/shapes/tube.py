r"""Rays against tubes: a circle that is swept along a cubic, at right angles to it.

.. math:: |q| = r(u), \quad q \cdot c'(u) = 0, \qquad q = o + t d - c(u)

Only what a ray *enters* counts: tubes have no inside.

**Search.** A tube is divided into `PIECES` by its parameter. In the space of the ray, whose z axis
is the ray itself, a piece can be met only if its chord passes the axis within the radius and what
the curve may bend away from the chord. From the nearest point of the chord on, the ray meets the
cone that touches the tube at u, a quadratic in t; Newton's method takes the height of that point
over the circle at u to 0. All is elementwise: in lists the lanes are rays, in the tree they are the
pieces of one tube.

**Quadratic.** With x = t - c_z, D = c_x^2 + c_y^2, T = c', L = T . T, g = c_x T_x + c_y T_y, the
height over the circle is y = (x T_z - g) / L, and |q|^2 - L y^2 = (r + r' y)^2 is
A x^2 + 2 B x + C = 0 with a = T_z / L, b = g / L, k = L + r'^2 and

.. math::
    A = 1 - k a^2, \quad B = a (k b - r r'), \quad C = D - b (k b - 2 r r') - r^2.

The ray enters where the left side falls, at x = (-B - w) / A = C / (w - B) with
w^2 = B^2 - A C, whatever the sign of A.

Sources: Reshetov and Luebke 2018, Phantom ray-hair intersector, for cones that march along the
curve; Reshetov 2017, Exploiting Budan-Fourier and Vincent's theorems for ray tracing 3D Bezier
curves, for circles at right angles to it; Nakamaru and Ohno 2002, Ray tracing for curves primitive,
for the space of the ray; Duff et al. 2017, Building an orthonormal basis, revisited.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    any_lane,
    copysign,
    maximum,
    minimum,
    sqrt,
    where,
)

#: Pieces that a tube is searched in.
PIECES = 16

#: A cubic c0 + u c1 + u^2 c2 + u^3 c3 in the space of a ray, and the same of its radius; slack: how
#: far it bends away from the chord of a piece, metres.
Tube = namedtuple("Tube", "c0 c1 c2 c3 r0 r1 r2 r3 slack")

#: The axes of a ray's space, and one over the length of its direction.
RaySpace = namedtuple("RaySpace", "s t w inverse")

#: Where the search in a piece stands. u; height: where the ray enters, from c_z on; going: lanes
#: that search; found: those that have.
Search = namedtuple("Search", "u height going found")

#: Beyond its ends a tube goes on by this part of its parameter, so that no ray slips between two.
BEYOND = 2.0**-12

#: A piece is searched this far beyond its ends.
MARGIN = 0.25 / PIECES

#: Steps of Newton's method at most, and the last one; its cone leaves the tube by `EXACT` radii at
#: most, which is less than the error bound of the hit: rays that go on meet no place again.
STEPS, LAST, EXACT = 10, 2.0**-12, 2.0**-20

#: Where the circle moves by less than this part of what its centre does, the surface nearly folds:
#: Newton's method is slow there, and its last step is `LAST_OF_FOLD`.
FOLD, LAST_OF_FOLD = 0.25, 2.0**-20


@kernel(strict=True)
def along(a, b):
    """The dot product, in the same order of operations whatever the lanes are."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel(strict=True)
def ray_space(d):
    """The `RaySpace` of a direction."""
    inverse = 1.0 / sqrt(along(d, d))
    w = Vec3(d.x * inverse, d.y * inverse, d.z * inverse)
    sign = copysign(1.0, w.z)
    a = -1.0 / (sign + w.z)
    b = w.x * w.y * a
    s = Vec3(1.0 + sign * w.x * w.x * a, sign * b, -sign * w.x)
    t = Vec3(b, sign + w.y * w.y * a, -w.y)
    return RaySpace(s, t, w, inverse)


@kernel(strict=True)
def into(space, v):
    """A vector in the space of a ray."""
    return Vec3(along(v, space.s), along(v, space.t), along(v, space.w))


@kernel(strict=True)
def cubic(c0, c1, c2, c3, u):
    """c0 + u c1 + u^2 c2 + u^3 c3."""
    return c0 + u * (c1 + u * (c2 + u * c3))


@kernel(strict=True)
def slope(c1, c2, c3, u):
    """The derivative of a cubic."""
    return c1 + u * (2.0 * c2 + u * (3.0 * c3))


@kernel(strict=True)
def center_at(tube, u):
    """A point of the curve."""
    c0, c1, c2, c3 = tube.c0, tube.c1, tube.c2, tube.c3
    return Vec3(
        cubic(c0.x, c1.x, c2.x, c3.x, u),
        cubic(c0.y, c1.y, c2.y, c3.y, u),
        cubic(c0.z, c1.z, c2.z, c3.z, u),
    )


@kernel(strict=True)
def tangent_at(tube, u):
    """Its derivative."""
    c1, c2, c3 = tube.c1, tube.c2, tube.c3
    return Vec3(slope(c1.x, c2.x, c3.x, u), slope(c1.y, c2.y, c3.y, u), slope(c1.z, c2.z, c3.z, u))


@kernel(strict=True)
def bend_at(tube, u):
    """Its second derivative."""
    c2, c3 = tube.c2, tube.c3
    return Vec3(
        2.0 * (c2.x + u * (3.0 * c3.x)),
        2.0 * (c2.y + u * (3.0 * c3.y)),
        2.0 * (c2.z + u * (3.0 * c3.z)),
    )


@kernel(strict=True)
def nearest_of_chord(tube, first, s_max):
    """(u, near): where the chord of a piece is nearest to the ray, and where that may meet it."""
    last = first + 1.0 / PIECES
    a, b = center_at(tube, first), center_at(tube, last)
    ra = cubic(tube.r0, tube.r1, tube.r2, tube.r3, first)
    rb = cubic(tube.r0, tube.r1, tube.r2, tube.r3, last)
    x, y = b.x - a.x, b.y - a.y
    squared = x * x + y * y
    v = minimum(maximum(-(a.x * x + a.y * y) / maximum(squared, 1e-37), 0.0), 1.0)
    x, y = a.x + v * x, a.y + v * y
    reach = maximum(ra, rb) + tube.slack
    near = x * x + y * y <= reach * reach
    near = near & (maximum(a.z, b.z) + reach > 0.0) & (minimum(a.z, b.z) - reach <= s_max)
    return first + v * (1.0 / PIECES), near


@kernel(strict=True)
def take_step(tube, search, low, high):
    """One step of Newton's method, within low and high."""
    u = search.u
    c, tangent, bend = center_at(tube, u), tangent_at(tube, u), bend_at(tube, u)
    r = cubic(tube.r0, tube.r1, tube.r2, tube.r3, u)
    dr = slope(tube.r1, tube.r2, tube.r3, u)
    length = along(tangent, tangent)
    inverse = 1.0 / length
    across = c.x * c.x + c.y * c.y
    a, b = tangent.z * inverse, (c.x * tangent.x + c.y * tangent.y) * inverse
    k = length + dr * dr
    aa = 1.0 - k * a * a
    bb = a * (k * b - r * dr)
    cc = (across - r * r) - b * (k * b - 2.0 * r * dr)
    discriminant = bb * bb - aa * cc
    root = sqrt(maximum(discriminant, 0.0))
    x = where(bb > 0.0, -(bb + root) / aa, cc / (root - bb))
    y = a * x - b
    # The circle turns as it moves: q . c'' of that; a tube thicker than its bend is no tube.
    turned = x * bend.z - (c.x * bend.x + c.y * bend.y)
    stretch, least = length - turned, FOLD * length
    step = y * length / maximum(stretch, least)
    moved = minimum(maximum(u + step, low), high)
    bends = absolute(bend.x) + absolute(bend.y) + absolute(bend.z)
    swells = absolute(2.0 * (tube.r2 + u * (3.0 * tube.r3)))
    # Where it bends and tapers the cone only cuts the tube, as the sides differ in length.
    cuts = absolute(dr * turned * inverse)
    away = absolute(step) * (absolute(y) * bends + absolute(step) * swells + cuts)
    done = (absolute(step) <= where(stretch > least, LAST, LAST_OF_FOLD)) & (away <= EXACT * r)
    inside = (u + step >= low) & (u + step <= high) & (r + dr * step > 0.0) & (stretch > 0.0)
    going = search.going & ~done & (moved != u)
    found = search.going & done & inside & (discriminant >= 0.0)
    return Search(
        where(search.going, moved, u),
        where(search.going, x + c.z, search.height),
        going,
        search.found | found,
    )


@kernel(strict=True)
def meet_piece(tube, first, inverse, t_max):
    """Where rays enter the piece of a tube that begins at u = `first`: (t, u, found)."""
    u, near = nearest_of_chord(tube, first, t_max / inverse)
    search = Search(u, 0.0 * u, near, near & ~near)
    low = maximum(first - MARGIN, -BEYOND)
    high = minimum(first + (1.0 / PIECES + MARGIN), 1.0 + BEYOND)
    for _ in range(STEPS):
        if not any_lane(search.going):
            break
        search = take_step(tube, search, low, high)
    t = search.height * inverse
    return t, search.u, search.found & (t > 0.0) & (t <= t_max)


@kernel(strict=True)
def meet_ball(center, radius, before, after, inverse, t_max):
    """Where rays enter a ball, given in their space, in the gap between two tubes: (t, found).

    before, after: the directions of the tubes that end and that begin there, 0 for none.
    """
    squared = radius * radius - (center.x * center.x + center.y * center.y)
    half = sqrt(maximum(squared, 0.0))
    t = (center.z - half) * inverse
    past = -(center.x * before.x + center.y * before.y) - half * before.z >= 0.0
    not_yet = -(center.x * after.x + center.y * after.y) - half * after.z <= 0.0
    return t, (squared >= 0.0) & past & not_yet & (t > 0.0) & (t <= t_max)
