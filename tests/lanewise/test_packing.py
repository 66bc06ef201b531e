"""Packing of lanes: the lanes of a mask side by side, in order, then the others."""

import numpy as np
import pytest

from lanewise.jit import instantiate, kernel
from lanewise.machine import lanes_of_machine
from lanewise.simd import (
    LANES,
    bits_mask,
    float_bits,
    load_lanes,
    packing,
    permuted,
    store_lanes,
)
from lanewise.view import View


@kernel
def pack_lanes(masks, numbers, floats, uints, n):
    for i in range(n):
        order = packing(bits_mask(masks[i]))
        x = load_lanes(numbers, LANES * i)
        store_lanes(floats, LANES * i, permuted(x, order))
        store_lanes(uints, LANES * i, permuted(float_bits(x), order))


@pytest.mark.parametrize("compiled", [True, False])
def test_the_lanes_of_a_mask_come_first_and_in_order(compiled):
    # The twin always has packets of 16.
    lanes, n = lanes_of_machine() if compiled else int(LANES), 500
    rng = np.random.default_rng(1)
    masks = rng.integers(0, 1 << lanes, n)
    masks[:2] = 0, (1 << lanes) - 1
    numbers = rng.normal(size=(n, lanes)).astype(np.float32)
    floats, uints = np.zeros_like(numbers), np.zeros((n, lanes), np.uint32)
    pack = instantiate(pack_lanes, compiled=compiled)
    pack(View(masks), View(numbers), View(floats), View(uints), n)
    for mask, row, packed, bits in zip(masks, numbers, floats, uints, strict=True):
        wanted = row[sorted(range(lanes), key=lambda i: (not mask >> i & 1, i))]
        np.testing.assert_array_equal(packed, wanted)
        np.testing.assert_array_equal(bits, wanted.view(np.uint32))
