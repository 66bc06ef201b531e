"""Build kernels: choosing the plane that divides a set of primitives, and dividing the set.

The surface area heuristic (MacDonald and Booth 1990) holds that a ray which meets a box meets a box
inside it with a chance proportional to its surface area. The cost of a split is then
A(left) blocks(left) + A(right) blocks(right); it is looked for at the borders of a few bins (Wald
2007, On fast construction of SAH-based bounding volume hierarchies).

Each set that still has to be divided has a *record*, a row of `Records`.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import MAX_LEAF
from alight.accel.references import (
    BINS,
    Border,
    bin_scale,
    fill_bins,
    half_area,
    largest_edge,
    new_bins,
    partition,
    union_of_references,
)
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import (
    as_float,
    local_floats,
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

#: boxes: 16 floats a record, its box and then the bounds of its centroids, as in `references`;
#: ranges: 3 whole numbers, its first reference, their end, and which of the two buffers holds them.
Records = namedtuple("Records", "boxes ranges")

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
def cheapest_split(box, centers, per_axis, bins, n, fill):
    """The border of bins with the least surface area cost."""
    right_cost = local_floats(BINS)
    scale = 1.0 / largest_edge(box)
    spread = bin_scale(centers, per_axis)
    best, best_axis, best_split, best_left = as_float(0) + INFINITY, -1, 0, 0
    for axis in range(3):
        if lane(spread, axis) > 0.0:
            union, count = wide(8, INFINITY), 0
            for i in range(per_axis - 1):
                b = per_axis - 1 - i
                count += bins.counts[axis * BINS + b]
                union = minimum(union, load_wide(8, bins.boxes, 8 * (axis * BINS + b)))
                right_cost[b] = where(
                    count > 0, half_area(union, scale) * as_float(blocks_of(count, fill)), 0.0
                )
            union, count = wide(8, INFINITY), 0
            for b in range(per_axis - 1):
                count += bins.counts[axis * BINS + b]
                union = minimum(union, load_wide(8, bins.boxes, 8 * (axis * BINS + b)))
                if (count > 0) & (count < n):
                    cost = (
                        half_area(union, scale) * as_float(blocks_of(count, fill))
                        + right_cost[b + 1]
                    )
                    if cost < best:
                        best, best_axis, best_split, best_left = cost, axis, b, count
    return Split(best_axis, best_split, best_left, best / maximum(half_area(box, scale), 1e-36))


@kernel(strict=True)
def median_split(centers, per_axis, bins, n):
    """The border of bins nearest to the median, on the axis of the widest centroids."""
    spread = bin_scale(centers, per_axis)
    axis = 0
    for k in range(1, 3):
        narrower = (lane(spread, k) > 0.0) & (lane(spread, k) < lane(spread, axis))
        axis = where(narrower | (lane(spread, axis) == 0.0), k, axis)
    best, best_split, best_left, count = 2 * n, 0, 0, 0
    for b in range(per_axis - 1):
        count += bins.counts[axis * BINS + b]
        off = where(2 * count > n, 2 * count - n, n - 2 * count)
        if (count > 0) & (count < n) & (off < best):
            best, best_split, best_left = off, b, count
    return Split(where(best < 2 * n, axis, -1), best_split, best_left, as_float(0))


@kernel(strict=True)
def choose_split(box, centers, bins, n, rules):
    """The split of n references whose bins are filled, by the `Rules`."""
    per_axis = bin_count(n)
    if rules.method == MEDIAN:
        return median_split(centers, per_axis, bins, n)
    return cheapest_split(box, centers, per_axis, bins, n, rules.fill)


@kernel(strict=True)
def write_box(records, i, boxes, first, last):
    """The box of record i: the union of boxes `first` to `last` of bins, numbered over all axes."""
    union = wide(8, INFINITY)
    for b in range(first, last + 1):
        union = minimum(union, load_wide(8, boxes, 8 * b))
    store_wide(records.boxes, 16 * i, union)


@kernel(strict=True)
def halve(work, records, i, j):
    """Divide record i in the middle of its references, whatever they are; the rest becomes j."""
    ranges = records.ranges
    begin, end, side = ranges[3 * i], ranges[3 * i + 1], ranges[3 * i + 2]
    middle = (begin + end) // 2
    ranges[3 * i + 1] = middle
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = middle, end, side
    source = work.a if side == 0 else work.b
    union_of_references(source, records.boxes, 16 * i, begin, middle)
    union_of_references(source, records.boxes, 16 * j, middle, end)


@kernel(strict=True)
def prefers_leaf(split, n, rules):
    """True if n references cost less as a leaf than divided so.

    The step through a node is not counted: most often there is a column to spare (`collapse`).
    """
    leaf_cost = as_float(blocks_of(n, rules.fill))
    return (n <= MAX_LEAF) & ((split.axis < 0) | (split.cost >= leaf_cost))


@kernel(strict=True)
def divide(work, records, i, j, bins, rules, by_count):
    """Divide record i into i and j; False if it is better left as a leaf.

    bins: room for them; by_count: halve it, whatever that costs.
    """
    boxes, ranges = records.boxes, records.ranges
    begin, end, side = ranges[3 * i], ranges[3 * i + 1], ranges[3 * i + 2]
    n = end - begin
    if by_count:
        halve(work, records, i, j)
        return True
    box, centers = load_wide(8, boxes, 16 * i), load_wide(8, boxes, 16 * i + 8)
    source, target = (work.a, work.b) if side == 0 else (work.b, work.a)
    per_axis = bin_count(n)
    fill_bins(source, begin, end, centers, per_axis, bins)
    split = choose_split(box, centers, bins, n, rules)
    if prefers_leaf(split, n, rules):
        return False
    if split.axis < 0:
        halve(work, records, i, j)
        return True
    middle = begin + split.left
    first = split.axis * BINS
    border = Border(centers, per_axis, split.axis, split.split)
    left, right = partition(source, target, begin, end, begin, middle, border)
    write_box(records, i, bins.boxes, first, first + split.split)
    write_box(records, j, bins.boxes, first + split.split + 1, first + per_axis - 1)
    store_wide(boxes, 16 * i + 8, left)
    store_wide(boxes, 16 * j + 8, right)
    ranges[3 * i + 1], ranges[3 * i + 2] = middle, 1 - side
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = middle, end, 1 - side
    return True


@kernel(strict=True)
def divide_alone(work, records, i, j, rules):
    """Divide record i, more than any leaf may have, into i and j."""
    divide(work, records, i, j, new_bins(), rules, False)
