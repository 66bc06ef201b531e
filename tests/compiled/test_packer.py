"""Rows of numbers say exactly where tables start, however many there are."""

import numpy as np
import pytest

from alight.compiled.packer import Packer, in_place
from alight.core.errors import AlightError


def packer(*before):
    return Packer({"table": 1}, 1, all_curves=list(before))


def zeros(count):
    """So many zeros, without the memory."""
    return np.broadcast_to(np.float32(0.0), (count,))


def test_a_table_starts_where_its_row_says():
    curves = [np.arange(n, dtype=np.float32) for n in (5, 64, 65, 1)]
    starts = []
    for at in range(4):
        one = packer(*curves[:at])
        one.curve("table", curves[at])
        starts.append(int(one.row[0]))
    joined = np.concatenate(in_place(curves))
    for start, curve in zip(starts, curves, strict=True):
        np.testing.assert_array_equal(joined[start : start + curve.size], curve)


def test_behind_many_numbers_a_start_is_exact_still():
    # 2^25 + 9 is no number of float32; a table that starts there would be read shifted.
    for before in (2**24 + 1, 2**25 + 9, 2**29 + 1):
        one = packer(zeros(before))
        one.curve("table", zeros(3))
        assert before <= int(one.row[0]) < before + 64
        assert int(one.row[0]) % 64 == 0


def test_what_no_row_can_say_is_refused():
    with pytest.raises(AlightError, match="more tables"):
        packer(zeros(2**30)).curve("table", zeros(3))


def test_a_texture_s_name_is_no_texture_yet():
    with pytest.raises(ValueError, match="the texture name 'wood' must be resolved"):
        packer().scalar("table", "wood")
