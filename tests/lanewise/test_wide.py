"""Vectors of a fixed width: permutations, and what a mask leaves."""

import numpy as np
import pytest

from lanewise import permutation
from lanewise.jit import instantiate, kernel
from lanewise.simd import float_bits, permuted
from lanewise.view import View
from lanewise.wide import compressed, load_wide, mask_of, store_wide

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
