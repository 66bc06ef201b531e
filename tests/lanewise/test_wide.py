"""Vectors of a fixed width: permutations, and what a mask leaves."""

import numpy as np
import pytest

from lanewise import permutation
from lanewise.jit import instantiate, kernel
from lanewise.simd import float_bits, permuted, where
from lanewise.view import View
from lanewise.wide import (
    compressed,
    four,
    gather_near,
    high_half,
    join,
    lane,
    load_wide,
    low_half,
    mask_of,
    shuffled,
    smaller,
    store_wide,
    wide,
)

N = 400


def write_permute(way):
    """The kernel that permutes rows of 16; `way` makes it another one for each way to do so."""

    @kernel(strict=True)
    def permute(numbers, orders, out):
        for i in range(N * (way >= 0)):
            order = float_bits(load_wide(16, orders, 16 * i))
            store_wide(out, 16 * i, permuted(load_wide(16, numbers, 16 * i), order))

    return permute


#: What processors can permute: AVX-512, AVX2, neither.
WAYS = {1: {16: True, 8: True}, 2: {16: False, 8: True}, 3: {16: False, 8: False}}


@pytest.mark.parametrize("way", [0, *WAYS])
def test_any_order_of_sixteen_numbers(way, monkeypatch):
    features = permutation._permutation_features()
    wanted = WAYS.get(way, {})
    if any(wanted[n] and not features[n] for n in wanted):
        pytest.skip("this processor has no such instruction")
    if way:
        monkeypatch.setattr(permutation, "_HAS_PERMUTATION", wanted)
    rng = np.random.default_rng(1)
    numbers = rng.normal(size=(N, 16)).astype(np.float32)
    orders = rng.integers(0, 16, (N, 16)).astype(np.uint32)
    out = np.zeros_like(numbers)
    run = instantiate(write_permute(way), compiled=way > 0)
    run(View(numbers), View(orders.view(np.float32)), View(out))
    np.testing.assert_array_equal(out, np.take_along_axis(numbers, orders.astype(np.int64), 1))


@kernel(strict=True)
def compress_rows(numbers, masks, out):
    for i in range(N):
        x = load_wide(8, numbers, 8 * i)
        store_wide(out, 8 * i, compressed(x, mask_of(8, masks[i])))


@pytest.mark.parametrize("compiled", [True, False])
def test_what_a_mask_leaves_stands_side_by_side_in_order(compiled):
    rng = np.random.default_rng(2)
    numbers = rng.normal(size=(N, 8)).astype(np.float32)
    masks = np.arange(N) % 256
    out = np.zeros_like(numbers)
    instantiate(compress_rows, compiled=compiled)(View(numbers), View(masks), View(out))
    for mask, row, found in zip(masks, numbers, out, strict=True):
        wanted = row[[i for i in range(8) if mask >> i & 1]]
        np.testing.assert_array_equal(found[: len(wanted)], wanted)


@kernel(strict=True)
def rearrange(numbers, orders, k, out):
    a, b = load_wide(4, numbers, 0), load_wide(8, numbers, 4)
    store_wide(out, 0, shuffled(a, (1, 2, 0, 3)))
    store_wide(out, 4, shuffled(b, (7, 0, 5, 5)))
    store_wide(out, 8, join(high_half(b), a))
    store_wide(out, 16, low_half(b))
    store_wide(out, 20, four(lane(b, k), lane(a, 1), 7.0, 8.0))
    store_wide(out, 24, gather_near(numbers, k, float_bits(load_wide(4, orders, 0))))
    store_wide(out, 28, smaller(a, wide(4, 2.5)))
    store_wide(out, 32, where(mask_of(4, k), a, wide(4, -1.0)))


@pytest.mark.parametrize("compiled", [True, False])
def test_parts_and_places_of_vectors(compiled):
    """Numbers 0 to 11: a is 0 to 3, b is 4 to 11."""
    numbers, out = np.arange(12, dtype=np.float32), np.zeros(36, np.float32)
    orders = np.array([2, 0, 3, 3], np.uint32).view(np.float32)
    instantiate(rearrange, compiled=compiled)(View(numbers), View(orders), 5, View(out))
    wanted = [
        [1, 2, 0, 3], [11, 4, 9, 9], [8, 9, 10, 11], [0, 1, 2, 3], [4, 5, 6, 7],
        [9, 1, 7, 8], [7, 5, 8, 8], [0, 1, 2, 2.5], [0, -1, 2, -1],
    ]  # fmt: skip
    np.testing.assert_array_equal(out.reshape(-1, 4), wanted)
