"""The traversal stack of a ray: opening a node onto it."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import CHILD, CHILDREN, NODE, STACK
from alight.accel.node_test import fetch_ahead, meet_boxes
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    count_bits,
    float_bits,
    horizontal_min,
    mask_bits,
    trailing_zeros,
    where,
)
from lanewise.wide import compressed, load_wide, mask_of, store_wide

#: What waits: codes of children (`layout`; local uints) and, if order matters, where the ray enters
#: them (entries, local floats).
Stacks = namedtuple("Stacks", "codes entries")

#: Room for what waits for one ray: all children of a node are written, whether they are met or not.
ROOM = STACK + CHILDREN


def write_push_in_order(nearest_first: bool) -> Callable:
    """``(tree, stacks, size, at, bits, entries)``: the new size of a ray's stack."""

    @kernel(strict=True)
    def push_in_order(tree, stacks, size, at, bits, entries):
        """Put the children in `bits` of the node at `at` on a stack, and ask memory for them."""
        base = size
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            child = tree.nodes[at + CHILD + i]
            fetch_ahead(tree, as_int(float_bits(child)))
            j = size
            if nearest_first:
                while j > base:
                    if stacks.entries[j - 1] >= entries[i]:
                        break
                    stacks.codes[j] = stacks.codes[j - 1]
                    stacks.entries[j] = stacks.entries[j - 1]
                    j -= 1
                stacks.entries[j] = entries[i]
            stacks.codes[j] = float_bits(child)
            size += 1
        return size

    return push_in_order


@lru_cache(maxsize=2)
def write_open_node(nearest_first: bool) -> Callable:
    """``(tree, code, ray, t, stacks, size, entries, in_order)``: the new size of a ray's stack."""
    push_in_order = write_push_in_order(nearest_first)

    @kernel(strict=True)
    def open_node(tree, code, ray, t, stacks, size, entries, in_order):
        """Put the children of a node that a ray meets before t on its stack, the nearest on top.

        entries: CHILDREN local floats; in_order: whether the others are in order, too, which takes
        branches, or in the order of the node.
        """
        at = NODE * code
        enter, met = meet_boxes(tree.nodes, at, ray, t)
        bits = mask_bits(met)
        if in_order:
            if nearest_first:
                store_wide(entries, 0, enter)
            return push_in_order(tree, stacks, size, at, bits, entries)
        count = count_bits(bits)
        below, nearest, first = met, t, 0
        if nearest_first:
            nearest = horizontal_min(where(met, enter, INFINITY))
            first = trailing_zeros(mask_bits(met & (enter == nearest)) | (1 << (CHILDREN - 1)))
            below = met & ~mask_of(CHILDREN, 1 << first)
        children = float_bits(load_wide(CHILDREN, tree.nodes, at + CHILD))
        store_wide(stacks.codes, size, compressed(children, below))
        if nearest_first:
            store_wide(stacks.entries, size, compressed(enter, below))
            # Where nothing is met this place is free.
            top = size + count - where(count > 0, 1, 0)
            stacks.codes[top] = float_bits(tree.nodes[at + CHILD + first])
            stacks.entries[top] = nearest
        return size + count

    return open_node
