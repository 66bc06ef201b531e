"""Paths waiting for their next step until they fill a packet."""

from __future__ import annotations

from collections import namedtuple

from alight.core.vec import Vec3
from alight.integrators.walk import Path, count_lanes, module_of
from alight.samplers.state import SamplerState
from alight.shapes.hit import Hit
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    as_int,
    lane_index,
    lanes_u32,
    lanes_vec3,
    load_lanes,
    packing,
    permuted,
    store_lanes,
    where,
)

#: Rows of floats (o, d, p, L, beta, pdf, L_direct) and of u32 (x, y, index, scramble and the keys
#: a, b of the sampler, depth and whether it was a delta lobe). A row has room for two packets, so
#: that one can be read or written from any place in the first.
Queue = namedtuple("Queue", "floats uints")
ROOM = 32

#: Where the rows of a `Hit` (t, u, v; shape, prim) are in a queue of paths that hit something.
HIT_FLOATS, HIT_UINTS = 19, 7

#: The first rows that an integrator may have for what it keeps beyond a `Path`, and how many.
MORE_FLOATS, MORE_UINTS = 19, 7
FLOATS, UINTS = (MORE_FLOATS + 6) * ROOM, (MORE_UINTS + 3) * ROOM


@kernel
def put_row(rows, k, at, order, x):
    """Write the lanes of x, in that order, to row k from number `at` on."""
    store_lanes(rows, k * ROOM + at, permuted(x, order))


@kernel
def put_vector(rows, k, at, order, v):
    """Write three rows, from row k on."""
    put_row(rows, k, at, order, v.x)
    put_row(rows, k + 1, at, order, v.y)
    put_row(rows, k + 2, at, order, v.z)


@kernel
def vector_at(rows, k, at):
    """Read three rows, from row k on."""
    return Vec3(
        load_lanes(rows, k * ROOM + at),
        load_lanes(rows, (k + 1) * ROOM + at),
        load_lanes(rows, (k + 2) * ROOM + at),
    )


@kernel
def put_hit(queue, at, path, hit):
    """Append what the active paths have met, which `put` appends too."""
    floats, uints, order = queue.floats, queue.uints, packing(path.active)
    put_vector(floats, HIT_FLOATS, at, order, Vec3(hit.t, hit.u, hit.v))
    put_row(uints, HIT_UINTS, at, order, hit.shape)
    put_row(uints, HIT_UINTS + 1, at, order, hit.prim)


@kernel
def take_hit(queue, at):
    """What the paths from number `at` on have met."""
    t = vector_at(queue.floats, HIT_FLOATS, at)
    shape = load_lanes(queue.uints, HIT_UINTS * ROOM + at)
    return Hit(t.x, t.y, t.z, shape, load_lanes(queue.uints, (HIT_UINTS + 1) * ROOM + at))


@kernel
def _put_nothing(queue, at, order, path):
    """All of a `Path` has been written."""


@kernel
def _take_nothing(queue, at, path):
    """A `Path` is all."""
    return path


@specialised
def put_more(program):
    """``put_more(queue, at, order, path)``: write what the integrator keeps beyond a `Path`."""
    return getattr(module_of(program), "put_more", _put_nothing)


@specialised
def take_more(program):
    """``take_more(queue, at, path)``: the `Path` with what the integrator keeps beyond it."""
    return getattr(module_of(program), "take_more", _take_nothing)


@specialised
def put(program):
    """``put(queue, at, path)``: append the active paths from number `at` on; the new length.

    The others follow them, where only inactive lanes read.
    """
    split_direct = "direct" in program.aovs

    @kernel
    def put(queue, at, path):
        floats, uints, order = queue.floats, queue.uints, packing(path.active)
        put_vector(floats, 0, at, order, path.o)
        put_vector(floats, 3, at, order, path.d)
        put_vector(floats, 6, at, order, path.p)
        put_vector(floats, 9, at, order, path.L)
        put_vector(floats, 12, at, order, path.beta)
        put_row(floats, 15, at, order, path.pdf)
        if split_direct:
            put_vector(floats, 16, at, order, path.L_direct)
        sampler = path.sampler
        put_row(uints, 0, at, order, sampler.x)
        put_row(uints, 1, at, order, sampler.y)
        put_row(uints, 2, at, order, sampler.index)
        put_row(uints, 3, at, order, sampler.scramble)
        put_row(uints, 4, at, order, sampler.a)
        put_row(uints, 5, at, order, sampler.b)
        put_row(uints, 6, at, order, (path.depth << 1) | where(path.delta, lanes_u32(1), 0))
        put_more(queue, at, order, path)
        return at + count_lanes(path.active)

    return put


@specialised
def take(program):
    """``take(settings, queue, at, count)``: the paths from number `at` on."""
    split_direct = "direct" in program.aovs

    @kernel
    def take(settings, queue, at, count):
        floats, uints = queue.floats, queue.uints
        direct = lanes_vec3(0.0)
        if split_direct:
            direct = vector_at(floats, 16, at)
        sampler = SamplerState(
            load_lanes(uints, at),
            load_lanes(uints, ROOM + at),
            load_lanes(uints, 2 * ROOM + at),
            load_lanes(uints, 3 * ROOM + at),
            lanes_u32(settings.seed),
            load_lanes(uints, 4 * ROOM + at),
            load_lanes(uints, 5 * ROOM + at),
        )
        depth = load_lanes(uints, 6 * ROOM + at)
        path = Path(
            vector_at(floats, 0, at), vector_at(floats, 3, at), vector_at(floats, 6, at),
            vector_at(floats, 9, at), direct, vector_at(floats, 12, at),
            load_lanes(floats, 15 * ROOM + at), (depth & 1) != 0, depth >> 1, sampler,
            lane_index() < count, as_int(0),
        )  # fmt: skip
        return take_more(queue, at, path)

    return take
