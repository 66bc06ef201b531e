"""Single-ray traversal of the bounding volume hierarchy: how rays meet the mesh of an instance."""

from __future__ import annotations

from alight.accel.layout import BLOCK, CHILDREN, LEAF
from alight.accel.leaf_test import RECORD, BlockHits, meet_block, take_hit
from alight.accel.node_test import SHRINK, is_traceable
from alight.accel.rays import NONE, SingleHit, box_ray, triangle_ray
from alight.accel.stack import ROOM, Stacks, open_node
from lanewise.jit import kernel
from lanewise.simd import as_float, as_int, as_uint, local_floats, local_uints


@kernel(strict=True)
def trace_single_ray(search, root, ray):
    """What one ray meets in a tree of triangles only.

    Parameters
    ----------
    search : Search
    root : int
        Number of the node to start from.
    ray : Ray
        Scalars; origin in metres, the direction's length is the unit of t.

    Returns
    -------
    SingleHit
        index `NONE` for a miss; of primitives at the same t the one with the lowest index.
    """
    best = SingleHit(ray.t, NONE, 0, as_float(0), as_float(0))
    if is_traceable(ray.o, ray.d, ray.t):
        boxes, triangles = box_ray(ray.o, ray.d), triangle_ray(ray.o, ray.d)
        stacks = Stacks(local_uints(ROOM), local_floats(ROOM), local_floats(CHILDREN))
        stacks.codes[0], stacks.entries[0] = as_uint(root), as_float(0)
        numbers, size = local_floats(RECORD), 1
        while (size > 0) & (best.t > 0.0):
            size -= 1
            code = as_int(stacks.codes[size])
            if search.nearest and stacks.entries[size] * SHRINK > best.t:
                continue
            if code < LEAF:
                # The next step waits for what is on top, so a guess of it is worth having.
                size = open_node(search, code, boxes, best.t, stacks, size, True)
                continue
            at = BLOCK * ((code & (LEAF - 1)) >> 4)
            for _ in range(code & 15):
                bits = meet_block(search, at, triangles, best.t, numbers, 0)
                if bits != 0:
                    best = take_hit(search, BlockHits(at, bits, numbers, 0), best)
                at += BLOCK
    return best
