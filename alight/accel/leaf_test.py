"""The leaf test: one ray against all triangles of a block; and one such test for each ray.

The outcome of a test is unpredictable, and a mispredicted branch restarts the pipeline once the
long chain of operations up to the answer is over. So the rays of a packet make all their tests
first, without a branch; then those with a hit are looked at, when the answers are ready in memory.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import CORNERS, IDS, OTHER, WIDTH
from alight.accel.rays import (
    DIRECTION,
    MOST,
    ORIGIN,
    Ray,
    SingleHit,
    triangle_ray_of,
    vector_of,
)
from alight.core.vec import Vec3
from alight.shapes.triangle import edge_functions, sheared, where_met
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    as_int,
    as_uint,
    float_bits,
    lane_floats,
    local_longs,
    mask_bits,
    permuted,
    trailing_zeros,
    where,
)
from lanewise.wide import load_wide, store_wide

#: Leaf tests of some rays. rays, places: local longs, number of the ray and word where the block
#: starts; bits: local longs, the triangles that are hit; numbers: local floats, RECORD for each
#: test: t, u and v of all triangles of the block.
LeafTests = namedtuple("LeafTests", "rays places bits numbers")
RECORD = 3 * WIDTH

#: What a leaf test found in the block at `at`. bits: the triangles that are hit, or
#: `SOMETHING_ELSE`; numbers[k : k + RECORD]: t, u and v of all.
BlockHits = namedtuple("BlockHits", "at bits numbers k")

#: In the place of the triangles that are hit: the block holds something else.
SOMETHING_ELSE = 1 << WIDTH


@kernel(strict=True)
def new_leaf_tests():
    """Room for a leaf test of each ray."""
    return LeafTests(local_longs(MOST), local_longs(MOST), local_longs(MOST), lane_floats(RECORD))


@kernel(strict=True)
def meet_block(search, at, ray, t, numbers, k):
    """The triangles (bits) of the block at `at` that a ray hits up to t: all tested at once.

    Written to numbers[k : k + RECORD]: t of each triangle and, where the nearest is wanted, u, v.
    """
    blocks = search.tree.blocks
    x = load_wide(WIDTH, blocks, at + ray.row_x) - ray.o.x
    y = load_wide(WIDTH, blocks, at + ray.row_y) - ray.o.y
    z = load_wide(WIDTH, blocks, at + ray.row_z) - ray.o.z
    x, y = sheared(Vec3(x, y, z), ray.shear)
    corners = float_bits(load_wide(WIDTH, blocks, at + CORNERS))
    a, b, c = corners & 15, (corners >> 4) & 15, (corners >> 8) & 15
    az, bz, cz = permuted(z, a), permuted(z, b), permuted(z, c)
    w, inside = edge_functions(
        (permuted(x, a), permuted(y, a)),
        (permuted(x, b), permuted(y, b)),
        (permuted(x, c), permuted(y, c)),
    )
    found, u, v = where_met(w, az, bz - az, cz - az, ray.shear)
    store_wide(numbers, k, found)
    if search.nearest:
        store_wide(numbers, k + WIDTH, u)
        store_wide(numbers, k + 2 * WIDTH, v)
    return mask_bits(inside & (found > 0.0) & (found <= t))


@kernel(strict=True)
def take_hit(search, hits, best):
    """`best` after a leaf test with hits: the closer one wins, ties go to the lower index.

    Where any hit will do the search is over.
    """
    blocks, at, bits, numbers, k = search.tree.blocks, hits.at, hits.bits, hits.numbers, hits.k
    if not search.nearest:
        return SingleHit(as_float(-1), 0, best.face, best.u, best.v)
    while bits != 0:
        i = trailing_zeros(bits)
        bits &= bits - 1
        t, index = numbers[k + i], as_int(float_bits(blocks[at + IDS + i]))
        if (t < best.t) | ((t == best.t) & (index < best.index)):
            best = SingleHit(
                t, index, best.face, numbers[k + WIDTH + i], numbers[k + 2 * WIDTH + i]
            )
    return best


@kernel(strict=True)
def run_leaf_tests(search, packet, count, others):
    """Run the first `count` of a packet's leaf tests, and note what the rays found.

    Parameters
    ----------
    search : Search
    packet : Packet
    count : int
    others : kernel (search, hits, ray, best) -> SingleHit, or None
        In the place of `take_hit` where there are blocks of something else than triangles
        (`other_leaves`).
    """
    blocks, rays, hits, tests = search.tree.blocks, packet.rays, packet.hits, packet.tests
    found = 0
    for k in range(count):
        i, at = tests.rays[k], tests.places[k]
        ray = triangle_ray_of(rays, i)
        bits = meet_block(search, at, ray, hits.t[i], tests.numbers, RECORD * found)
        if others is not None:
            last_corners = as_int(float_bits(blocks[at + IDS - 1]))
            bits = where(last_corners == OTHER, SOMETHING_ELSE, bits)
        tests.rays[found], tests.places[found], tests.bits[found] = i, at, bits
        found += where(bits != 0, 1, 0)
    for k in range(found):
        i = tests.rays[k]
        block_hits = BlockHits(tests.places[k], tests.bits[k], tests.numbers, RECORD * k)
        best = SingleHit(
            hits.t[i], as_int(hits.index[i]), as_int(hits.face[i]), hits.u[i], hits.v[i]
        )
        if others is None:
            best = take_hit(search, block_hits, best)
        else:
            ray = Ray(vector_of(rays, ORIGIN, i), vector_of(rays, DIRECTION, i), best.t, i)
            best = others(search, block_hits, ray, best)
        hits.t[i] = best.t
        if search.nearest:
            hits.u[i], hits.v[i] = best.u, best.v
            hits.index[i], hits.face[i] = as_uint(best.index), as_uint(best.face)
