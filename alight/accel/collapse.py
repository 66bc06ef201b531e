"""Build kernels: from a binary tree to one whose nodes have up to CHILDREN children.

A node has as many columns as it may have children, and takes up what gives the tree the least
cost: what the subtree of a row costs at best if it is given 1, 2, ... CHILDREN columns follows from
the same numbers of its two parts (dynamic programming after Ylitie, Karras and Laine 2017,
Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, section 3.2). Costs are
surface areas: one for each node, and one for each block of a leaf, as a ray takes about as long for
either.

*Rows* of the binary tree are in preorder, so the left part of row v is row v + 1:

======  ==================================================================
word    meaning (32 words, two cache lines)
======  ==================================================================
0..7    box, as that of a reference (`references`)
8       row of the right part; 0 for a leaf
9       first primitive of a leaf (in the order of the leaves)
10      number of primitives of a leaf
11      number of blocks of a leaf
12      columns that it is given; then its column in a node, or NOT_A_COLUMN
13      the node whose columns it is given
14      number of the node that it is the root of
15      levels of nodes above it
16..31  the least cost of its subtree in 1, 2, ... CHILDREN columns
======  ==================================================================
"""

from __future__ import annotations

from alight.accel.layout import CHILDREN, CHOSEN_LEVELS
from alight.accel.references import half_area
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    as_int,
    as_uint,
    bits_float,
    float_bits,
    local_floats,
    minimum,
)
from lanewise.wide import lane, load_wide, store_wide, wide

ROW = 32
RIGHT, FIRST, COUNT, BLOCKS, COLUMN, OWNER, NUMBER, LEVEL = range(8, 16)
COSTS = 16

#: In the place of a column: the row has been taken up by the node, its parts have the columns.
NOT_A_COLUMN = 0xFFFFFFFF

_SHIFTED = 2 * CHILDREN


@kernel(strict=True)
def word_of(rows, row, k):
    """Whole number k of a row."""
    return as_int(float_bits(rows[ROW * row + k]))


@kernel(strict=True)
def set_word(rows, row, k, value):
    """Write whole number k of a row."""
    rows[ROW * row + k] = bits_float(as_uint(value))


@kernel(strict=True)
def write_costs(rows, row, scale, shifted):
    """The costs of a row whose parts have theirs.

    scale: areas are in units of 1 / scale^2; shifted: 2 CHILDREN local floats.
    """
    at = ROW * row
    area = half_area(load_wide(8, rows, at), scale)
    right = word_of(rows, row, RIGHT)
    if right == 0:
        blocks = as_float(word_of(rows, row, BLOCKS))
        store_wide(rows, at + COSTS, wide(CHILDREN, area * blocks))
        return
    # Lane i is the cost in i + 1 columns, k of them for the left part.
    store_wide(shifted, 0, wide(CHILDREN, INFINITY))
    store_wide(shifted, CHILDREN, load_wide(CHILDREN, rows, ROW * right + COSTS))
    both = wide(CHILDREN, INFINITY)
    for k in range(1, CHILDREN):
        left = rows[at + ROW + COSTS + k - 1]
        both = minimum(both, load_wide(CHILDREN, shifted, CHILDREN - k) + left)
    store_wide(rows, at + COSTS, minimum(both, area + lane(both, CHILDREN - 1)))


@kernel(strict=True)
def write_all_costs(rows, count, scale):
    """The costs of rows 0 to `count`, of a whole tree."""
    shifted = local_floats(_SHIFTED)
    for k in range(count):
        write_costs(rows, count - 1 - k, scale, shifted)


@kernel(strict=True)
def write_costs_of(rows, listed, count, scale):
    """The costs of the rows in `listed` (int64, each behind its parts)."""
    shifted = local_floats(_SHIFTED)
    for k in range(count):
        write_costs(rows, listed[k], scale, shifted)


@kernel(strict=True)
def cost_of_share(rows, left, right, columns, k):
    """The cost of two rows in the given columns, k of them for the left one."""
    return rows[ROW * left + COSTS + k - 1] + rows[ROW * right + COSTS + columns - k - 1]


@kernel(strict=True)
def share(rows, row, columns, owner, level):
    """Give the parts of a row the columns of a node at the least cost; that cost.

    Of equals the even one; very deep down always that.
    """
    left, right = row + 1, word_of(rows, row, RIGHT)
    best = columns // 2
    least = cost_of_share(rows, left, right, columns, best)
    if level < CHOSEN_LEVELS:
        for k in range(1, columns):
            cost = cost_of_share(rows, left, right, columns, k)
            if cost < least:
                best, least = k, cost
    give(rows, left, best, owner, level)
    give(rows, right, columns - best, owner, level)
    return least


@kernel(strict=True)
def give(rows, row, columns, owner, level):
    """Let a row know what it has been given."""
    set_word(rows, row, COLUMN, columns)
    set_word(rows, row, OWNER, owner)
    set_word(rows, row, LEVEL, level)


@kernel(strict=True)
def assign_columns(rows, count, used, totals):
    """Choose the nodes: a column for each row, or none.

    Parameters
    ----------
    rows : View of float32
        A whole tree of `count` rows, with costs.
    used : View of int64
        `count` zeros; becomes the number of children of each node.
    totals : View of int64
        Written: nodes, levels.
    """
    nodes, deepest = 1, 0
    give(rows, 0, CHILDREN, 0, 0)
    for row in range(count):
        given, owner = word_of(rows, row, COLUMN), word_of(rows, row, OWNER)
        level = word_of(rows, row, LEVEL)
        inner, taken_up = word_of(rows, row, RIGHT) != 0, False
        if inner & (given > 1):
            least = share(rows, row, given, owner, level)
            # Of equals the one with fewer nodes; the root is one already.
            alone = rows[ROW * row + COSTS]
            taken_up = (row == 0) | (level >= CHOSEN_LEVELS) | (least <= alone)
        if taken_up:
            set_word(rows, row, COLUMN, NOT_A_COLUMN)
            continue
        set_word(rows, row, COLUMN, used[owner])
        used[owner] += 1
        if inner:
            set_word(rows, row, NUMBER, nodes)
            share(rows, row, CHILDREN, nodes, level + 1)
            nodes += 1
            deepest = max(deepest, level + 1)
    totals[0], totals[1] = nodes, deepest + 1
