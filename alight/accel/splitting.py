"""Build kernels: choosing the plane that divides a set of primitives, and dividing the set.

The surface area heuristic (MacDonald and Booth 1990) holds that a ray which meets a box meets a box
inside it with a chance proportional to its surface area. The cost of a split is then
A(left) blocks(left) + A(right) blocks(right); it is looked for at the borders of a few bins (Wald
2007, On fast construction of SAH-based bounding volume hierarchies).

The *records* of sets that still have to be divided: 16 floats (box, then bounds of the centroids,
as in `references`) and 3 whole numbers (first reference, end, which of the two buffers holds them).
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import MAX_LEAF
from alight.accel.references import (
    BINS,
    COUNTS,
    TABLE,
    bin_scale,
    fill_bins,
    half_area,
    largest_edge,
    partition,
    union_of_references,
)
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    local_floats,
    local_longs,
    maximum,
    minimum,
    where,
)
from lanewise.wide import lane, load_wide, store_wide, wide

#: How splits are chosen.
SAH, MEDIAN = 0, 1

#: method: `SAH` or `MEDIAN`; fill: how many primitives a block is expected to take.
Rules = namedtuple("Rules", "method fill")

#: axis < 0: there is no plane with something on both sides; split: last bin of the left part;
#: left: references in it; cost: of both sides, relative to the box before the split.
Split = namedtuple("Split", "axis split left cost")

#: Views. a, b: buffers of references; order (u32): primitives in the order of the leaves.
Workspace = namedtuple("Workspace", "a b order")


@kernel(strict=True)
def bin_count(n):
    """Bins for n references: few for few, as their boxes cost more than they tell."""
    return where(n >= 16 * (BINS - 4), BINS, 4 + n // 16)


@kernel(strict=True)
def blocks_of(n, fill):
    """Blocks that n primitives take if one takes `fill`."""
    return (n + (fill - 1)) // fill


@kernel(strict=True)
def cheapest_split(box, centers, bins, table, counts, n, fill):
    """The border of bins with the least surface area cost."""
    right_cost = local_floats(BINS)
    scale = 1.0 / largest_edge(box)
    spread = bin_scale(centers, bins)
    best, best_axis, best_split, best_left = as_float(0) + INFINITY, -1, 0, 0
    for axis in range(3):
        if lane(spread, axis) > 0.0:
            union, count = wide(8, INFINITY), 0
            for i in range(bins - 1):
                b = bins - 1 - i
                count += counts[axis * BINS + b]
                union = minimum(union, load_wide(8, table, 8 * (axis * BINS + b)))
                right_cost[b] = where(
                    count > 0, half_area(union, scale) * as_float(blocks_of(count, fill)), 0.0
                )
            union, count = wide(8, INFINITY), 0
            for b in range(bins - 1):
                count += counts[axis * BINS + b]
                union = minimum(union, load_wide(8, table, 8 * (axis * BINS + b)))
                if (count > 0) & (count < n):
                    cost = (
                        half_area(union, scale) * as_float(blocks_of(count, fill))
                        + right_cost[b + 1]
                    )
                    if cost < best:
                        best, best_axis, best_split, best_left = cost, axis, b, count
    return Split(best_axis, best_split, best_left, best / maximum(half_area(box, scale), 1e-36))


@kernel(strict=True)
def median_split(centers, bins, counts, n):
    """The border of bins nearest to the median, on the axis of the widest centroids."""
    spread = bin_scale(centers, bins)
    axis = 0
    for k in range(1, 3):
        narrower = (lane(spread, k) > 0.0) & (lane(spread, k) < lane(spread, axis))
        axis = where(narrower | (lane(spread, axis) == 0.0), k, axis)
    best, best_split, best_left, count = 2 * n, 0, 0, 0
    for b in range(bins - 1):
        count += counts[axis * BINS + b]
        off = where(2 * count > n, 2 * count - n, n - 2 * count)
        if (count > 0) & (count < n) & (off < best):
            best, best_split, best_left = off, b, count
    return Split(where(best < 2 * n, axis, -1), best_split, best_left, as_float(0))


@kernel(strict=True)
def choose_split(box, centers, table, counts, n, rules):
    """The split of n references whose bins are filled, by the `Rules`."""
    bins = bin_count(n)
    if rules.method == MEDIAN:
        return median_split(centers, bins, counts, n)
    return cheapest_split(box, centers, bins, table, counts, n, rules.fill)


@kernel(strict=True)
def write_box(records, at, table, first, last):
    """Union of the bins `first` to `last` of `table` (numbered over all axes) into a record."""
    union = wide(8, INFINITY)
    for b in range(first, last + 1):
        union = minimum(union, load_wide(8, table, 8 * b))
    store_wide(records, at, union)


@kernel(strict=True)
def halve(work, records, ranges, i, j):
    """Divide record i in the middle of its references, whatever they are; the rest becomes j."""
    begin, end, side = ranges[3 * i], ranges[3 * i + 1], ranges[3 * i + 2]
    middle = (begin + end) // 2
    ranges[3 * i + 1] = middle
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = middle, end, side
    source = work.a if side == 0 else work.b
    union_of_references(source, records, 16 * i, begin, middle)
    union_of_references(source, records, 16 * j, middle, end)


@kernel(strict=True)
def prefers_leaf(split, n, rules):
    """True if n references cost less as a leaf than divided so.

    The step through a node is not counted: most often there is a column to spare (`collapse`).
    """
    leaf_cost = as_float(blocks_of(n, rules.fill))
    return (n <= MAX_LEAF) & ((split.axis < 0) | (split.cost >= leaf_cost))


@kernel(strict=True)
def divide(work, records, ranges, i, j, table, counts, rules, by_count):
    """Divide record i into i and j; False if it is better left as a leaf."""
    begin, end, side = ranges[3 * i], ranges[3 * i + 1], ranges[3 * i + 2]
    n = end - begin
    if by_count:
        halve(work, records, ranges, i, j)
        return True
    box, centers = load_wide(8, records, 16 * i), load_wide(8, records, 16 * i + 8)
    source, target = (work.a, work.b) if side == 0 else (work.b, work.a)
    bins = bin_count(n)
    fill_bins(source, begin, end, centers, bins, table, counts)
    split = choose_split(box, centers, table, counts, n, rules)
    if prefers_leaf(split, n, rules):
        return False
    if split.axis < 0:
        halve(work, records, ranges, i, j)
        return True
    middle = begin + split.left
    first = split.axis * BINS
    partition(
        source,
        target,
        begin,
        end,
        begin,
        middle,
        centers,
        bins,
        split.axis,
        split.split,
        table,
        8 * 3 * BINS,
    )
    write_box(records, 16 * i, table, first, first + split.split)
    write_box(records, 16 * j, table, first + split.split + 1, first + bins - 1)
    store_wide(records, 16 * i + 8, load_wide(8, table, 8 * 3 * BINS))
    store_wide(records, 16 * j + 8, load_wide(8, table, 8 * 3 * BINS + 8))
    ranges[3 * i + 1], ranges[3 * i + 2] = middle, 1 - side
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = middle, end, 1 - side
    return True


@kernel(strict=True)
def divide_alone(work, records, ranges, i, j, rules):
    """Divide record i, more than any leaf may have, into i and j."""
    table, counts = local_floats(TABLE), local_longs(COUNTS)
    divide(work, records, ranges, i, j, table, counts, rules, False)
