"""Visits of rays to blocks of triangles, many at a time.

The outcome of a visit is unpredictable, and a mispredicted branch restarts the pipeline once the
long chain of operations up to the answer is over. So all visits are made first, without a branch;
then those with a hit are processed, when the answers are ready in memory.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable

from alight.accel.layout import IDS, OTHER, WIDTH
from alight.accel.node_test import SingleHit, meet_triangles
from alight.accel.rays import DIRECTION, MOST, ORIGIN, triangle_ray_of, vector_of
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    as_int,
    as_uint,
    float_bits,
    local_floats,
    local_longs,
    mask_bits,
    trailing_zeros,
    where,
)
from lanewise.wide import store_wide

#: rays, places: local longs, number of the ray and word where the block starts; bits: local longs,
#: the triangles that are hit; numbers: local floats, rows of WIDTH: t, u, v of visit 0, of visit 1
#: and so on.
Visits = namedtuple("Visits", "rays places bits numbers")
_NUMBERS = 3 * WIDTH * MOST

#: In the place of the triangles that are hit: the block holds something else.
SOMETHING_ELSE = 1 << WIDTH


@kernel(strict=True)
def no_visits():
    """Room for a visit of each ray."""
    return Visits(local_longs(MOST), local_longs(MOST), local_longs(MOST), local_floats(_NUMBERS))


@kernel(strict=True)
def closest_of_hits(tree, data, at, o, d, numbers, k, bits, best):
    """The nearer one of `best` and the hits in a block; of equals the one with the lower index.

    numbers[k : k + 3 WIDTH]: t, u and v of the triangles of the block at `at`; bits: those hit.
    """
    while bits != 0:
        i = trailing_zeros(bits)
        bits &= bits - 1
        t, index = numbers[k + i], as_int(float_bits(tree.blocks[at + IDS + i]))
        if (t < best.t) | ((t == best.t) & (index < best.index)):
            best = SingleHit(
                t, index, best.face, numbers[k + WIDTH + i], numbers[k + 2 * WIDTH + i]
            )
    return best


@kernel(strict=True)
def any_of_hits(tree, data, at, o, d, numbers, k, bits, best):
    """`best` with its end at -1: nothing else counts; parameters as of `closest_of_hits`."""
    return SingleHit(as_float(-1), best.index, best.face, best.u, best.v)


@kernel(strict=True)
def data_of_all(data, i):
    """What ray i needs of the data where all rays need the same."""
    return data


def write_visit_all(settle: Callable, mixed: bool, nearest_first: bool, of_ray: Callable):
    """``(tree, data, rays, hits, visits, count)``: make the first `count` visits.

    Parameters
    ----------
    settle : kernel (tree, data, at, o, d, numbers, k, bits, best) -> SingleHit
        What a ray makes of what its visit found, as `closest_of_hits`.
    mixed : bool
        Whether there are blocks of something else (`layout`).
    nearest_first : bool
        False where any hit will do: then only t is kept, -1 for a ray that hits something.
    of_ray : kernel (data, i) -> data
        What `settle` is given of `data` for ray i.
    """

    @kernel(strict=True)
    def visit_all(tree, data, rays, hits, visits, count):
        found = 0
        for k in range(count):
            i, at = visits.rays[k], visits.places[k]
            t, u, v, hit = meet_triangles(tree.blocks, at, triangle_ray_of(rays, i), hits.t[i])
            bits = mask_bits(hit)
            if mixed:
                last_corners = as_int(float_bits(tree.blocks[at + IDS - 1]))
                bits = where(last_corners == OTHER, SOMETHING_ELSE, bits)
            row = 3 * WIDTH * found
            store_wide(visits.numbers, row, t)
            if nearest_first:
                store_wide(visits.numbers, row + WIDTH, u)
                store_wide(visits.numbers, row + 2 * WIDTH, v)
            visits.rays[found], visits.places[found], visits.bits[found] = i, at, bits
            found += where(bits != 0, 1, 0)
        for k in range(found):
            i = visits.rays[k]
            best = SingleHit(
                hits.t[i], as_int(hits.index[i]), as_int(hits.face[i]), hits.u[i], hits.v[i]
            )
            best = settle(
                tree, of_ray(data, i), visits.places[k],
                vector_of(rays, ORIGIN, i), vector_of(rays, DIRECTION, i),
                visits.numbers, 3 * WIDTH * k, visits.bits[k], best,
            )  # fmt: skip
            hits.t[i] = best.t
            if nearest_first:
                hits.u[i], hits.v[i] = best.u, best.v
                hits.index[i], hits.face[i] = as_uint(best.index), as_uint(best.face)

    return visit_all
