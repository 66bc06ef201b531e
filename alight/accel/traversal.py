"""One ray through the bounding volume hierarchy, step by step.

A step opens a node or visits a leaf. The same steps serve the search for the nearest hit and that
for any: they differ in the kernel that visits leaves, and in the order of the stack. Where any hit
will do, it sets the end of the ray to -1, so that nothing else is near enough to be looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import BLOCK, CHILD, CHILDREN, LEAF, NODE, STACK
from alight.accel.single import (
    NONE,
    SHRINK,
    SingleHit,
    box_ray,
    closest_of_block,
    fetch_ahead,
    is_traceable,
    meet_boxes,
    meet_triangles,
    push_children,
    triangle_ray,
)
from alight.core.jit import kernel
from alight.core.simd import (
    as_float,
    as_int,
    bits_float,
    float_bits,
    local_floats,
    local_longs,
    mask_bits,
    trailing_zeros,
)
from alight.core.wide import store_wide

#: The step after which a ray has no other.
DONE = -1


@kernel(strict=True)
def closest_of_triangles(tree, data, block, count, o, d, ray, best):
    """The nearest hit of `best` and the triangles in blocks number `block` and following."""
    at = BLOCK * block
    for _ in range(count):
        best = closest_of_block(tree.blocks, at, ray, best)
        at += BLOCK
    return best


@kernel(strict=True)
def blocked(best):
    """What any hit makes of `best`: nothing else counts."""
    return SingleHit(as_float(-1), best.index, best.face, best.u, best.v)


@kernel(strict=True)
def any_of_triangles(tree, data, block, count, o, d, ray, best):
    """`blocked` if a triangle in blocks number `block` and following is hit, else `best`."""
    at = BLOCK * block
    for _ in range(count):
        _, _, _, hit = meet_triangles(tree.blocks, at, ray, best.t)
        if mask_bits(hit) != 0:
            return blocked(best)
        at += BLOCK
    return best


def write_steps(nearest_first: bool) -> tuple[Callable, Callable]:
    """The kernels `open_node` and `next_entry`.

    Parameters
    ----------
    nearest_first : bool
        Whether the stack is kept in order. Where any hit will do, that costs more than it saves.
    """

    @kernel(strict=True)
    def open_node(tree, code, ray, t, stack, size, distances):
        """The child of a node that a ray enters next, or `DONE`, and the size of the stack.

        The other children that it meets before t go on the stack. distances: CHILDREN local floats.
        """
        at = NODE * code
        enter, met = meet_boxes(tree.nodes, at, ray, t)
        bits = mask_bits(met)
        if bits == 0:
            return DONE, size
        if bits & (bits - 1) == 0:
            child = as_int(float_bits(tree.nodes[at + CHILD + trailing_zeros(bits)]))
            fetch_ahead(tree, child)
            return child, size
        if nearest_first:
            store_wide(distances, 0, enter)
            size = push_children(tree, stack, size, bits, distances, at) - 1
            return stack[size] & 0xFFFFFFFF, size
        while bits != 0:
            child = as_int(float_bits(tree.nodes[at + CHILD + trailing_zeros(bits)]))
            bits &= bits - 1
            fetch_ahead(tree, child)
            stack[size] = child
            size += 1
        return stack[size - 1], size - 1

    @kernel(strict=True)
    def next_entry(stack, base, size, t):
        """The next entry that may hold something up to t, or `DONE`, and the size of the stack."""
        if nearest_first:
            while size > base:
                size -= 1
                key = stack[size]
                if bits_float(key >> 32) * SHRINK <= t:
                    return key & 0xFFFFFFFF, size
        elif (size > base) & (t > 0.0):
            return stack[size - 1], size - 1
        return DONE, size

    return open_node, next_entry


@lru_cache(maxsize=8)
def write_single(visit: Callable, nearest_first: bool) -> Callable:
    """The traversal for one ray: how rays meet instances.

    Parameters
    ----------
    visit : kernel (tree, data, block, count, o, d, ray, best) -> SingleHit
        How the ray visits the blocks of a leaf: `closest_of_triangles` or `any_of_triangles`.
    nearest_first : bool
        False where any hit will do.
    """
    open_node, next_entry = write_steps(nearest_first)

    @kernel(strict=True)
    def single(tree, data, o, d, t_max, root):
        """What one ray meets.

        Parameters
        ----------
        tree : Bvh
        data : View
            Rows of analytic shapes.
        o, d : Vec3 of float32
            Origin, metres, and direction; its length is the unit of t.
        t_max : float
            Largest t that counts.
        root : int
            Number of the node to start from.

        Returns
        -------
        SingleHit
            t <= t_max; of primitives at the same t the one with the lowest index.
        """
        best = SingleHit(t_max, NONE, 0, as_float(0), as_float(0))
        if is_traceable(o, d, t_max):
            boxes, triangles = box_ray(o, d), triangle_ray(o, d)
            stack, distances = local_longs(STACK), local_floats(CHILDREN)
            code, size = root, 0
            while code != DONE:
                if code < LEAF:
                    code, size = open_node(tree, code, boxes, best.t, stack, size, distances)
                else:
                    block, count = (code & (LEAF - 1)) >> 4, code & 15
                    best = visit(tree, data, block, count, o, d, triangles, best)
                    code = DONE
                if code == DONE:
                    code, size = next_entry(stack, 0, size, best.t)
        return best

    return single
