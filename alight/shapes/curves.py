r"""Curves: strands of round cross-section, such as hair, fur, grass and threads.

.. math:: p(u, \varphi) = c(u) + r(u) (\cos\varphi\, f_1(u) + \sin\varphi\, f_2(u))

c is piecewise cubic, or a row of straight lines; f_1 and f_2 stand at right angles to it. So a
strand is what a circle sweeps; its ends are open. Straight lines end in half a ball, and of a ball
at a joint the wedge is seen that lies past one line and before the next. Curves
are met from outside only (`alight.shapes.tube`): a ray that enters one passes what it leaves by.

A strand is many primitives; each has a row of the table, with a local u in [0, 1]:

=======  ======================================================================
0-15     coefficients of 1, u, u^2, u^3: x, y, z and radius of each; of a ball
         the centre and the radius, then (from 4, 8 and 12 on) the directions of the
         strand, of the line before and of the line after, 0 for none
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

from typing import Literal

import numpy as np

from alight.core.constants import INFINITY, INV_TWO_PI, PI, TWO_PI
from alight.core.frame import frame_from_tangent
from alight.core.maths import arctan2
from alight.core.vec import Vec3, dot
from alight.shapes.hit import (
    Geometry,
    needs_uv,
)
from alight.shapes.strand_places import error_of, place_at, row_of
from alight.shapes.strand_rows import (
    AFTER,
    BEFORE,
    IS_BALL,
    SLACK,
    SPAN,
    TEXTURE,
    rows_of,
)
from alight.shapes.strand_rows import area as area
from alight.shapes.strand_rows import bounds as bounds
from alight.shapes.strand_rows import extremes as extremes
from alight.shapes.strand_sampling import coordinates as coordinates
from alight.shapes.strand_sampling import pdf as pdf
from alight.shapes.strand_sampling import sample as sample
from alight.shapes.strand_sampling import sample_area as sample_area
from alight.shapes.strands import StrandShape
from alight.shapes.tube import (
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
    fma,
    gather,
    horizontal_min,
    lanes,
    lanes_mask,
    lanes_vec3,
    mask_bits,
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
    flip_normals : bool, default False
        Must be false: strands are met from outside.
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
        c0=into(space, point_of(data, k, o, zero)),
        c1=into(space, point_of(data, k + 4, none, zero)),
        c2=into(space, point_of(data, k + 8, none, zero)),
        c3=into(space, point_of(data, k + 12, none, zero)),
        r0=data[k + 3] + zero,
        r1=data[k + 7] + zero,
        r2=data[k + 11] + zero,
        r3=data[k + 15] + zero,
        slack=data[k + SLACK] + zero,
    )


@kernel(strict=True)
def meet_ball_of(data, k, o, space, t_max):
    """Meet the ball of a row; k: uniform."""
    zero = 0.0 * space.inverse
    none = Vec3(zero, zero, zero)
    before = into(space, point_of(data, k + BEFORE, none, zero))
    after = into(space, point_of(data, k + AFTER, none, zero))
    center = into(space, point_of(data, k, o, zero))
    return meet_ball(center, data[k + 3] + zero, before, after, space.inverse, t_max)


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one primitive with rays; see `alight.shapes.rectangle.intersect`.

    u is that of the row; v is 0.
    """
    space = ray_space(d)
    best, best_u, met = t_max + 0.0 * space.inverse, 0.0 * space.inverse, lanes_mask(False)
    if data[k + IS_BALL] > 0.0:
        best, met = meet_ball_of(data, k, o, space, best)
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
        t, found = meet_ball_of(data, k, origin, space, last)
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
