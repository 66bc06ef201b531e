"""Build kernels: one split of a big set, each pass in chunks that threads can share.

The passes are `bin_chunk` on every chunk, `choose`, `partition_chunk` on every chunk, `conclude`.
They share tables with one row a chunk, and in front of them row 0: the sum (`Shared`).
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.references import (
    BINS,
    COUNTS,
    TABLE,
    Border,
    fill_bins,
    new_bins,
    partition,
)
from alight.accel.splitting import bin_count, choose_split, write_box
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import minimum
from lanewise.wide import load_wide, store_wide, wide

#: References begin to end, and the row of the tables that is theirs.
Chunk = namedtuple("Chunk", "begin end row")

#: Views of what the passes share. boxes, counts: a row of `Bins` for each chunk; result: int64,
#: written by `choose`.
Shared = namedtuple("Shared", "boxes counts result")


@kernel(strict=True)
def bin_chunk(work, records, i, chunk, shared):
    """Sort a chunk of the references of record i into the bins of its row."""
    bins, ranges = new_bins(), records.ranges
    source = work.a if ranges[3 * i + 2] == 0 else work.b
    per_axis = bin_count(ranges[3 * i + 1] - ranges[3 * i])
    centers = load_wide(8, records.boxes, 16 * i + 8)
    fill_bins(source, chunk.begin, chunk.end, centers, per_axis, bins)
    for k in range(3 * BINS):
        store_wide(shared.boxes, chunk.row * TABLE + 8 * k, load_wide(8, bins.boxes, 8 * k))
        shared.counts[chunk.row * COUNTS + k] = bins.counts[k]


@kernel(strict=True)
def choose(records, i, rows, shared, rules):
    """Sum the rows and choose the split of record i.

    Written to ``shared.result``: axis (-1: none), last bin of the left part, then the references of
    each row that go left.
    """
    bins, counts, result = new_bins(), shared.counts, shared.result
    for k in range(COUNTS):
        box, n = wide(8, INFINITY), 0
        for row in range(1, rows + 1):
            box = minimum(box, load_wide(8, shared.boxes, row * TABLE + 8 * k))
            n += counts[row * COUNTS + k]
        store_wide(bins.boxes, 8 * k, box)
        store_wide(shared.boxes, 8 * k, box)
        bins.counts[k] = n
    n = records.ranges[3 * i + 1] - records.ranges[3 * i]
    box, centers = load_wide(8, records.boxes, 16 * i), load_wide(8, records.boxes, 16 * i + 8)
    split = choose_split(box, centers, bins, n, rules)
    result[0], result[1] = split.axis, split.split
    for row in range(1, rows + 1):
        left = 0
        for b in range(split.split + 1):
            left += counts[row * COUNTS + max(split.axis, 0) * BINS + b]
        result[1 + row] = left


@kernel(strict=True)
def partition_chunk(work, records, i, chunk, left, right, shared):
    """Copy a chunk of the references of record i to both sides, from `left` and `right` on."""
    ranges, result = records.ranges, shared.result
    from_a = ranges[3 * i + 2] == 0
    source, target = (work.a, work.b) if from_a else (work.b, work.a)
    per_axis = bin_count(ranges[3 * i + 1] - ranges[3 * i])
    border = Border(load_wide(8, records.boxes, 16 * i + 8), per_axis, result[0], result[1])
    centers = partition(source, target, chunk.begin, chunk.end, left, right, border)
    at = chunk.row * TABLE + 8 * COUNTS
    store_wide(shared.boxes, at, centers[0])
    store_wide(shared.boxes, at + 8, centers[1])


@kernel(strict=True)
def conclude(records, i, j, rows, shared, middle):
    """After the partition: record i becomes the left part, record j the right one."""
    ranges, result = records.ranges, shared.result
    first, per_axis = result[0] * BINS, bin_count(ranges[3 * i + 1] - ranges[3 * i])
    write_box(records, i, shared.boxes, first, first + result[1])
    write_box(records, j, shared.boxes, first + result[1] + 1, first + per_axis - 1)
    left, right = wide(8, INFINITY), wide(8, INFINITY)
    for row in range(1, rows + 1):
        left = minimum(left, load_wide(8, shared.boxes, row * TABLE + 8 * COUNTS))
        right = minimum(right, load_wide(8, shared.boxes, row * TABLE + 8 * COUNTS + 8))
    store_wide(records.boxes, 16 * i + 8, left)
    store_wide(records.boxes, 16 * j + 8, right)
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = (
        middle,
        ranges[3 * i + 1],
        1 - ranges[3 * i + 2],
    )
    ranges[3 * i + 1], ranges[3 * i + 2] = middle, 1 - ranges[3 * i + 2]
