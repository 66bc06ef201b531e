"""One ray through a bounding volume hierarchy of triangles, nearest boxes first.

It is how a ray meets an instance; `turns` sends whole packets. The stack holds STACK entries, more
than a tree of MAX_DEPTH levels can ask for (`layout`).
"""

from __future__ import annotations

from alight.accel.layout import BLOCK, CHILD, LEAF, NODE, STACK
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


@kernel(strict=True)
def closest_of_triangles(tree, data, block, count, o, d, ray, best):
    """The nearest hit of `best` and the triangles in blocks number `block` and following."""
    at = BLOCK * block
    for _ in range(count):
        best = closest_of_block(tree.blocks, at, ray, best)
        at += BLOCK
    return best


@kernel(strict=True)
def any_of_triangles(tree, data, block, count, o, d, ray, t_max):
    """True if a triangle in blocks number `block` and following is hit."""
    at = BLOCK * block
    for _ in range(count):
        _, _, _, hit = meet_triangles(tree.blocks, at, ray, t_max)
        if mask_bits(hit) != 0:
            return True
        at += BLOCK
    return False


@kernel(strict=True)
def closest_triangle(tree, o, d, t_max, root):
    """The first triangle that one ray meets.

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
        t <= t_max; of primitives at the same t the one with the lowest index.
    """
    nodes = tree.nodes
    best = SingleHit(t_max, NONE, 0, as_float(0), as_float(0))
    if is_traceable(o, d, t_max):
        boxes, triangles = box_ray(o, d), triangle_ray(o, d)
        stack, distances = local_longs(STACK), local_floats(8)
        stack[0], size = root, 1
        while size > 0:
            size -= 1
            key = stack[size]
            if bits_float(key >> 32) * SHRINK > best.t:
                continue
            code = key & 0xFFFFFFFF
            while code < LEAF:
                at = NODE * code
                enter, met = meet_boxes(nodes, at, boxes, best.t)
                bits = mask_bits(met)
                if bits == 0:
                    break
                if bits & (bits - 1) == 0:
                    code = as_int(float_bits(nodes[at + CHILD + trailing_zeros(bits)]))
                else:
                    store_wide(distances, 0, enter)
                    size = push_children(tree, stack, size, bits, distances, at) - 1
                    code = stack[size] & 0xFFFFFFFF
            if code >= LEAF:
                block, count = (code & (LEAF - 1)) >> 4, code & 15
                best = closest_of_triangles(tree, tree.blocks, block, count, o, d, triangles, best)
    return best


@kernel(strict=True)
def any_triangle(tree, o, d, t_max, root):
    """True if one ray meets a triangle with 0 < t <= t_max; parameters as of `closest_triangle`."""
    nodes = tree.nodes
    if is_traceable(o, d, t_max):
        boxes, triangles = box_ray(o, d), triangle_ray(o, d)
        stack = local_longs(STACK)
        stack[0], size = root, 1
        while size > 0:
            size -= 1
            code = stack[size]
            if code < LEAF:
                at = NODE * code
                _, met = meet_boxes(nodes, at, boxes, t_max)
                bits = mask_bits(met)
                while bits != 0:
                    i = trailing_zeros(bits)
                    bits &= bits - 1
                    child = as_int(float_bits(nodes[at + CHILD + i]))
                    fetch_ahead(tree, child)
                    stack[size] = child
                    size += 1
            else:
                block, count = (code & (LEAF - 1)) >> 4, code & 15
                if any_of_triangles(tree, tree.blocks, block, count, o, d, triangles, t_max):
                    return True
    return False
