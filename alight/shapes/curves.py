r"""Curves: strands of round cross-section, such as hair, fur, grass and threads.

.. math:: p(u, \varphi) = c(u) + r(u) (\cos\varphi\, f_1(u) + \sin\varphi\, f_2(u))

c is piecewise cubic, or a row of straight lines; f_1 and f_2 stand at right angles to it. So a
strand is what a circle sweeps; its ends are open, and joints of straight lines are balls. Curves
are met from outside only (`alight.shapes.tube`): a ray that enters one passes what it leaves by.

A strand is many primitives; each has a row of the table, with a local u in [0, 1]:

=======  ======================================================================
0-15     coefficients of 1, u, u^2, u^3: x, y, z and radius of each; of a ball
         the centre and the radius, then the direction of the strand there
16       how far it bends away from the chord of a piece
17       0 for a tube, 1 for a ball
18, 19   texture coordinate at u = 0, and how much it grows up to u = 1
20-22    the axis from which the angle around the strand is measured
=======  ======================================================================

Texture coordinates are (u, v) = (part of the strand from its root on, phi / 2 pi): dp/du is along
the strand.

**Error bound**, along the normal n: p is put on the circle at u, whatever u is, so only rounding
counts: gamma(16) sum \|n_i\| (\|c_0i\| + \|c_1i\| + \|c_2i\| + \|c_3i\|) + gamma(16) r. New rays
leave outwards, or inwards, where nothing is met.

Sources: those of `alight.shapes.tube`; the normal and the turn of the frame are derivatives of p.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Literal

import numpy as np

from alight.core.constants import INFINITY, INV_TWO_PI, PI, TWO_PI, gamma
from alight.core.frame import frame_from_tangent
from alight.core.maths import arctan2, sincos_2pi
from alight.core.vec import Vec3, absolute_vec3, cross, dot, gather_vec3, length_squared
from alight.shapes.hit import (
    INFO,
    PRIMITIVES,
    AreaSample,
    Geometry,
    ShapeSample,
    area_to_solid_angle,
    needs_uv,
)
from alight.shapes.strand_rows import (
    AXIS,
    IS_BALL,
    SLACK,
    SPAN,
    STRIDE,
    TEXTURE,
    rows_of,
)
from alight.shapes.strand_rows import area as area
from alight.shapes.strand_rows import bounds as bounds
from alight.shapes.strand_rows import extremes as extremes
from alight.shapes.strands import StrandShape
from alight.shapes.tube import (
    BEYOND,
    PIECES,
    Tube,
    into,
    meet_ball,
    meet_piece,
    ray_space,
)
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    as_float,
    floor,
    fma,
    gather,
    horizontal_min,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    mask_bits,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    trailing_zeros,
    where,
)
from lanewise.wide import four, join, lane, wide


class Curves(StrandShape):
    """Round strands.

    Parameters
    ----------
    file : str, optional
        NPZ file with the arrays ``points``, ``radii`` and ``counts``, relative to the scene file;
        not together with arrays.
    points : (n, 3) float32, metres, optional
        Control points of all strands, in the space of its node.
    radii : float >= 0 or (n,) float32, metres, optional
        Of all, or at each control point.
    counts : (m,) int32, optional
        Control points of each strand; by default all are one strand.
    basis : {"linear", "bezier", "b_spline", "catmull_rom"}, default "b_spline"
        What the control points mean.
    """

    type: Literal["curves"] = "curves"


EXAMPLES = (
    Curves(
        points=((-0.8, 0.0, 0.0), (-0.2, 0.2, 0.2), (0.5, -0.1, 0.1), (1.0, 0.1, 0.4)),
        radii=(0.15, 0.15, 0.1, 0.12),
        basis="bezier",
    ),
    Curves(points=((0.0, 0.0, 0.0), (0.3, 1.0, 0.2)), radii=(0.3, 0.2), basis="linear"),
)  # fmt: skip

#: Seen from the side, as a rectangle is.
PROJECTION = 1.0 / PI

_GAMMA_16 = gamma(16)

#: Steps of Newton's method from the nearest of some points of a curve.
NEWTON = 4


def pack(spec: Curves, matrix: np.ndarray) -> np.ndarray:
    """The rows of the table, (n, STRIDE), from the (4, 4) float64 matrix, object to world."""
    return rows_of(spec, matrix)


# ---------------------------------------------------------------- intersection


@kernel(strict=True)
def point_of(data, k, o, spread):
    """Three neighbours of a row, from the uniform k on, in every lane of `spread`, less o."""
    return Vec3(
        (data[k] + spread) - o.x, (data[k + 1] + spread) - o.y, (data[k + 2] + spread) - o.z
    )


@kernel(strict=True)
def tube_of(data, k, o, space):
    """The `Tube` of a row in the space of rays; k: uniform."""
    zero = 0.0 * space.inverse
    none = Vec3(zero, zero, zero)
    return Tube(
        into(space, point_of(data, k, o, zero)),
        into(space, point_of(data, k + 4, none, zero)),
        into(space, point_of(data, k + 8, none, zero)),
        into(space, point_of(data, k + 12, none, zero)),
        data[k + 3] + zero,
        data[k + 7] + zero,
        data[k + 11] + zero,
        data[k + 15] + zero,
        data[k + SLACK] + zero,
    )


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one primitive with rays; see `alight.shapes.rectangle.intersect`.

    u is that of the row; v is 0.
    """
    space = ray_space(d)
    best, best_u, met = t_max + 0.0 * space.inverse, 0.0 * space.inverse, lanes_mask(False)
    if data[k + IS_BALL] > 0.0:
        center = into(space, point_of(data, k, o, 0.0 * space.inverse))
        best, met = meet_ball(center, data[k + 3] + 0.0 * center.x, space.inverse, best)
    else:
        tube = tube_of(data, k, o, space)
        for i in range(PIECES):
            first = as_float(i) / PIECES + 0.0 * space.inverse
            t, u, found = meet_piece(tube, first, space.inverse, best)
            nearer = found & ((t < best) | ~met)
            best, best_u, met = where(nearer, t, best), where(nearer, u, best_u), met | nearer
    return best, best_u, lanes(0.0), met


@kernel(strict=True)
def pieces():
    """Where the pieces of a tube begin."""
    first = join(
        join(four(0.0, 1.0, 2.0, 3.0), four(4.0, 5.0, 6.0, 7.0)),
        join(four(8.0, 9.0, 10.0, 11.0), four(12.0, 13.0, 14.0, 15.0)),
    )
    return first * (1.0 / PIECES)


@kernel(strict=True)
def meet_alone(data, k, o, d, t_max):
    """Meet one primitive with one ray, given by scalars: all pieces of a tube at once.

    Returns
    -------
    t, u, v : float
    bits : int
        0 for a miss.
    """
    origin = Vec3(wide(PIECES, o.x), wide(PIECES, o.y), wide(PIECES, o.z))
    space = ray_space(Vec3(wide(PIECES, d.x), wide(PIECES, d.y), wide(PIECES, d.z)))
    last = wide(PIECES, t_max)
    if data[k + IS_BALL] > 0.0:
        center = into(space, point_of(data, k, origin, 0.0 * space.inverse))
        t, found = meet_ball(center, data[k + 3] + 0.0 * center.x, space.inverse, last)
        u = 0.0 * space.inverse
    else:
        tube = tube_of(data, k, origin, space)
        t, u, found = meet_piece(tube, pieces(), space.inverse, last)
    t = where(found, t, INFINITY)
    nearest = horizontal_min(t)
    bits = mask_bits(found & (t <= nearest))
    i = trailing_zeros(bits | (1 << PIECES)) & (PIECES - 1)
    return nearest, lane(u, i), as_float(0), bits


# ---------------------------------------------------------------- surface


#: A place on a strand. p, n: point and unit normal; along, around: dp/du of the row and dp/dphi;
#: u: of the row (of a ball the cosine of the angle to the strand); e, f1, f2: unit vectors of the
#: circle, to the point and of the frame; stretch: area over du dphi.
Place = namedtuple("Place", "p n along around u e f1 f2 stretch")


@kernel
def row_of(tables, k, shape, prim):
    """(offset of the row of a primitive, how many there are); of other shapes some row, and 1."""
    count = gather(tables.info, shape * INFO + 4) >> PRIMITIVES
    return where(prim < count, k + STRIDE * prim, 0), where(count > 0, count, 1)


@kernel
def place_at(data, row, u, near):
    """The `Place` on the circle at u that is nearest to a point; of a ball that on its surface."""
    c0, c1 = gather_vec3(data, row), gather_vec3(data, row + 4)
    c2, c3 = gather_vec3(data, row + 8), gather_vec3(data, row + 12)
    r0, r1 = gather(data, row + 3), gather(data, row + 7)
    r2, r3 = gather(data, row + 11), gather(data, row + 15)
    ball = gather(data, row + IS_BALL) > 0.0
    u = where(ball, 0.0, u)
    c, dc = c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + (3.0 * u) * c3)
    ddc = 2.0 * c2 + (6.0 * u) * c3
    r, dr = r0 + u * (r1 + u * (r2 + u * r3)), r1 + u * (2.0 * r2 + (3.0 * u) * r3)
    size = sqrt(maximum(length_squared(dc), 1e-37))
    t, q, axis = dc * (1.0 / size), near - c, gather_vec3(data, row + AXIS)
    f1, f2 = frame_from_tangent(t, axis)
    flat = q - dot(q, t) * t
    e = flat * (1.0 / sqrt(maximum(length_squared(flat), 1e-37)))
    across = cross(t, e)
    # e turns by -(e . T') T as the circle moves, and with the frame about T.
    stretch = size - r * dot(e, ddc) / size
    bend = dot(axis, t)
    twist = bend * dot(ddc, f2) / (size * sqrt(maximum(1.0 - bend * bend, 1e-6)))
    along = stretch * t + dr * e - (r * twist) * across
    n = stretch * e - dr * t
    n = n * (1.0 / sqrt(maximum(length_squared(n), 1e-37)))
    spread = r * sqrt(stretch * stretch + dr * dr)
    # Of a ball.
    out = q * (1.0 / sqrt(maximum(length_squared(q), 1e-37)))
    cosine = dot(out, t)
    sine = sqrt(maximum(1.0 - cosine * cosine, 1e-12))
    return Place(
        p=c + r * where(ball, out, e),
        n=where(ball, out, n),
        along=where(ball, r * (t - (cosine / sine) * e), along),
        around=(r * where(ball, sine, 1.0)) * across,
        u=where(ball, cosine, u),
        e=e,
        f1=f1,
        f2=f2,
        stretch=where(ball, r * r, spread),
    )


@kernel
def error_of(data, row, n):
    """The error bound of a primitive along its unit normal n."""
    c0, c1 = gather_vec3(data, row), gather_vec3(data, row + 4)
    c2, c3 = gather_vec3(data, row + 8), gather_vec3(data, row + 12)
    reach = absolute_vec3(c0) + absolute_vec3(c1) + absolute_vec3(c2) + absolute_vec3(c3)
    return _GAMMA_16 * (dot(absolute_vec3(n), reach) + gather(data, row + 3))


@specialised
def turn_of(program):
    """``turn_of(place)``: phi / 2 pi in [0, 1), where the program reads it."""
    if not needs_uv(program):

        @kernel
        def unused(place):
            return lanes(0.0)

        return unused

    @kernel
    def angle(place):
        turn = arctan2(dot(place.e, place.f2), dot(place.e, place.f1)) * INV_TWO_PI
        return where(turn < 0.0, turn + 1.0, turn)

    return angle


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    data, t = tables.data, hit.t
    row, _ = row_of(tables, k, hit.shape, hit.prim)
    place = place_at(data, row, hit.u, Vec3(fma(t, d.x, o.x), fma(t, d.y, o.y), fma(t, d.z, o.z)))
    s, t = frame_from_tangent(place.n, place.along)
    return Geometry(
        p=place.p,
        error=error_of(data, row, place.n),
        ng=place.n,
        ns=place.n,
        s=s,
        t=t,
        u=gather(data, row + TEXTURE) + gather(data, row + SPAN) * place.u,
        v=turn_of(place),
        color=lanes_vec3(1.0),
    )


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    data = tables.data
    row, _ = row_of(tables, k, surface.shape, surface.prim)
    span = gather(data, row + SPAN)
    inverse = where(span > 0.0, 1.0 / where(span > 0.0, span, 1.0), 0.0)
    u = (surface.u - gather(data, row + TEXTURE)) * inverse
    place = place_at(data, row, u, surface.p)
    return inverse * place.along, TWO_PI * place.around


# ---------------------------------------------------------------- sampling


@kernel
def choose_place(tables, shape, u2):
    """(prim, u, `Place`, density per area): any primitive, then uniform in u and phi."""
    data = tables.data
    k = gather(tables.info, shape * INFO + 3)
    _, count = row_of(tables, k, shape, lanes_u32(0))
    number = u2[0] * to_float(count)
    whole = minimum(floor(number), to_float(count) - 1.0)
    prim, u = to_uint(whole), minimum(number - whole, 1.0)
    row, _ = row_of(tables, k, shape, prim)
    sine, cosine = sincos_2pi(u2[1])
    # A point beside the circle, in that direction; of a ball at uniform heights.
    at = place_at(data, row, u, gather_vec3(data, row))
    ball = gather(data, row + IS_BALL) > 0.0
    e = cosine * at.f1 + sine * at.f2
    height = 2.0 * u - 1.0
    t = cross(at.f1, at.f2)
    out = height * t + sqrt(maximum(1.0 - height * height, 0.0)) * e
    center = center_of(data, row, where(ball, 0.0, u))
    place = place_at(data, row, u, center + where(ball, out, e))
    spread = place.stretch * to_float(count) * where(ball, 2.0 * TWO_PI, TWO_PI)
    return prim, u, place, where(spread > 0.0, 1.0 / where(spread > 0.0, spread, 1.0), 0.0)


@kernel
def center_of(data, row, u):
    """A point of the curve."""
    c2, c3 = gather_vec3(data, row + 8), gather_vec3(data, row + 12)
    return gather_vec3(data, row) + u * (gather_vec3(data, row + 4) + u * (c2 + u * c3))


@kernel
def sample(tables, cdf, start, shape, p, u, u2):
    """Choose a point; see `alight.shapes.rectangle.sample`."""
    data = tables.data
    prim, _, place, density = choose_place(tables, shape, u2)
    row, _ = row_of(tables, gather(tables.info, shape * INFO + 3), shape, prim)
    to_light = place.p - p
    distance = sqrt(length_squared(to_light))
    wi = to_light * (1.0 / maximum(distance, 1e-30))
    cosine = -dot(wi, place.n)
    density = area_to_solid_angle(density, distance, cosine)
    return ShapeSample(wi, distance, cosine, error_of(data, row, place.n), density)


@kernel
def pdf(tables, cdf, start, shape, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit` seen from p."""
    data, q = tables.data, p + hit.distance * hit.wi
    row, count = row_of(tables, gather(tables.info, shape * INFO + 3), shape, hit.prim)
    place = place_at(data, row, nearest_of_row(data, row, q), q)
    ball = gather(data, row + IS_BALL) > 0.0
    spread = place.stretch * to_float(count) * where(ball, 2.0 * TWO_PI, TWO_PI)
    density = where(spread > 0.0, 1.0 / where(spread > 0.0, spread, 1.0), 0.0)
    return area_to_solid_angle(density, hit.distance, hit.cosine)


@kernel
def nearest_of_row(data, row, q):
    """The u at which the curve of a row is nearest to a point."""
    best, u = lanes(INFINITY), lanes(0.0)
    for i in range(PIECES + 1):
        at = lanes(as_float(i) / PIECES)
        away = length_squared(center_of(data, row, at) - q)
        u, best = where(away < best, at, u), minimum(away, best)
    c1, c2 = gather_vec3(data, row + 4), gather_vec3(data, row + 8)
    c3 = gather_vec3(data, row + 12)
    for _ in range(NEWTON):
        dc, ddc = c1 + u * (2.0 * c2 + (3.0 * u) * c3), 2.0 * c2 + (6.0 * u) * c3
        f = q - center_of(data, row, u)
        slope = length_squared(dc) - dot(f, ddc)
        step = dot(f, dc) / maximum(slope, 0.25 * length_squared(dc) + 1e-37)
        u = minimum(maximum(u + step, -BEYOND), 1.0 + BEYOND)
    return u


@kernel
def sample_area(tables, cdf, start, shape, u, u2):
    """Choose a point; see `alight.shapes.rectangle.sample_area`. Not uniform by area."""
    prim, place_u, place, density = choose_place(tables, shape, u2)
    return AreaSample(place.p, place_u, lanes(0.0), prim, density)


@kernel
def coordinates(tables, cdf, start, shape, q, u, u2):
    """u, 0 and the primitive of a sampled point: the same numbers choose the same again."""
    prim, place_u, _, _ = choose_place(tables, shape, u2)
    return place_u, lanes(0.0), prim
