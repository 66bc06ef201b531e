"""The rays of a packet through the bounding volume hierarchy: together, then by turns.

What enough of them enter they open together (`together`). For the rest of its way each goes alone.
That is a chain of steps each of which waits for what the last one asked of memory. So in a big tree
each ray takes one step, asks for its next node or leaf, and lets the others go on meanwhile. Where
there is little to wait for, as the tree lies in the processor's cache or every ray visits much of
it, each goes to its end before the next one begins (`cost.patience`). Decision 11 has the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import LEAF
from alight.accel.rays import MOST, NUMBERS, ROWS, Rays, box_ray_of, write_rays
from alight.accel.together import (
    OWN,
    WAITING,
    data_of_all,
    write_together,
    write_visit_one,
)
from alight.accel.traversal import DONE, write_steps
from alight.core.jit import kernel
from alight.core.simd import local_floats, local_longs, local_uints, trailing_zeros

_STACKS = OWN * MOST


def write_apart(visit: Callable, nearest_first: bool, of_ray: Callable = data_of_all) -> Callable:
    """The second part of a packet's traversal; parameters as of `write_packet`."""
    open_node, next_entry = write_steps(nearest_first)
    visit_one = write_visit_one(visit, nearest_first, of_ray)

    @kernel(strict=True)
    def apart(tree, data, rays, bits, hits, stack, bases):
        """Take the rays in `bits` to their ends, each alone.

        Parameters as of `write_together`: what waits for ray i stands from ``stack[bases[i]]`` on,
        up to number ``OWN * i + WAITING``; behind it there is room for a stack.
        """
        codes, sizes, order = local_longs(MOST), local_longs(MOST), local_longs(MOST)
        distances = local_floats(8)
        count = 0
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            codes[i], sizes[i] = next_entry(stack, bases[i], OWN * i + WAITING, hits.t[i])
            if codes[i] != DONE:
                order[count] = i
                count += 1
        while count > 0:
            k = 0
            while k < count:
                i = order[k]
                code, size, left = codes[i], sizes[i], tree.patience
                boxes = box_ray_of(rays, i)
                while (left > 0) & (code != DONE):
                    left -= 1
                    if code < LEAF:
                        code, size = open_node(tree, code, boxes, hits.t[i], stack, size, distances)
                    else:
                        visit_one(tree, data, code, rays, hits, i)
                        code = DONE
                    if code == DONE:
                        code, size = next_entry(stack, bases[i], size, hits.t[i])
                if code == DONE:
                    count -= 1
                    order[k] = order[count]
                else:
                    codes[i], sizes[i] = code, size
                    k += 1

    return apart


@lru_cache(maxsize=64)
def write_packet(visit: Callable, nearest_first: bool, of_ray: Callable = data_of_all) -> Callable:
    """The traversal for the rays of a packet.

    Parameters
    ----------
    visit : kernel (tree, data, block, count, o, d, ray, best) -> SingleHit
        How one ray visits the blocks of a leaf.
    nearest_first : bool
        False where any hit will do.
    of_ray : kernel (data, i) -> data
        What `visit` is given of `data` for ray i.
    """
    together = write_together(visit, nearest_first, of_ray)
    apart = write_apart(visit, nearest_first, of_ray)

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
            same t the one with the lowest (shape, prim). Where any will do (`traversal`): t -1.
        """
        rays = Rays(local_floats(NUMBERS), local_uints(ROWS))
        stack, bases = local_longs(_STACKS), local_longs(MOST)
        write_rays(rays, o, d)
        for i in range(MOST):
            bases[i] = OWN * i + WAITING
        together(tree, data, o, rays, bits, hits, stack, bases)
        apart(tree, data, rays, bits, hits, stack, bases)

    return packet
