r"""Motion while the shutter is open: transforms at the times of rays, and their effect on hits.

A moving shape is stored as it is *at rest*, before its motion M(t). Rays go to it by the inverse,
with the direction's length unchanged, so that t means the same; what they find there goes back:

.. math:: p = M(t)\, p_0, \qquad n \propto M(t)^{-T} n_0

**Error bound.** Where M is p = A p_0 + b, a ray's origin is taken to rest as
:math:`A^{-1}(o - b)`. Per unit of the machine epsilon that is off by less than
:math:`48 |A^{-1}| (|A| |p_0| + |b|)`: 2 of o - b, 4 of the product, 16 of A times the 2 of each
cofactor (a difference of products), and of the determinant and the rounding of p, 4 each; doubled
for matrices that do not keep angles. The bound at rest is added, and the sum goes to the world by
1 / \|A^{-T} n_0\|.

Sources: Glassner, Spacetime ray tracing for animation (1988); PBR4 sections 3.10 and 7.1.2.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import gamma
from alight.core.maths import sincos_octant
from alight.core.vec import Vec3, absolute_vec3
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, as_int, gather, maximum, sqrt, where

#: Tables of what moves. rows: float32, the motions one after another; sizes: u32, links of each
#: motion and segments of each link, the same for all; of_shape, of_light: u32, the number of the
#: motion + 1 of each, 0 for those that rest; camera: u32, the same of the camera.
Motions = namedtuple("Motions", "rows sizes of_shape of_light camera")

#: Rows of A, and b.
Affine = namedtuple("Affine", "x y z b")

#: A link: a 3 x 4 matrix that rests, then its segments.
BEFORE, SEGMENTS = 0, 12
#: A segment: when it begins, 1 / its length, angle between its quaternions, then shift and its
#: change, quaternion and the one aside (`alight.scene.keyframes`), stretch (xx xy xz yy yz zz) and
#: its change.
BEGIN, RATE, ANGLE, SHIFT, TRAVEL, TURN, ASIDE, STRETCH, CHANGE = 0, 1, 2, 3, 6, 9, 13, 17, 23
SEGMENT = 32

#: Name in `Program.motion` next to what moves: all motions only shift and turn.
RIGID = "rigid"

_GAMMA_48 = gamma(48)


@kernel(strict=True)
def vector_at(rows, k):
    """Three numbers of a table, from k on (uniform or lanes)."""
    return Vec3(gather(rows, k), gather(rows, k + 1), gather(rows, k + 2))


@kernel(strict=True)
def inner(a, b):
    """a . b, added up in one order everywhere."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@kernel(strict=True)
def turned(m, v):
    """A v."""
    return Vec3(inner(m.x, v), inner(m.y, v), inner(m.z, v))


@kernel(strict=True)
def placed(m, p):
    """A p + b."""
    return turned(m, p) + m.b


@kernel(strict=True)
def after(m, first):
    """The matrix that applies `first`, then m."""
    return Affine(_row(m.x, first), _row(m.y, first), _row(m.z, first), placed(m, first.b))


@kernel(strict=True)
def _row(row, m):
    """A row vector times A."""
    return row.x * m.x + row.y * m.y + row.z * m.z


@kernel(strict=True)
def before_at(rows, k):
    """The resting part of the link at k."""
    return Affine(
        vector_at(rows, k),
        vector_at(rows, k + 4),
        vector_at(rows, k + 8),
        Vec3(gather(rows, k + 3), gather(rows, k + 7), gather(rows, k + 11)),
    )


@kernel(strict=True)
def turn_at(rows, k, time):
    """The way through the segment at k, from 0 to 1, and the quaternion there, scalar first."""
    x = (time - gather(rows, k + BEGIN)) * gather(rows, k + RATE)
    s, c = sincos_octant(x * gather(rows, k + ANGLE))
    w = c * gather(rows, k + TURN) + s * gather(rows, k + ASIDE)
    return x, w, c * vector_at(rows, k + TURN + 1) + s * vector_at(rows, k + ASIDE + 1)


@kernel(strict=True)
def segment_at(rows, k, time):
    """The moving part of a link in the segment at k: shift, turn and stretch."""
    x, w, q = turn_at(rows, k, time)
    a = vector_at(rows, k + STRETCH) + x * vector_at(rows, k + CHANGE)
    b = vector_at(rows, k + STRETCH + 3) + x * vector_at(rows, k + CHANGE + 3)
    xx, yy, zz = q.x * q.x, q.y * q.y, q.z * q.z
    xy, xz, yz = q.x * q.y, q.x * q.z, q.y * q.z
    wx, wy, wz = w * q.x, w * q.y, w * q.z
    # The symmetric stretch, row by row; then R S.
    s0, s1, s2 = a, Vec3(a.y, b.x, b.y), Vec3(a.z, b.y, b.z)
    return Affine(
        (1.0 - 2.0 * (yy + zz)) * s0 + (2.0 * (xy - wz)) * s1 + (2.0 * (xz + wy)) * s2,
        (2.0 * (xy + wz)) * s0 + (1.0 - 2.0 * (xx + zz)) * s1 + (2.0 * (yz - wx)) * s2,
        (2.0 * (xz - wy)) * s0 + (2.0 * (yz + wx)) * s1 + (1.0 - 2.0 * (xx + yy)) * s2,
        vector_at(rows, k + SHIFT) + x * vector_at(rows, k + TRAVEL),
    )


@kernel(strict=True)
def segment_of(motions, k, time):
    """Where the segment of a time begins in the link at k."""
    at = k + SEGMENTS
    for i in range(1, as_int(motions.sizes[1])):
        following = k + (SEGMENTS + SEGMENT * i)
        at = where(time >= gather(motions.rows, following), following, at)
    return at


@kernel(strict=True)
def link_at(motions, k, time):
    """The link at k, at a time."""
    rows = motions.rows
    return after(before_at(rows, k), segment_at(rows, segment_of(motions, k, time), time))


@specialised
def matrix_at(program):
    """``matrix_at(motions, number, time) -> Affine`` at a time in [0, 1); uniform or lanes, both.

    Where all motions only shift and turn (`RIGID`), each is one link of that kind.
    """
    return rigid_matrix_at if RIGID in program.motion else general_matrix_at


@specialised
def inverse_rows(program):
    """``inverse_rows(m)``: rows of A^-T, so that A^-1 v = v.x x + v.y y + v.z z (b is not theirs).

    Of a rotation that is A itself.
    """
    return same_rows if RIGID in program.motion else inverse_transpose


@kernel(strict=True)
def same_rows(m):
    """`inverse_rows` of a rotation."""
    return m


@kernel(strict=True)
def rigid_matrix_at(motions, number, time):
    """`matrix_at` of a motion that only shifts and turns."""
    rows = motions.rows
    k = number * (SEGMENTS + SEGMENT * as_int(motions.sizes[1]))
    k = segment_of(motions, k, time)
    x, w, q = turn_at(rows, k, time)
    xx, yy, zz = q.x * q.x, q.y * q.y, q.z * q.z
    xy, xz, yz = q.x * q.y, q.x * q.z, q.y * q.z
    wx, wy, wz = w * q.x, w * q.y, w * q.z
    return Affine(
        Vec3(1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy)),
        Vec3(2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx)),
        Vec3(2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)),
        vector_at(rows, k + SHIFT) + x * vector_at(rows, k + TRAVEL),
    )


@kernel(strict=True)
def general_matrix_at(motions, number, time):
    """`matrix_at` of any chain of links."""
    links, length = as_int(motions.sizes[0]), SEGMENTS + SEGMENT * as_int(motions.sizes[1])
    k = number * (length * links)
    m = link_at(motions, k, time)
    for i in range(1, links):
        m = after(m, link_at(motions, k + length * i, time))
    return m


@kernel(strict=True)
def _crossed(a, b):
    return Vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@kernel(strict=True)
def inverse_transpose(m):
    """`inverse_rows` of any matrix, by its cofactors."""
    x, y, z = _crossed(m.y, m.z), _crossed(m.z, m.x), _crossed(m.x, m.y)
    scale = 1.0 / inner(m.x, x)
    return Affine(x * scale, y * scale, z * scale, m.b)


@kernel(strict=True)
def point_at_rest(w, p):
    """A^-1 (p - b), w of `inverse_rows`."""
    return direction_at_rest(w, p - w.b)


@kernel(strict=True)
def direction_at_rest(w, v):
    """A^-1 v."""
    return v.x * w.x + v.y * w.y + v.z * w.z


@kernel(strict=True)
def error_in_world(m, w, p, n, error):
    """The error bound of a moving surface in the world.

    Parameters
    ----------
    m, w : Affine
        The motion, and its `inverse_rows`.
    p, n : Vec3
        Point and unit normal at rest.
    error : float
        Bound at rest.
    """
    ap, an = absolute_vec3(p), absolute_vec3(n)
    reach = Vec3(
        inner(absolute_vec3(m.x), ap), inner(absolute_vec3(m.y), ap), inner(absolute_vec3(m.z), ap)
    ) + absolute_vec3(m.b)
    back = reach.x * absolute_vec3(w.x) + reach.y * absolute_vec3(w.y)
    back = back + reach.z * absolute_vec3(w.z)
    normal = turned(w, n)
    size = sqrt(maximum(inner(normal, normal), 1e-37))
    return (error + _GAMMA_48 * inner(an, back)) / size


@specialised
def point_of_rest(program):
    """``point_of_rest(scene, surface)``: the surface's point before what moves has moved."""
    if "shapes" not in program.motion:
        return _its_point

    @kernel
    def before_moving(scene, surface):
        number, p = gather(scene.motions.of_shape, surface.shape), surface.p
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            p = where(moving, point_at_rest(inverse_rows(m), p), p)
        return p

    return before_moving


@specialised
def point_at_opening(program):
    """``point_at_opening(scene, surface)``: where its point was when the shutter opened.

    Patterns in space hold to it: they go along with what moves.
    """
    if "shapes" not in program.motion:
        return _its_point

    @kernel
    def at_opening(scene, surface):
        number, p = gather(scene.motions.of_shape, surface.shape), point_of_rest(scene, surface)
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), 0.0 * scene.time)
            p = where(moving, placed(m, p), p)
        return p

    return at_opening


@specialised
def moved_along(program):
    """``moved_along(scene, number, p)``: points at rest, along with motions.

    number: u32, as of `Motions.of_shape`: 0 for what rests.
    """
    if not program.motion:
        return _as_it_is

    @kernel
    def placed_now(scene, number, p):
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            p = where(moving, placed(m, p), p)
        return p

    return placed_now


@kernel
def _as_it_is(scene, number, p):
    return p


@kernel
def _its_point(scene, surface):
    return surface.p
