"""The rays of a packet through the bounding volume hierarchy: together, then in turns.

Nodes that enough of them enter they open together (`packet`). After that each continues alone,
but all take their steps at the same time: a turn pops the next entry from the stack of each ray,
opens all nodes, then visits all leaves. Which children a ray hits, and whether it hits anything, is
unpredictable; so no branch depends on it, and the latencies of all rays overlap. Decision 11 has
the reasons.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import BLOCK, CHILDREN, LEAF
from alight.accel.leaf_test import data_of_all, no_visits, write_visit_all
from alight.accel.node_test import SHRINK
from alight.accel.packet import OWN, WAITING, write_together
from alight.accel.rays import MOST, NUMBERS, ROWS, Rays, box_ray_of, write_rays
from alight.accel.stack import Stacks, write_open_node
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    as_uint,
    bits_mask,
    gather,
    lane_index,
    load_lanes,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    trailing_zeros,
    where,
)

_STACKS = OWN * MOST


def write_apart(visit_all: Callable, nearest_first: bool) -> Callable:
    """The second part of a packet's traversal; parameters as of `write_together`."""
    open_node = write_open_node(nearest_first)

    @kernel(strict=True)
    def apart(tree, data, rays, bits, hits, stacks, bases, visits):
        """Take the rays in `bits` to their ends, each alone.

        Parameters as of `write_together`: what waits for ray i stands from ``bases[i]`` on, up to
        number ``OWN * i + WAITING``; behind it there is room for a stack.
        """
        sizes, codes, entries = local_uints(MOST), local_uints(MOST), local_floats(CHILDREN)
        bottom = load_lanes(bases, 0)
        store_lanes(sizes, 0, OWN * lane_index() + WAITING)
        going = bits_mask(bits)
        while True:
            size, t = load_lanes(sizes, 0), load_lanes(hits.t, 0)
            going = going & (size > bottom)
            if not nearest_first:
                going = going & (t > 0.0)
            if mask_bits(going) == 0:
                break
            size = where(going, size - 1, bottom)
            code = gather(stacks.codes, size)
            near = going
            if nearest_first:
                near = near & (gather(stacks.entries, size) * SHRINK <= t)
            store_lanes(sizes, 0, size)
            store_lanes(codes, 0, code)
            leaf = near & (code >= LEAF)
            opening = mask_bits(near & ~leaf)
            while opening != 0:
                i = trailing_zeros(opening)
                opening &= opening - 1
                ray, size_of_ray = box_ray_of(rays, i), as_int(sizes[i])
                # Where rays wait for memory a node costs more than a wrong guess.
                size_of_ray = open_node(
                    tree, as_int(codes[i]), ray, hits.t[i], stacks, size_of_ray, entries,
                    tree.waits != 0,
                )  # fmt: skip
                sizes[i] = as_uint(size_of_ray)
            visiting, block = mask_bits(leaf), 0
            while visiting != 0:
                count = 0
                while visiting != 0:
                    i = trailing_zeros(visiting)
                    visiting &= visiting - 1
                    visits.rays[count] = i
                    visits.places[count] = BLOCK * (((as_int(codes[i]) & (LEAF - 1)) >> 4) + block)
                    count += 1
                visit_all(tree, data, rays, hits, visits, count)
                block += 1
                visiting = mask_bits(leaf & ((code & 15) > block))

    return apart


@lru_cache(maxsize=64)
def write_packet(
    settle: Callable, nearest_first: bool, mixed: bool = False, of_ray: Callable = data_of_all
) -> Callable:
    """The traversal for the rays of a packet.

    Parameters
    ----------
    settle : kernel
        What a ray makes of what it found in a block, as `leaf_test.closest_of_hits`.
    nearest_first : bool
        False where any hit will do.
    mixed : bool
        Whether there are blocks of something else than triangles (`layout`).
    of_ray : kernel (data, i) -> data
        What `settle` is given of `data` for ray i.
    """
    visit_all = write_visit_all(settle, mixed, nearest_first, of_ray)
    together = write_together(visit_all, nearest_first)
    apart = write_apart(visit_all, nearest_first)

    @kernel(strict=True)
    def packet(tree, data, o, d, bits, hits):
        """What each of some rays meets.

        Parameters
        ----------
        tree : Bvh
        data : View
            Rows of analytic shapes.
        o, d : Vec3 of lanes
            Origins, metres, and directions, whose length is the unit of t.
        bits : int
            The lanes that are wanted; their rays are finite and have a direction.
        hits : Hits
            In: the largest t that counts, and `NONE`. Out: what was found; of primitives at the
            same t the one with the lowest (shape, prim). Where any will do (`leaf_test`): t -1.
        """
        rays = Rays(local_floats(NUMBERS), local_uints(ROWS))
        stacks, bases = Stacks(local_uints(_STACKS), local_floats(_STACKS)), local_uints(MOST)
        visits = no_visits()
        write_rays(rays, o, d)
        store_lanes(bases, 0, OWN * lane_index() + WAITING)
        together(tree, data, o, rays, bits, hits, stacks, bases, visits)
        apart(tree, data, rays, bits, hits, stacks, bases, visits)

    return packet
