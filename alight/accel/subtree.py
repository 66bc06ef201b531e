"""Build kernels: from a record (a set of primitives) to its subtree, and the packing of it.

While it is built a node's leaves say where their primitives stand in `order` (word CHILD) and how
many they are (word COUNT, 0 for inner children). `pack` turns them into blocks and writes the nodes
to their final, dense place.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import (
    BLOCK,
    CHILD,
    CORNERS,
    COUNT,
    IDS,
    LEAF,
    MAX_LEAF,
    NODE,
    SAH_DEPTH,
    STACK,
    WIDTH,
)
from alight.accel.references import BINS, fill_bins, largest_edge
from alight.accel.splitting import (
    choose_split,
    divide,
    next_to_divide,
    prefers_leaf,
)
from alight.core.constants import INFINITY
from alight.core.jit import kernel
from alight.core.simd import (
    as_float,
    as_int,
    as_uint,
    bits_float,
    float_bits,
    local_floats,
    local_longs,
    mask_bits,
    trailing_zeros,
)
from alight.core.wide import load_wide, store_wide

#: What blocks are made from. Views vertices (float32) and faces (uint32); triangles: how many;
#: others: rows of BLOCK floats, the blocks of primitives number `triangles` and on.
Source = namedtuple("Source", "vertices faces triangles others")

_TABLE = 8 * (3 * BINS + 2)
_RECORDS = 16 * 8
_STACKED = 16 * STACK
_STACKED_RANGES = 3 * STACK
_COUNTS = 3 * BINS


@kernel(strict=True)
def copy_record(records, ranges, i, target, target_ranges, j):
    """Record i of one list becomes record j of another."""
    store_wide(target, 16 * j, load_wide(8, records, 16 * i))
    store_wide(target, 16 * j + 8, load_wide(8, records, 16 * i + 8))
    for k in range(3):
        target_ranges[3 * j + k] = ranges[3 * i + k]


@kernel(strict=True)
def divide_into_children(work, records, ranges, whole, table, counts, rules, by_count):
    """Divide record 0 into up to 8, largest first; the number of records."""
    scale = 1.0 / largest_edge(load_wide(8, records, 0))
    n = 1
    whole[0] = 0
    while n < 8:
        i = next_to_divide(records, ranges, whole, n, scale, rules, by_count)
        if i < 0:
            break
        if divide(work, records, ranges, i, n, table, counts, rules, by_count):
            whole[n] = 0
            n += 1
        else:
            whole[i] = 1
    return n


@kernel(strict=True)
def expand(work, all_records, all_ranges, i, target, rules, sizes):
    """Divide record i into up to 8, which become records `target` and on; sizes[i]: how many."""
    records, ranges, whole = local_floats(_RECORDS), local_longs(24), local_longs(8)
    table, counts = local_floats(_TABLE), local_longs(_COUNTS)
    copy_record(all_records, all_ranges, i, records, ranges, 0)
    n = divide_into_children(work, records, ranges, whole, table, counts, rules, False)
    for k in range(n):
        copy_record(records, ranges, k, all_records, all_ranges, target + k)
    sizes[i] = n


@kernel(strict=True)
def is_leaf(work, records, ranges, whole, i, table, counts, rules):
    """Should record i be a leaf? Small ones are tried, unless `divide` has said so before."""
    begin, end, side = ranges[3 * i], ranges[3 * i + 1], ranges[3 * i + 2]
    n = end - begin
    if (whole[i] != 0) | (n <= rules.fill):
        return True
    if n > MAX_LEAF:
        return False
    box, centers = load_wide(8, records, 16 * i), load_wide(8, records, 16 * i + 8)
    bins = 4
    fill_bins(work.a if side == 0 else work.b, begin, end, centers, bins, table, counts)
    return prefers_leaf(choose_split(box, centers, table, counts, n, rules), n, rules)


@kernel(strict=True)
def write_child(nodes, node, i, records, ranges):
    """Bounds and primitives of record i into column i of a node."""
    for k in range(3):
        nodes[NODE * node + 8 * k + i] = records[16 * i + k]
        nodes[NODE * node + 24 + 8 * k + i] = -records[16 * i + 4 + k]
    count = ranges[3 * i + 1] - ranges[3 * i]
    nodes[NODE * node + CHILD + i] = bits_float(as_uint(ranges[3 * i]))
    nodes[NODE * node + COUNT + i] = bits_float(as_uint(count))


@kernel(strict=True)
def clear_child(nodes, node, i):
    """Column i of a node: no child, a box that nothing meets."""
    for k in range(3):
        nodes[NODE * node + 8 * k + i] = as_float(0) + INFINITY
        nodes[NODE * node + 24 + 8 * k + i] = as_float(0) - INFINITY
    nodes[NODE * node + CHILD + i] = as_float(0)
    nodes[NODE * node + COUNT + i] = as_float(0)


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
    """Write the primitives of record i to their places in `order`; the number of blocks they fill.

    Triangles come first; each of the others has a block for itself.
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
    done, blocks = begin, end - front
    while done < front:
        done += write_block(work.order, done, front - done, packed, 0, source)
        blocks += 1
    return blocks


@kernel(strict=True)
def build_subtree(work, nodes, task_records, task_ranges, task, depth, rules, source, totals):
    """Build the tree over one record.

    Parameters
    ----------
    work : Workspace
    nodes : View of float32
        Its nodes are written here: as in `layout`, with places in ``work.order`` for blocks.
    task_records, task_ranges : Views
        Records (float32) and their ranges (int64); `task` is the one to build.
    depth : int
        Levels above this subtree.
    rules : Rules
    source : Source
    totals : View of int64
        Written at 4 `task`: nodes, blocks, leaves, levels below and with the root.
    """
    records, ranges, whole = local_floats(_RECORDS), local_longs(24), local_longs(8)
    stacked, stacked_ranges = local_floats(_STACKED), local_longs(_STACKED_RANGES)
    places, levels = local_longs(STACK), local_longs(STACK)
    table, counts = local_floats(_TABLE), local_longs(_COUNTS)
    used, blocks, leaves, deepest = 1, 0, 0, 0
    copy_record(task_records, task_ranges, task, stacked, stacked_ranges, 0)
    places[0], levels[0] = 0, 0
    size = 1
    while size > 0:
        size -= 1
        place, level = places[size], levels[size]
        deepest = max(deepest, level)
        copy_record(stacked, stacked_ranges, size, records, ranges, 0)
        by_count = depth + level >= SAH_DEPTH
        n = divide_into_children(work, records, ranges, whole, table, counts, rules, by_count)
        for i in range(8):
            if i >= n:
                clear_child(nodes, place, i)
                continue
            write_child(nodes, place, i, records, ranges)
            if is_leaf(work, records, ranges, whole, i, table, counts, rules):
                blocks += list_primitives(work, ranges, i, source)
                leaves += 1
            else:
                at = NODE * place
                nodes[at + CHILD + i] = bits_float(as_uint(used))
                nodes[at + COUNT + i] = as_float(0)
                copy_record(records, ranges, i, stacked, stacked_ranges, size)
                places[size], levels[size] = used, level + 1
                size += 1
                used += 1
    totals[4 * task], totals[4 * task + 1] = used, blocks
    totals[4 * task + 2], totals[4 * task + 3] = leaves, deepest + 1


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
def pack(order, built, count, nodes, node, blocks, block, source):
    """Copy a subtree to its final place, its leaves as blocks.

    Parameters
    ----------
    order : View of u32
        Primitives in the order of the leaves.
    built : View of float32
        The subtree's nodes as `build_subtree` leaves them, `count` of them.
    nodes, blocks : Views of float32
        Written from node number `node` and block number `block` on.
    source : Source
    """
    for index in range(count):
        at, target = NODE * index, NODE * (node + index)
        for k in range(0, CHILD, 8):
            store_wide(nodes, target + k, load_wide(8, built, at + k))
        children = 0
        for i in range(8):
            if built[at + i] <= built[at + 24 + i]:
                children += 1
            n = as_int(float_bits(built[at + COUNT + i]))
            child = as_int(float_bits(built[at + CHILD + i]))
            code = node + child
            if n > 0:
                end = write_leaf(order, child, n, blocks, block, source)
                code = LEAF | (block << 4) | (end - block)
                block = end
            nodes[target + CHILD + i] = bits_float(as_uint(code))
        nodes[target + COUNT] = bits_float(as_uint(children))
