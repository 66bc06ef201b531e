"""Build kernels: one split of a big set, each pass in chunks that threads can share.

The passes are `bin_chunk` on every chunk, `choose`, `partition_chunk` on every chunk, `conclude`.
Tables hold one row a chunk, and in front of them row 0: the sum.
"""

from __future__ import annotations

from alight.accel.references import BINS, COUNTS, TABLE, fill_bins, partition
from alight.accel.splitting import bin_count, choose_split, write_box
from alight.core.constants import INFINITY
from lanewise.jit import kernel
from lanewise.simd import local_floats, local_longs, minimum
from lanewise.wide import load_wide, store_wide, wide


@kernel(strict=True)
def bin_chunk(work, records, ranges, i, begin, end, row, tables, counts):
    """Sort references begin to end of record i into the bins of a row."""
    table, count = local_floats(TABLE), local_longs(COUNTS)
    source = work.a if ranges[3 * i + 2] == 0 else work.b
    bins = bin_count(ranges[3 * i + 1] - ranges[3 * i])
    fill_bins(source, begin, end, load_wide(8, records, 16 * i + 8), bins, table, count)
    for k in range(3 * BINS):
        store_wide(tables, row * TABLE + 8 * k, load_wide(8, table, 8 * k))
        counts[row * COUNTS + k] = count[k]


@kernel(strict=True)
def choose(records, ranges, i, rows, tables, counts, rules, result):
    """Sum the rows and choose the split of record i.

    Parameters
    ----------
    result : View of int64
        Written: axis (-1: none), last bin of the left part, then the references of each row that go
        left.
    """
    table, count = local_floats(TABLE), local_longs(COUNTS)
    for k in range(COUNTS):
        box, n = wide(8, INFINITY), 0
        for row in range(1, rows + 1):
            box = minimum(box, load_wide(8, tables, row * TABLE + 8 * k))
            n += counts[row * COUNTS + k]
        store_wide(table, 8 * k, box)
        store_wide(tables, 8 * k, box)
        count[k] = n
    n = ranges[3 * i + 1] - ranges[3 * i]
    box, centers = load_wide(8, records, 16 * i), load_wide(8, records, 16 * i + 8)
    split = choose_split(box, centers, table, count, n, rules)
    result[0], result[1] = split.axis, split.split
    for row in range(1, rows + 1):
        left = 0
        for b in range(split.split + 1):
            left += counts[row * COUNTS + max(split.axis, 0) * BINS + b]
        result[1 + row] = left


@kernel(strict=True)
def partition_chunk(work, records, ranges, i, begin, end, left, right, result, row, tables):
    """Copy references begin to end of record i to both sides, from `left` and `right` on."""
    from_a = ranges[3 * i + 2] == 0
    source, target = (work.a, work.b) if from_a else (work.b, work.a)
    bins = bin_count(ranges[3 * i + 1] - ranges[3 * i])
    partition(
        source,
        target,
        begin,
        end,
        left,
        right,
        load_wide(8, records, 16 * i + 8),
        bins,
        result[0],
        result[1],
        tables,
        row * TABLE + 8 * COUNTS,
    )


@kernel(strict=True)
def conclude(records, ranges, i, j, rows, tables, result, middle):
    """After the partition: record i becomes the left part, record j the right one."""
    bins = bin_count(ranges[3 * i + 1] - ranges[3 * i])
    first = result[0] * BINS
    write_box(records, 16 * i, tables, first, first + result[1])
    write_box(records, 16 * j, tables, first + result[1] + 1, first + bins - 1)
    left, right = wide(8, INFINITY), wide(8, INFINITY)
    for row in range(1, rows + 1):
        left = minimum(left, load_wide(8, tables, row * TABLE + 8 * COUNTS))
        right = minimum(right, load_wide(8, tables, row * TABLE + 8 * COUNTS + 8))
    store_wide(records, 16 * i + 8, left)
    store_wide(records, 16 * j + 8, right)
    ranges[3 * j], ranges[3 * j + 1], ranges[3 * j + 2] = (
        middle,
        ranges[3 * i + 1],
        1 - ranges[3 * i + 2],
    )
    ranges[3 * i + 1], ranges[3 * i + 2] = middle, 1 - ranges[3 * i + 2]
