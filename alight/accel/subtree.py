"""Build kernels: the binary tree over a set of primitives, and its leaves as blocks.

A tree is built as rows (`collapse`). Its leaves say where their primitives are in `order`; `pack`
turns them into blocks, and writes all rows that have become children to their nodes.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.collapse import (
    BLOCKS,
    COLUMN,
    COUNT,
    FIRST,
    NOT_A_COLUMN,
    NUMBER,
    OWNER,
    RIGHT,
    ROW,
    set_word,
    word_of,
)
from alight.accel.layout import (
    BLOCK,
    CHILD,
    CHILDREN,
    CORNERS,
    HALVED_LEVELS,
    IDS,
    LEAF,
    NODE,
    OTHERS_IN_LEAF,
    SAH_LEVELS,
    UPPER,
    WIDTH,
)
from alight.accel.references import COUNTS, TABLE
from alight.accel.splitting import Rules, divide
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    as_uint,
    bits_float,
    float_bits,
    local_floats,
    local_longs,
    mask_bits,
    trailing_zeros,
)
from lanewise.wide import load_wide, store_wide

#: What blocks are made from. Views vertices (float32) and faces (int32); triangles: how many;
#: others: rows of BLOCK floats, the blocks of primitives number `triangles` and on.
Source = namedtuple("Source", "vertices faces triangles others")

#: Records that wait while the left parts before them are divided, and their numbers.
_WAITING = SAH_LEVELS + HALVED_LEVELS + 2
_RECORDS = 16 * _WAITING
_RANGES = 3 * _WAITING


@kernel(strict=True)
def begin_with(records, ranges, i, target, target_ranges):
    """Record i of one list becomes the first of another."""
    store_wide(target, 0, load_wide(8, records, 16 * i))
    store_wide(target, 8, load_wide(8, records, 16 * i + 8))
    for k in range(3):
        target_ranges[k] = ranges[3 * i + k]


@kernel(strict=True)
def exchange_records(records, ranges, i, j):
    """Records i and j change places."""
    for k in range(0, 16, 8):
        first, second = load_wide(8, records, 16 * i + k), load_wide(8, records, 16 * j + k)
        store_wide(records, 16 * i + k, second)
        store_wide(records, 16 * j + k, first)
    for k in range(3):
        ranges[3 * i + k], ranges[3 * j + k] = ranges[3 * j + k], ranges[3 * i + k]


@kernel(strict=True)
def place_of(packed, at, n, vertices, vertex):
    """The column of a vertex among the n of the block that starts at `at`; n if it is not there."""
    x, y, z = vertices[vertex], vertices[vertex + 1], vertices[vertex + 2]
    same = (
        (load_wide(WIDTH, packed, at) == x)
        & (load_wide(WIDTH, packed, at + WIDTH) == y)
        & (load_wide(WIDTH, packed, at + 2 * WIDTH) == z)
    )
    return trailing_zeros((mask_bits(same) & ((1 << n) - 1)) | (1 << n))


@kernel(strict=True)
def write_block(order, first, count, packed, at, source):
    """Write up to `count` triangles, ``order[first]`` and on, into one block; how many fit."""
    n, done = 0, 0
    while (done < count) & (done < WIDTH):
        index = as_int(order[first + done])
        before, word = n, 0
        for corner in range(3):
            vertex = 3 * as_int(source.faces[3 * index + corner])
            i = place_of(packed, at, n, source.vertices, vertex)
            if i < WIDTH:
                for k in range(3):
                    packed[at + k * WIDTH + i] = source.vertices[vertex + k]
            n = max(n, i + 1)
            word |= i << (4 * corner)
        if n > WIDTH:
            n = before
            break
        packed[at + CORNERS + done] = bits_float(as_uint(word))
        packed[at + IDS + done] = bits_float(as_uint(index))
        done += 1
    for i in range(n, WIDTH):
        for k in range(3):
            packed[at + k * WIDTH + i] = packed[at + k * WIDTH]
    for i in range(done, WIDTH):
        packed[at + CORNERS + i] = packed[at + CORNERS + done - 1]
        packed[at + IDS + i] = packed[at + IDS + done - 1]
    return done


@kernel(strict=True)
def list_primitives(work, ranges, i, source):
    """Write the primitives of record i to their places in `order`, triangles first.

    Returns how many blocks the triangles fill, and the others: each has one for itself.
    """
    references = work.a if ranges[3 * i + 2] == 0 else work.b
    begin, end = ranges[3 * i], ranges[3 * i + 1]
    front, back = begin, end - 1
    for r in range(begin, end):
        primitive = float_bits(references[8 * r + 3])
        if as_int(primitive) < source.triangles:
            work.order[front] = primitive
            front += 1
        else:
            work.order[back] = primitive
            back -= 1
    packed = local_floats(BLOCK)
    done, blocks = begin, 0
    while done < front:
        done += write_block(work.order, done, front - done, packed, 0, source)
        blocks += 1
    return blocks, end - front


@kernel(strict=True)
def build_subtree(work, rows, task_records, task_ranges, record, task, rules, source, totals):
    """Build the binary tree over one record.

    Parameters
    ----------
    work : Workspace
    rows : View of float32
        Room for 2 n rows if there are n primitives; written, but for costs (`collapse`).
    task_records, task_ranges : Views
        Records (float32) and their ranges (int64); `record` is the one to build.
    rules : Rules
    source : Source
    totals : View of int64
        Written at 3 `task`: rows, blocks, leaves.
    """
    records, ranges = local_floats(_RECORDS), local_longs(_RANGES)
    parents, levels = local_longs(_WAITING), local_longs(_WAITING)
    table, counts = local_floats(TABLE), local_longs(COUNTS)
    row, blocks, leaves = 0, 0, 0
    begin_with(task_records, task_ranges, record, records, ranges)
    parents[0], levels[0] = -1, 0
    size = 1
    while size > 0:
        i = size - 1
        level = levels[i]
        if parents[i] >= 0:
            set_word(rows, parents[i], RIGHT, row)
        store_wide(rows, ROW * row, load_wide(8, records, 16 * i))
        count = ranges[3 * i + 1] - ranges[3 * i]
        by_count = level >= SAH_LEVELS
        flat, others = 0, 0
        inner = count > rules.fill
        if inner:
            inner = divide(work, records, ranges, i, size, table, counts, rules, by_count)
        if not inner:
            flat, others = list_primitives(work, ranges, i, source)
            if (flat > 1) | (others > OTHERS_IN_LEAF):
                # Triangles were expected to fit one block, and the others are too many.
                n = flat + others
                less = Rules(rules.method, (count + n - 1) // n)
                inner = divide(work, records, ranges, i, size, table, counts, less, by_count)
        if inner:
            # The left part is taken up next.
            exchange_records(records, ranges, i, size)
            parents[i], parents[size] = row, -1
            levels[i], levels[size] = level + 1, level + 1
            size += 1
        else:
            n = flat + others
            set_word(rows, row, RIGHT, 0)
            set_word(rows, row, FIRST, ranges[3 * i])
            set_word(rows, row, COUNT, count)
            set_word(rows, row, BLOCKS, n)
            blocks += n
            leaves += 1
            size -= 1
        row += 1
    totals[3 * task], totals[3 * task + 1], totals[3 * task + 2] = row, blocks, leaves


@kernel(strict=True)
def write_leaf(order, first, n, blocks, block, source):
    """The primitives ``order[first : first + n]`` as blocks from number `block` on.

    Returns the number of the next free block.
    """
    flat = 0
    while flat < n:
        if as_int(order[first + flat]) >= source.triangles:
            break
        flat += 1
    done = 0
    while done < flat:
        done += write_block(order, first + done, flat - done, blocks, BLOCK * block, source)
        block += 1
    for r in range(flat, n):
        row = as_int(order[first + r]) - source.triangles
        for k in range(BLOCK):
            blocks[BLOCK * block + k] = source.others[BLOCK * row + k]
        block += 1
    return block


@kernel(strict=True)
def pack(order, rows, first, end, nodes, blocks, block, source):
    """Write what has become of rows `first` to `end`: children of nodes, and blocks.

    Parameters
    ----------
    order : View of u32
        Primitives in the order of the leaves.
    rows : View of float32
        A whole tree with its columns (`collapse.assign_columns`).
    nodes, blocks : Views of float32
        Written; blocks from number `block` on.
    source : Source
    """
    for row in range(first, end):
        column = word_of(rows, row, COLUMN)
        if column == NOT_A_COLUMN:
            continue
        at = NODE * word_of(rows, row, OWNER) + column
        for k in range(3):
            nodes[at + CHILDREN * k] = rows[ROW * row + k]
            nodes[at + UPPER + CHILDREN * k] = -rows[ROW * row + 4 + k]
        code = word_of(rows, row, NUMBER)
        if word_of(rows, row, RIGHT) == 0:
            n = word_of(rows, row, COUNT)
            next_block = write_leaf(order, word_of(rows, row, FIRST), n, blocks, block, source)
            code = LEAF | (block << 4) | (next_block - block)
            block = next_block
        nodes[at + CHILD] = bits_float(as_uint(code))
