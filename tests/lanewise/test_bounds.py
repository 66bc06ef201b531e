"""What machine code would read out of bounds is an error in the twin; how far bounds may be."""

from __future__ import annotations

import numpy as np
import pytest

from lanewise.jit import instantiate, kernel
from lanewise.simd import gather, gather_row
from lanewise.view import View

TABLE = View(np.arange(5, dtype=np.float32))


@pytest.mark.parametrize("index", [5, -1, 2**31, 2**32 - 1])
@pytest.mark.parametrize("shape", [(), (3,)], ids=["uniform", "lanes"])
def test_gathers_refuse_indices_that_lead_out_of_the_table(index, shape):
    kind = np.int64 if index < 0 else np.uint32
    with pytest.raises(IndexError):
        gather(TABLE, np.full(shape, index, kind))


def test_rows_must_end_within_the_table():
    last = np.uint32([2, 3])
    np.testing.assert_array_equal(gather_row(TABLE, last, 2)[1], [3.0, 4.0])
    with pytest.raises(IndexError):
        gather_row(TABLE, last, 3)


def test_single_numbers_are_not_counted_from_the_end():
    with pytest.raises(IndexError):
        TABLE[-1]
    with pytest.raises(IndexError):
        TABLE[np.int64(-1)] = 0.0
    with pytest.raises(IndexError):
        TABLE[5]
    assert TABLE[4] == 4.0


@kernel
def move(table, source, target):
    table[target] = table[source]


def test_tables_may_be_longer_than_two_to_the_32(tmp_path):
    """As the sums of a huge picture are. A file takes up no more than the pages that are used."""
    far = 2**32 + 5
    table = np.memmap(tmp_path / "table", np.float32, "w+", shape=far + 1)
    table[far] = 7.0
    instantiate(move)(View(table), far, far - 2)
    assert table[far - 2] == 7.0
