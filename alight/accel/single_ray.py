"""One ray through the bounding volume hierarchy: how rays meet instances.

The same text serves the search for the nearest hit and that for any: they differ in what a visit to
a block makes of what is hit, and in the order of the stack. Where any hit will do, it sets the end
of the ray to -1, and the search is over.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import BLOCK, CHILDREN, LEAF
from alight.accel.node_test import (
    NONE,
    SHRINK,
    SingleHit,
    box_ray,
    closest_of_block,
    is_traceable,
    meet_triangles,
    triangle_ray,
)
from alight.accel.stack import ROOM, Stacks, write_open_node
from lanewise.jit import kernel
from lanewise.simd import as_float, as_int, as_uint, local_floats, local_uints, mask_bits


@kernel(strict=True)
def any_of_block(blocks, at, ray, best):
    """`best`, with its end at -1 if a triangle of a block is hit."""
    _, _, _, hit = meet_triangles(blocks, at, ray, best.t)
    t = as_float(-1) if mask_bits(hit) != 0 else best.t
    return SingleHit(t, best.index, best.face, best.u, best.v)


@lru_cache(maxsize=2)
def write_single(nearest_first: bool) -> Callable:
    """The traversal for one ray in a tree of triangles only.

    Parameters
    ----------
    nearest_first : bool
        False where any hit will do.
    """
    open_node = write_open_node(nearest_first)
    visit = closest_of_block if nearest_first else any_of_block

    @kernel(strict=True)
    def single(tree, o, d, t_max, root):
        """What one ray meets.

        Parameters
        ----------
        tree : Bvh
        o, d : Vec3 of float32
            Origin, metres, and direction; its length is the unit of t.
        t_max : float
            Largest t that counts.
        root : int
            Number of the node to start from.

        Returns
        -------
        SingleHit
            t <= t_max; of primitives at the same t the one with the lowest index. Where any will
            do: t -1 if there is one.
        """
        best = SingleHit(t_max, NONE, 0, as_float(0), as_float(0))
        if is_traceable(o, d, t_max):
            boxes, triangles = box_ray(o, d), triangle_ray(o, d)
            stacks, entries = Stacks(local_uints(ROOM), local_floats(ROOM)), local_floats(CHILDREN)
            stacks.codes[0], stacks.entries[0] = as_uint(root), as_float(0)
            size = 1
            while (size > 0) & (best.t > 0.0):
                size -= 1
                code = as_int(stacks.codes[size])
                if nearest_first and stacks.entries[size] * SHRINK > best.t:
                    continue
                if code < LEAF:
                    # The next step waits for what is on top, so a guess of it is worth having.
                    size = open_node(tree, code, boxes, best.t, stacks, size, entries, True)
                    continue
                at = BLOCK * ((code & (LEAF - 1)) >> 4)
                for _ in range(code & 15):
                    best = visit(tree.blocks, at, triangles, best)
                    at += BLOCK
        return best

    return single
