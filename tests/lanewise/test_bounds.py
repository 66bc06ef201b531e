"""What machine code would read out of bounds is an error in the twin."""

from __future__ import annotations

import numpy as np
import pytest

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
