"""What the canary tries of the instructions behind the primitives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lanewise.jit import instantiate, kernel
from lanewise.machine import lanes_of_machine
from lanewise.simd import (
    LANES,
    absolute,
    copysign,
    float_bits,
    floor,
    fma,
    gather,
    gather_row,
    horizontal_max,
    load_lanes,
    maximum,
    minimum,
    packing,
    permuted,
    rint,
    rsqrt,
    sqrt,
    store_lanes,
)
from lanewise.view import View


def numbers() -> View:
    """Four packets of numbers, none of them 1."""
    return View(np.linspace(0.5, 9.0, 4 * lanes_of_machine(), dtype=np.float32))


#: Elementwise functions by the number of their arguments.
ELEMENTWISE = {
    1: (sqrt, rsqrt, floor, rint, absolute, float_bits),
    2: (minimum, maximum, copysign),
    3: (fma,),
}


def try_instructions() -> None:
    """LLVM knows the instructions behind the primitives; its pointers have types."""

    def text(table, order, out):
        x, n = load_lanes(table, 0), table.size
        store_lanes(out, 0, gather(table, load_lanes(order, 0)))
        a, b, c = gather_row(table, load_lanes(order, 0), 3)
        store_lanes(out, n, a + 2.0 * b + 4.0 * c)
        packed = permuted(x, packing(x > 4.0))
        store_lanes(out, 2 * n, packed * horizontal_max(x))

    n = lanes_of_machine()
    table, order = numbers().array[:n].copy(), np.arange(n, dtype=np.uint32)[::-1] % (n - 2)
    out = View(np.zeros(3 * n, np.float32))
    instantiate(kernel(text))(View(table), View(order.copy()), out)
    rows = [table[order + k] for k in range(3)]
    packed = np.concatenate([table[table > 4.0], table[table <= 4.0]])
    expected = [rows[0], rows[0] + 2 * rows[1] + 4 * rows[2], packed * table.max()]
    np.testing.assert_allclose(out.array, np.concatenate(expected), rtol=1e-6)
    for count, functions in ELEMENTWISE.items():
        for function in functions:
            try_elementwise(function, count)


def try_elementwise(function: Callable, count: int) -> None:
    """Compare a function of so many arguments with its twin."""

    def of_one(x):
        return function(x)

    def of_two(x):
        return function(x, 3.0 - x)

    def of_three(x):
        return function(x, 3.0 - x, x)

    text = kernel((of_one, of_two, of_three)[count - 1])

    def over(table, out):
        for i in range(0, table.size, LANES):
            store_lanes(out, i, text(load_lanes(table, i)))

    table = numbers()
    expected = text(table.array)
    out = View(np.zeros(table.size, expected.dtype))
    instantiate(kernel(over))(table, out)
    said = f"{function.__name__} differs from its twin"
    np.testing.assert_allclose(out.array, expected, rtol=1e-6, err_msg=said)
