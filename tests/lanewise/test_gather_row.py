"""Neighbours of a table in each lane: machine code against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, gather, gather_row, load_lanes, store_lanes
from lanewise.view import View


def _root_of(n):
    @kernel
    def root(table, index, out, count):
        for i in range(0, count, LANES):
            row = gather_row(table, load_lanes(index, i), n)
            store_lanes(out, i, row[0])
            store_lanes(out, count + i, row[1])
            store_lanes(out, (n - 1) * count + i, row[n - 1])
            if n == 4:
                store_lanes(out, 2 * count + i, row[2])

    return root


@pytest.mark.parametrize("n", [2, 3, 4])
@pytest.mark.parametrize("kind", [np.float32, np.uint32])
def test_rows_are_the_neighbours_in_order(n, kind):
    rng = np.random.default_rng(n)
    table, count = rng.permutation(1000).astype(kind), 64
    # The last row ends where the table ends.
    index = np.append(rng.integers(0, 1001 - n, count - 1), 1000 - n).astype(np.uint32)
    out = View(np.zeros(n * count, kind))
    instantiate(_root_of(n))(View(table), View(index), out, count)
    expected = np.stack([table[index + k] for k in range(n)])
    np.testing.assert_array_equal(out.shaped.reshape(n, count), expected)


@pytest.mark.parametrize("index", [-1, 5])
def test_the_twin_refuses_indices_outside_of_a_table(index):
    """In machine code they would be reads out of bounds, which nothing tells."""
    table, lanes = View(np.arange(5, dtype=np.float32)), np.zeros(int(LANES), np.int32)
    assert (gather(table, lanes) == 0.0).all()
    lanes[3] = index
    try:
        told = str(gather(table, lanes))
    except IndexError as error:
        told = str(error)
    assert "out of bounds" in told
