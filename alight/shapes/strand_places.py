"""Places on strands: points, normals and derivatives on the rows of `alight.shapes.curves`."""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import gamma
from alight.core.frame import frame_from_tangent
from alight.core.vec import absolute_vec3, cross, dot, gather_vec3, length_squared
from alight.shapes.hit import INFO, PRIMITIVES
from alight.shapes.strand_rows import AFTER, AXIS, BEFORE, IS_BALL, STRIDE
from lanewise.jit import kernel
from lanewise.simd import gather, maximum, sqrt, where

_GAMMA_16 = gamma(16)

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
    bends = absolute_vec3(c1) + absolute_vec3(c2) + absolute_vec3(c3)
    reach = absolute_vec3(c0) + where(gather(data, row + IS_BALL) > 0.0, 0.0, 1.0) * bends
    return _GAMMA_16 * (dot(absolute_vec3(n), reach) + gather(data, row + 3))


@kernel
def center_of(data, row, u):
    """A point of the curve."""
    c2, c3 = gather_vec3(data, row + 8), gather_vec3(data, row + 12)
    return gather_vec3(data, row) + u * (gather_vec3(data, row + 4) + u * (c2 + u * c3))


@kernel
def is_seen(data, row, n):
    """Whether a point with the unit normal n lies in the gap that a ball fills; true of a tube."""
    before, after = gather_vec3(data, row + BEFORE), gather_vec3(data, row + AFTER)
    tube = gather(data, row + IS_BALL) <= 0.0
    return tube | ((dot(n, before) >= 0.0) & (dot(n, after) <= 0.0))
