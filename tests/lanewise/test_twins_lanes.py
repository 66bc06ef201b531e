"""Packets of the twin may have more lanes: what counts lanes counts all of them."""

from collections import namedtuple

import numpy as np
import pytest

from lanewise.jit import instantiate, kernel
from lanewise.records import local_records, put_records, records_at
from lanewise.simd import (
    LANES,
    MANY,
    WIDEST,
    as_int,
    as_uint,
    bits_mask,
    count_bits,
    lane_index,
    load_lanes,
    local_uints,
    mask_bits,
    packing,
    store_lanes,
    to_float,
    trailing_zeros,
    where,
)
from lanewise.view import View

Pair = namedtuple("Pair", "x index")


@kernel
def count_large(x):
    return count_bits(mask_bits(x > 0.5))


@kernel
def work(numbers, out, n):
    """For each packet: x or -1, the packed lanes and whence they come, and their last three."""
    for i in range(0, n, LANES):
        x = load_lanes(numbers, i)
        large = bits_mask(mask_bits(x > 0.5))
        store_lanes(out, i, where(large, x, -1.0))
        pair = Pair(x, lane_index())
        memory = local_records(2 * WIDEST, pair)
        put_records(memory, 2 * WIDEST, LANES, packing(large), pair)
        packed = records_at(memory, 2 * WIDEST, LANES, pair)
        store_lanes(out, n + i, packed.x)
        store_lanes(out, 2 * n + i, to_float(packed.index))
        places, found = local_uints(WIDEST), local_uints(WIDEST)
        store_lanes(places, 0, lane_index())
        for lane in range(LANES):
            found[lane] = as_uint(0)
        bits = mask_bits(large)
        while bits != 0:
            lane = trailing_zeros(bits)
            bits &= bits - 1
            found[lane] = as_uint(as_int(places[lane]) + count_large(x))
        store_lanes(out, 3 * n + i, to_float(load_lanes(found, 0)))


@pytest.mark.parametrize("lanes", [16, 64, 256])
def test_every_lane_is_counted(lanes):
    n = 1024
    numbers = np.random.default_rng(3).random(n, np.float32)
    numbers[:256] = np.repeat([0.25, 0.75], 128)
    out = View(np.full((4, n), np.nan, np.float32))
    instantiate(work, compiled=False, lanes=lanes)(View(numbers), out, n)
    for i in range(0, n, lanes):
        x = numbers[i : i + lanes]
        large = x > 0.5
        order = np.argsort(~large, kind="stable")
        expected = [
            np.where(large, x, -1.0), x[order], order,
            np.where(large, np.arange(lanes) + large.sum(), 0),
        ]  # fmt: skip
        np.testing.assert_array_equal(out.shaped[:, i : i + lanes], expected)


def test_many_lanes_are_chosen_to_the_bits_and_the_kind_of_numpys_choice():
    """Of any bits, NaN among them, and of numbers beside lanes."""
    rng = np.random.default_rng(3)
    mask = rng.random(MANY) < 0.5
    words, others = rng.integers(0, 1 << 32, (2, MANY), dtype=np.uint32)
    floats, doubles = words.view(np.float32), rng.random(MANY)
    for a, b in (
        (floats, others.view(np.float32)), (floats[::-1], floats), (floats, 0.1), (1, floats),
        (floats, np.float32(-0.0)), (floats, np.float64(0.1)), (floats, True), (floats, words),
        (words, others), (words, 3), (words, 0.5), (words.view(np.int32), -3), (words, words[0]),
        (mask, ~mask), (mask, 1), (doubles, floats), (np.float32(1.0), np.float32(2.0)),
    ):  # fmt: skip
        for first, second in ((a, b), (b, a)):
            found, right = where(mask, first, second), np.where(mask, first, second)
            assert found.dtype == right.dtype
            assert found.tobytes() == right.tobytes()
