r"""Sampling of separable filters f(x, y) = g(x) g(y) whose distribution has no closed inverse.

For an even g, the distance |x| that is exceeded with probability v,

.. math:: v = \int_{|x|}^r |g| \Big/ \int_0^r |g|

is tabulated at v = (k / `CELLS`)^2 and interpolated linearly in the square root of v, so that
tails get short cells, and an end where g vanishes linearly is exact. The distribution of the
samples is off by at most 2.5e-4 (the cell where g changes its sign; elsewhere below 1e-5).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lanewise.jit import kernel
from lanewise.simd import absolute, gather, minimum, sqrt, to_float, to_uint, where

CELLS = 512
# The table: |weight| of a sample, distance beyond which g < 0, then the distances.
_WEIGHT, _SIGN_CHANGE, _DISTANCES = 0, 1, 2
#: Numbers of a table.
LENGTH = CELLS + 4
# Points of the numerical integration.
_POINTS = 1 << 17


def tabulate(
    g: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    radius: float,
    sign_change: float = np.inf,
) -> NDArray[np.float64]:
    """Table of the filter g(x) g(y) for `sample_separable`.

    Parameters
    ----------
    g : callable
        Even function of the distance in pixels, >= 0 up to `sign_change` and <= 0 beyond it.
    radius : float
        g is 0 beyond, pixels.
    sign_change : float, default inf
        Pixels.
    """
    x = np.linspace(radius, 0.0, _POINTS + 1)
    exceeded = np.concatenate([[0.0], np.cumsum(np.abs(g(0.5 * (x[1:] + x[:-1]))))])
    roots = np.sqrt(exceeded / exceeded[-1])
    # Where g is 0 up to the radius, samples start where it ceases to be 0.
    first = int(np.argmax(roots > 0.0)) - 1
    at = np.arange(CELLS + 1) / CELLS
    distances = np.float64(np.float32(np.interp(at, roots[first:], x[first:])))
    # The probability of g < 0 is that of the table, so that weights average to 1.
    change = np.float32(min(sign_change, 2.0 * radius))
    negative = np.interp(-change, -distances, at) ** 2
    # u = 1/2 falls on the last distance, which is interpolated with the one after it.
    head = np.array([1.0 / (1.0 - 2.0 * negative), change])
    return np.concatenate([head, distances, np.zeros(1)])


@kernel
def sample_separable(table, u2):
    """Offsets dx, dy in pixels and the weight, from a table made by `tabulate`."""
    dx, dy = _offset(table, u2[0]), _offset(table, u2[1])
    change, weight = table[_SIGN_CHANGE], table[_WEIGHT]
    # A product of two factors of g: negative where just one of them is.
    negative = (absolute(dx) > change) ^ (absolute(dy) > change)
    return dx, dy, where(negative, -weight * weight, weight * weight)


@kernel
def _offset(table, u):
    at = sqrt(2.0 * minimum(u, 1.0 - u)) * CELLS
    cell = to_uint(at)
    before, after = gather(table, cell + _DISTANCES), gather(table, cell + (_DISTANCES + 1))
    distance = before + (at - to_float(cell)) * (after - before)
    return where(u < 0.5, -distance, distance)
