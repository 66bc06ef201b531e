"""Interleaved single-ray traversal: each ray of a packet alone, all taking their steps in turn.

In each round the next entry is popped from the stack of each ray, then all nodes are opened, then
all leaves tested. Which children a ray meets, and whether it hits anything, is unpredictable; so no
branch depends on it, and the latencies of all rays overlap. (Trees larger than the cache are the
exception: their children are sorted as they are pushed.) Decisions 11 and 77 have the reasons.
"""

from __future__ import annotations

from alight.accel.layout import BLOCK, LEAF
from alight.accel.leaf_test import run_leaf_tests
from alight.accel.node_test import SHRINK
from alight.accel.packet import OWN, WAITING
from alight.accel.rays import MOST, box_ray_of
from alight.accel.stack import open_node
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    as_uint,
    bits_mask,
    gather,
    lane_index,
    load_lanes,
    local_uints,
    mask_bits,
    store_lanes,
    trailing_zeros,
    where,
)


@kernel(strict=True)
def trace_interleaved(search, packet, bits, others):
    """Take the rays in `bits` to their ends, first through what waits for them (`trace_packet`)."""
    hits, stacks, tests = packet.hits, packet.stacks, packet.tests
    sizes, codes = local_uints(MOST), local_uints(MOST)
    bottom = load_lanes(packet.bases, 0)
    store_lanes(sizes, 0, OWN * lane_index() + WAITING)
    going = bits_mask(bits)
    while True:
        size, t = load_lanes(sizes, 0), load_lanes(hits.t, 0)
        going = going & (size > bottom)
        if not search.nearest:
            going = going & (t > 0.0)
        if mask_bits(going) == 0:
            break
        size = where(going, size - 1, bottom)
        code = gather(stacks.codes, size)
        near = going
        if search.nearest:
            near = near & (gather(stacks.entries, size) * SHRINK <= t)
        store_lanes(sizes, 0, size)
        store_lanes(codes, 0, code)
        leaf = near & (code >= LEAF)
        opening = mask_bits(near & ~leaf)
        while opening != 0:
            i = trailing_zeros(opening)
            opening &= opening - 1
            ray, size_of_ray = box_ray_of(packet.rays, i), as_int(sizes[i])
            # Where rays wait for memory a node costs more than a wrong guess.
            in_order = search.tree.waits != 0
            size_of_ray = open_node(
                search, as_int(codes[i]), ray, hits.t[i], stacks, size_of_ray, in_order
            )
            sizes[i] = as_uint(size_of_ray)
        testing, block = mask_bits(leaf), 0
        while testing != 0:
            count = 0
            while testing != 0:
                i = trailing_zeros(testing)
                testing &= testing - 1
                tests.rays[count] = i
                tests.places[count] = BLOCK * (((as_int(codes[i]) & (LEAF - 1)) >> 4) + block)
                count += 1
            run_leaf_tests(search, packet, count, others)
            block += 1
            testing = mask_bits(leaf & ((code & 15) > block))
