"""Vectors of a fixed width, for code that treats one ray or one primitive at a time.

The lanes of `lanewise.simd` are as many rays as the processor takes at once. Inside an
acceleration structure it is the other way round: one ray meets 16 boxes or triangles. Here the
width belongs to the data, so it is an argument, a whole number known when the kernel is compiled.
All operators and elementwise functions of `simd` work on these vectors too.
"""

from __future__ import annotations

import numpy as np


def wide(n, x):
    """The float32 number x, n times."""
    return np.full(n, x, np.float32)


def four(a, b, c, d):
    """The vector of four float32 numbers."""
    return np.array([a, b, c, d], np.float32)


def load_wide(n, table, i):
    """``table[i : i + n]`` as one vector (float32 or uint32 as the table is)."""
    values = table[i : i + n]
    return values.copy()


def store_wide(table, i, x):
    """Write the vector x to ``table[i : i + n]``."""
    table[i : i + len(x)] = x


def lane(x, i):
    """Component i of a vector, as a scalar; i may be computed."""
    return x[i]


def low_half(x):
    """The first half of a vector."""
    return x[: len(x) // 2]


def high_half(x):
    """The second half of a vector."""
    return x[len(x) // 2 :]


def join(a, b):
    """The vector (a, b) of twice the width."""
    return np.concatenate([a, b])


def shuffled(x, order):
    """``x[order[0]], x[order[1]], ...``; the order is a tuple of constants."""
    return x[list(order)]


def gather_near(table, k, index):
    """``table[k + index]`` in each lane, for a uniform k and lanes of indices 0 to 3.

    ``table[k : k + 4]`` must exist, whichever of them are asked for: the four are loaded once and
    permuted in registers.
    """
    return table.array[k + np.asarray(index).astype(np.int64)]


def prefetch(table, i):
    """Ask for the cache line of ``table[i]``; only time depends on it."""


def smaller(a, b):
    """The smaller one in every lane, of numbers that are not NaN.

    `simd.minimum` defines what happens to NaN, which here has a price: "load, minimum, store" to
    one place becomes a masked store, and a masked store delays the next load from there.
    """
    return np.fmin(a, b)


def compressed(x, mask):
    """The components where the mask holds, one after another; what follows them is undefined."""
    inside = np.broadcast_to(mask, np.shape(x))
    return np.concatenate([x[inside], x[~inside]])


def mask_of(n, bits):
    """n lanes of a mask from a whole number: lane i is bit i."""
    return (int(bits) >> np.arange(n) & 1).astype(bool)
