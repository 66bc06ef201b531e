"""The traversal stack of a single ray: opening a node onto it."""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import BLOCK, CHILD, CHILDREN, LEAF, NODE, STACK
from alight.accel.node_test import meet_children
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
from lanewise.wide import compressed, load_wide, mask_of, prefetch, store_wide

#: What waits: codes of children (`layout`; local uints) and, if order matters, where the ray enters
#: them (entries, local floats); children: CHILDREN local floats, entries of those being sorted.
Stacks = namedtuple("Stacks", "codes entries children")

#: Room for what waits for one ray: all children of a node are written, whether they are met or not.
ROOM = STACK + CHILDREN


@kernel(strict=True)
def fetch_ahead(tree, code):
    """Bring a child's cache lines in while others are looked at; rays wait mostly for memory."""
    if code < LEAF:
        for line in range(0, NODE, 16):
            prefetch(tree.nodes, NODE * code + line)
    else:
        at = BLOCK * ((code & (LEAF - 1)) >> 4)
        for line in range(0, BLOCK, 16):
            prefetch(tree.blocks, at + line)


@kernel(strict=True)
def push_in_order(search, stacks, size, at, bits):
    """Put the children in `bits` of the node at `at` on a stack, and ask memory for them."""
    tree, base, entries = search.tree, size, stacks.children
    while bits != 0:
        i = trailing_zeros(bits)
        bits &= bits - 1
        child = tree.nodes[at + CHILD + i]
        fetch_ahead(tree, as_int(float_bits(child)))
        j = size
        if search.nearest:
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


@kernel(strict=True)
def open_node(search, code, ray, t, stacks, size, in_order):
    """Put the children of a node that a ray meets before t on its stack, the nearest on top.

    Parameters
    ----------
    search : Search
    code : int
        Number of the node.
    ray : BoxRay
    t : float
    stacks : Stacks
    size : int
        Of the ray's stack, where it starts in `stacks` included.
    in_order : bool
        Whether the other children are in order, too, which takes branches, or in that of the node.
        Where any hit will do, no order matters.

    Returns
    -------
    int
        The new size.
    """
    tree, nearest, at = search.tree, search.nearest, NODE * code
    enter, met = meet_children(tree.nodes, at, ray, t)
    bits = mask_bits(met)
    if in_order:
        if nearest:
            store_wide(stacks.children, 0, enter)
        return push_in_order(search, stacks, size, at, bits)
    count = count_bits(bits)
    below, least, first = met, t, 0
    if nearest:
        least = horizontal_min(where(met, enter, INFINITY))
        first = trailing_zeros(mask_bits(met & (enter == least)) | (1 << (CHILDREN - 1)))
        below = met & ~mask_of(CHILDREN, 1 << first)
    children = float_bits(load_wide(CHILDREN, tree.nodes, at + CHILD))
    store_wide(stacks.codes, size, compressed(children, below))
    if nearest:
        store_wide(stacks.entries, size, compressed(enter, below))
        # Where nothing is met this place is free.
        top = size + count - where(count > 0, 1, 0)
        stacks.codes[top] = float_bits(tree.nodes[at + CHILD + first])
        stacks.entries[top] = least
    return size + count
