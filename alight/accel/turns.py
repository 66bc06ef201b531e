"""The rays of a packet through the bounding volume hierarchy by turns.

A traversal is a chain of steps each of which waits for what the last one asked of memory. So in a
big tree each ray takes one step, asks for its next node or leaf, and lets the others go on
meanwhile. Where there is little to wait for, as the tree lies in the processor's cache or every ray
visits much of it, each goes to its end before the next one begins (`cost.patience`). What a ray
meets does not depend on the others: its steps are those of `traversal`, in the same order. Decision
11 has the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import CHILD, LEAF, NODE, STACK, WIDTH
from alight.accel.single import (
    SHRINK,
    BoxRay,
    SingleHit,
    TriangleRay,
    fetch_ahead,
    meet_boxes,
    push_children,
    safe_reciprocal,
)
from alight.core.jit import kernel
from alight.core.simd import (
    as_int,
    as_uint,
    bits_float,
    float_bits,
    lanes_u32,
    local_floats,
    local_longs,
    local_uints,
    mask_bits,
    store_lanes,
    trailing_zeros,
    where,
)
from alight.core.vec import Vec3
from alight.core.wide import store_wide, wide
from alight.shapes.triangle import Shear, rotated, shear_of

#: Most lanes that a packet can have.
MOST = 16

#: What is kept of a packet's rays, MOST numbers each: origin, direction, its reciprocal, origin in
#: the order of the shear's axes, shear.
_ORIGIN, _DIRECTION, _RECIPROCAL, _ROTATED, _SHEAR = (3 * MOST * i for i in range(5))
_NUMBERS = 15 * MOST
#: And of whole numbers: rows of the near bounds, then of the shear's axes.
_AXES = 3 * MOST
_ROWS = 6 * MOST
_STACKS = STACK * MOST

#: The step after which a ray has no other.
_DONE = -1


@kernel(strict=True)
def _store(numbers, k, v):
    """Write the three components of a packet's vectors from numbers[k] on."""
    store_lanes(numbers, k, v.x)
    store_lanes(numbers, k + MOST, v.y)
    store_lanes(numbers, k + 2 * MOST, v.z)


@kernel(strict=True)
def _load(numbers, k):
    """Load one ray's vector, whose first component is numbers[k]."""
    return Vec3(numbers[k], numbers[k + MOST], numbers[k + 2 * MOST])


@kernel(strict=True)
def _spread(n, v):
    """One vector in n lanes."""
    return Vec3(wide(n, v.x), wide(n, v.y), wide(n, v.z))


@kernel(strict=True)
def prepare(numbers, rows, o, d):
    """Write down what the box and triangle tests need of each ray of a packet."""
    r = Vec3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z))
    shear = shear_of(d)
    _store(numbers, _ORIGIN, o)
    _store(numbers, _DIRECTION, d)
    _store(numbers, _RECIPROCAL, r)
    _store(numbers, _ROTATED, rotated(o, shear))
    _store(numbers, _SHEAR, Vec3(shear.sx, shear.sy, shear.sz))
    zero = lanes_u32(0)
    store_lanes(rows, 0, where(r.x >= 0.0, zero, 24))
    store_lanes(rows, MOST, where(r.y >= 0.0, zero + 8, 32))
    store_lanes(rows, 2 * MOST, where(r.z >= 0.0, zero + 16, 40))
    store_lanes(rows, _AXES, WIDTH * (zero + shear.kx))
    store_lanes(rows, _AXES + MOST, WIDTH * (zero + shear.ky))
    store_lanes(rows, _AXES + 2 * MOST, WIDTH * (zero + shear.kz))


@kernel(strict=True)
def _box_ray(numbers, rows, i):
    """The `BoxRay` of ray i."""
    return BoxRay(
        _spread(8, _load(numbers, _ORIGIN + i)),
        _spread(8, _load(numbers, _RECIPROCAL + i)),
        as_int(rows[i]),
        as_int(rows[MOST + i]),
        as_int(rows[2 * MOST + i]),
    )


@kernel(strict=True)
def _triangle_ray(numbers, rows, i):
    """The `TriangleRay` of ray i; its shear's axes are in the rows already."""
    shear = _spread(WIDTH, _load(numbers, _SHEAR + i))
    return TriangleRay(
        _spread(WIDTH, _load(numbers, _ROTATED + i)),
        Shear(0, 0, 0, shear.x, shear.y, shear.z),
        as_int(rows[_AXES + i]),
        as_int(rows[_AXES + MOST + i]),
        as_int(rows[_AXES + 2 * MOST + i]),
    )


@kernel(strict=True)
def _pop(stack, base, size, t):
    """The next entry that may hold something nearer than t: (code or _DONE, size)."""
    while size > base:
        size -= 1
        key = stack[size]
        if bits_float(key >> 32) * SHRINK <= t:
            return key & 0xFFFFFFFF, size
    return _DONE, size


@lru_cache(maxsize=64)
def write_closest(closest_of_leaf: Callable) -> Callable:
    """The traversal for closest hits whose leaves are visited by the given kernel."""

    @kernel(strict=True)
    def closest(tree, data, o, d, bits, ts, us, vs, indices, faces):
        """The first primitive that each of some rays meets.

        Parameters
        ----------
        tree : Bvh
        data : View
            Rows of analytic shapes.
        o, d : Vec3 of lanes
            Origins, metres, and directions, whose length is the unit of t.
        bits : int
            The lanes that are wanted; their rays are finite and have a direction.
        ts, us, vs : local floats
            ts[i]: in: largest t that counts for lane i; out: t of its hit, with us[i] and vs[i].
        indices, faces : local uints
            In: `NONE`; out: the hit's index in the tree and face (`SingleHit`). Of primitives at
            the same t the one with the lowest (shape, prim).
        """
        numbers, rows, stack = local_floats(_NUMBERS), local_uints(_ROWS), local_longs(_STACKS)
        codes, sizes, order = local_longs(MOST), local_longs(MOST), local_longs(MOST)
        distances = local_floats(8)
        prepare(numbers, rows, o, d)
        count = 0
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            order[count], codes[i], sizes[i] = i, 0, STACK * i
            count += 1
        while count > 0:
            k = 0
            while k < count:
                i = order[k]
                code, size, left = codes[i], sizes[i], tree.patience
                boxes = _box_ray(numbers, rows, i)
                while (left > 0) & (code != _DONE):
                    left -= 1
                    on = False
                    if code < LEAF:
                        at = NODE * code
                        enter, met = meet_boxes(tree.nodes, at, boxes, ts[i])
                        children = mask_bits(met)
                        on = children != 0
                        if on:
                            if children & (children - 1) == 0:
                                child = CHILD + trailing_zeros(children)
                                code = as_int(float_bits(tree.nodes[at + child]))
                                fetch_ahead(tree, code)
                            else:
                                store_wide(distances, 0, enter)
                                size = push_children(tree, stack, size, children, distances, at) - 1
                                code = stack[size] & 0xFFFFFFFF
                    else:
                        best = SingleHit(ts[i], as_int(indices[i]), as_int(faces[i]), us[i], vs[i])
                        best = closest_of_leaf(
                            tree,
                            data,
                            (code & (LEAF - 1)) >> 4,
                            code & 15,
                            _load(numbers, _ORIGIN + i),
                            _load(numbers, _DIRECTION + i),
                            _triangle_ray(numbers, rows, i),
                            best,
                        )
                        ts[i], us[i], vs[i] = best.t, best.u, best.v
                        indices[i], faces[i] = as_uint(best.index), as_uint(best.face)
                    if not on:
                        code, size = _pop(stack, STACK * i, size, ts[i])
                if code == _DONE:
                    count -= 1
                    order[k] = order[count]
                else:
                    codes[i], sizes[i] = code, size
                    k += 1

    return closest


@lru_cache(maxsize=64)
def write_any(any_of_leaf: Callable) -> Callable:
    """The traversal for occlusion whose leaves are visited by the given kernel."""

    @kernel(strict=True)
    def occluded(tree, data, o, d, bits, ends):
        """Set ends[i] to -1 if lane i of `bits` meets anything with 0 < t <= ends[i].

        Parameters as of `closest`.
        """
        numbers, rows, stack = local_floats(_NUMBERS), local_uints(_ROWS), local_longs(_STACKS)
        sizes, order = local_longs(MOST), local_longs(MOST)
        prepare(numbers, rows, o, d)
        count = 0
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            order[count], sizes[i], stack[STACK * i] = i, STACK * i + 1, 0
            count += 1
        while count > 0:
            k = 0
            while k < count:
                i = order[k]
                size, end, left = sizes[i], ends[i], tree.patience
                boxes = _box_ray(numbers, rows, i)
                while (left > 0) & (size > STACK * i):
                    left -= 1
                    size -= 1
                    code = stack[size]
                    if code < LEAF:
                        at = NODE * code
                        _, met = meet_boxes(tree.nodes, at, boxes, end)
                        children = mask_bits(met)
                        while children != 0:
                            child = CHILD + trailing_zeros(children)
                            children &= children - 1
                            stack[size] = as_int(float_bits(tree.nodes[at + child]))
                            fetch_ahead(tree, stack[size])
                            size += 1
                    elif any_of_leaf(
                        tree,
                        data,
                        (code & (LEAF - 1)) >> 4,
                        code & 15,
                        _load(numbers, _ORIGIN + i),
                        _load(numbers, _DIRECTION + i),
                        _triangle_ray(numbers, rows, i),
                        end,
                    ):
                        ends[i] = -1.0
                        size = STACK * i
                if size == STACK * i:
                    count -= 1
                    order[k] = order[count]
                else:
                    sizes[i] = size
                    k += 1

    return occluded
