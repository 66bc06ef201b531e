"""Which levels of a binary tree a node takes up: the cheapest ones, up to a depth."""

from itertools import product

import numpy as np
import pytest

from alight.accel import batch
from alight.accel.collapse import (
    BLOCKS,
    COLUMN,
    COSTS,
    LEVEL,
    NOT_A_COLUMN,
    NUMBER,
    OWNER,
    RIGHT,
    ROW,
    assign_columns,
    write_all_costs,
)
from alight.accel.cost import sah_cost
from alight.accel.layout import (
    CHILDREN,
    CHOSEN_LEVELS,
    HALVED_LEVELS,
    MAX_DEPTH,
    SAH_LEVELS,
    STACK,
    TOP_LEVELS,
)
from lanewise.jit import instantiate
from lanewise.view import View
from tests.accel.tracing import icosphere, torus


def random_tree(rng, leaves):
    """Parts of each row of a random binary tree in preorder, (left, right), None for a leaf."""
    rows = []

    def add(n):
        row = len(rows)
        rows.append(None)
        if n > 1:
            k = int(rng.integers(1, n))
            left = add(k)
            rows[row] = left, add(n - k)
        return row

    add(leaves)
    return rows


def chain(leaves):
    """Each left part is a leaf."""
    inner = [(2 * k + 1, 2 * k + 2) for k in range(leaves - 1)]
    return [row for parts in inner for row in (parts, None)] + [None]


def boxes_of(parts, rng):
    """A box around those of its parts for each row, and blocks for each leaf."""
    low, high = rng.uniform(-1, 1, (2, len(parts), 3))
    low, high = np.minimum(low, high), np.maximum(low, high)
    for row in range(len(parts) - 1, -1, -1):
        if parts[row]:
            low[row] = np.min(low[list(parts[row])], axis=0)
            high[row] = np.max(high[list(parts[row])], axis=0)
    return low, high, rng.integers(1, 4, len(parts))


def collapsed(parts, low, high, blocks):
    """The rows with costs and columns, nodes, levels."""
    rows = np.zeros((len(parts), ROW), np.float32)
    rows[:, :3], rows[:, 4:7] = low, -high
    words = rows.view(np.uint32)
    for row, pair in enumerate(parts):
        words[row, RIGHT] = pair[1] if pair else 0
        words[row, BLOCKS] = 0 if pair else blocks[row]
    view, found = View(rows), View(np.zeros(2, np.int64))
    used = View(np.zeros(len(parts), np.int64))
    instantiate(write_all_costs)(view, len(parts), 1.0)
    instantiate(assign_columns)(view, len(parts), used, found)
    nodes, levels = found.array
    return view.array.reshape(-1, ROW), used.array[:nodes], int(nodes), int(levels)


def half_areas(low, high):
    x, y, z = (high - low).T
    return x * y + y * z + z * x


def cost_of(parts, area, blocks, node_rows):
    """Cost of the tree whose nodes are these rows; infinite if one has too many children."""

    def children(row):
        return 1 if not parts[row] or row in node_rows else sum(children(k) for k in parts[row])

    if any(sum(children(k) for k in parts[row]) > CHILDREN for row in node_rows):
        return np.inf
    leaves = sum(area[row] * blocks[row] for row, pair in enumerate(parts) if not pair)
    return leaves + sum(area[row] for row in node_rows)


@pytest.mark.parametrize("leaves", [2, CHILDREN, CHILDREN + 1, CHILDREN + 2])
def test_no_other_choice_of_nodes_costs_less(leaves):
    rng = np.random.default_rng(leaves)
    for tree in range(2 if leaves > CHILDREN else 8):
        parts = chain(leaves) if tree == 0 else random_tree(rng, leaves)
        low, high, blocks = boxes_of(parts, rng)
        area = half_areas(low, high)
        rows, used, nodes, _ = collapsed(parts, low, high, blocks)
        words = rows.view(np.uint32)
        taken = {0} | {
            row for row, pair in enumerate(parts) if pair and words[row, COLUMN] != NOT_A_COLUMN
        }
        assert nodes == len(taken)
        found = cost_of(parts, area, blocks, taken)
        # The root is a node in any case.
        others = [row for row, pair in enumerate(parts) if pair and row > 0]
        choices = product([False, True], repeat=len(others))
        if leaves > CHILDREN:
            # Two besides the root are enough for so few leaves.
            choices = (c for c in choices if sum(c) < 3)
        least = min(
            cost_of(
                parts, area, blocks, {0, *(r for r, c in zip(others, choice, strict=True) if c)}
            )
            for choice in choices
        )
        assert found == pytest.approx(least, rel=1e-5)
        # What was planned is what it costs.
        assert rows[0, COSTS] == pytest.approx(found, rel=1e-5)
        assert used.sum() == leaves + nodes - 1


def test_the_columns_of_a_node_are_its_own():
    rng = np.random.default_rng(3)
    parts = random_tree(rng, 300)
    rows, used, nodes, levels = collapsed(parts, *boxes_of(parts, rng))
    words = rows.view(np.uint32)
    columns = words[words[:, COLUMN] != NOT_A_COLUMN]
    places = columns[:, OWNER].astype(int) * CHILDREN + columns[:, COLUMN]
    assert len(np.unique(places)) == len(places) == 300 + nodes - 1
    assert used.max() <= CHILDREN
    assert used.min() >= 2
    assert np.array_equal(np.bincount(columns[:, OWNER].astype(int), minlength=nodes), used)
    inner = columns[columns[:, RIGHT] > 0]
    assert np.array_equal(np.sort(inner[:, NUMBER]), np.arange(1, nodes))
    assert levels == inner[:, LEVEL].max() + 2


def test_very_deep_down_each_node_takes_four_levels():
    rng = np.random.default_rng(4)
    parts = chain(1000)
    _, used, nodes, levels = collapsed(parts, *boxes_of(parts, rng))
    assert np.all(used[:CHOSEN_LEVELS] == CHILDREN)
    left = 999 - CHOSEN_LEVELS * (CHILDREN - 1)
    assert levels == nodes == CHOSEN_LEVELS + -(-left // 4)
    # In a chain all levels are on the way: four of them leave four leaves and the rest.
    assert np.all(used[CHOSEN_LEVELS:-1] == 5)


@pytest.mark.parametrize("corner", [0.0, np.nan])
def test_the_deepest_tree_has_the_levels_that_stacks_have_room_for(corner):
    """A spine of all levels; what hangs on it uses up columns, and nothing costs anything."""
    side, depth = 4, TOP_LEVELS + SAH_LEVELS + HALVED_LEVELS - 2
    parts = []

    def balanced(n):
        row = len(parts)
        parts.append(None)
        if n > 1:
            parts[row] = balanced(n // 2), balanced(n - n // 2)
        return row

    row = 0
    for _ in range(depth):
        parts.append(None)
        parts[row] = balanced(side), len(parts)
        row = len(parts)
    balanced(side)
    low = np.full((len(parts), 3), corner)
    _, used, _, levels = collapsed(parts, low, low, np.ones(len(parts), int))
    assert MAX_DEPTH - 16 < levels <= MAX_DEPTH
    assert used.max() <= CHILDREN
    assert (CHILDREN - 1) * levels + 1 <= STACK


def test_a_single_leaf_stands_in_a_node():
    _, used, nodes, levels = collapsed([None], *boxes_of([None], np.random.default_rng(5)))
    assert (list(used), nodes, levels) == ([1], 1, 1)


@pytest.mark.parametrize("mesh", [icosphere(4), torus(300, 200, 0.2)])
def test_a_tree_from_several_tasks_costs_what_was_planned_for_the_whole(mesh, monkeypatch):
    """Tasks end in the middle of nodes: the rows above them share out their columns."""
    from alight.accel import build

    planned = []
    pack = build._Builder._pack

    def keep(self, rows, starts, totals):
        planned.append((len(starts), float(rows.array[COSTS]), rows.array[:8].copy()))
        return pack(self, rows, starts, totals)

    monkeypatch.setattr(build._Builder, "_pack", keep)
    bvh, stats = batch.build(*mesh)
    tasks, cost, box = planned[-1]
    x, y, z = -(box[:3] + box[4:7]).astype(np.float64)
    scale = 1.0 / max(x, y, z)
    area = (x * y + y * z + z * x) * scale**2
    assert tasks > (1 if len(mesh[1]) > build.SMALLEST_TASK else 0)
    assert stats["depth"] < MAX_DEPTH
    assert sah_cost(bvh) == pytest.approx(cost / area, rel=1e-4)
