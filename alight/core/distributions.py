r"""Discrete and piecewise constant distributions: tables on the host, sampling in lanes.

A table is a cumulative distribution c of n + 1 numbers, c_0 = 0 and c_n = 1, in float32; entry i
has probability c_{i+1} - c_i *exactly as stored*, so sampling and density always agree. The largest
i with c_i <= u is found by bisection: well-stratified u give well-stratified choices, and
(u - c_i) / (c_{i+1} - c_i) is again uniform and stratified.

A u of 24 bits cannot find entries of probability below 2^-24; there the table holds 0 or 2^-24.

Source: PBR4 sections 2.3 and A.4 (in the online edition "Sampling 1D functions").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.jit import kernel
from alight.core.simd import (
    any_lane,
    as_float,
    gather,
    lanes_u32,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)


def cumulative(weights: ArrayLike) -> NDArray[np.float32]:
    """The cumulative distribution of weights.

    Parameters
    ----------
    weights : (n,) float
        Not negative; n >= 1. If all are zero the last entry gets everything.

    Returns
    -------
    (n + 1,) float32
        From 0 to exactly 1, non-decreasing; entries of weight 0 have probability 0.
    """
    sums = np.concatenate([[0.0], np.cumsum(np.asarray(weights, np.float64))])
    if sums[-1] <= 0.0:
        return np.concatenate([np.zeros(len(sums) - 1), [1.0]]).astype(np.float32)
    return (sums / sums[-1]).astype(np.float32)


def cumulative_2d(weights: ArrayLike) -> NDArray[np.float32]:
    """Tables for `sample_2d`: a conditional distribution a row, then the marginal one.

    Parameters
    ----------
    weights : (rows, columns) float
        Not negative.
    """
    weights = np.asarray(weights, np.float64)
    rows = [cumulative(row) for row in weights]
    return np.concatenate([*rows, cumulative(weights.sum(axis=1))])


@kernel
def sample_discrete(cdf, offset, n, u):
    """Choose one of n entries.

    Parameters
    ----------
    cdf : View
        Holds the n + 1 numbers of the table from `offset` on.
    offset : uint32
        Lanes or uniform.
    n : int or uint32
        Number of entries, uniform or lanes.
    u : float
        Uniform in [0, 1).

    Returns
    -------
    index : uint32
    pmf : float
        Its probability.
    u : float
        Again uniform in [0, 1), for another use.
    """
    # Halve [low, high) until one entry is left; it keeps cdf[low] <= u.
    low, high = lanes_u32(0), lanes_u32(n)
    while any_lane(low + 1 < high):
        middle = (low + high) >> 1
        below = gather(cdf, middle + offset) <= u
        low, high = where(below, middle, low), where(below, high, middle)
    start = gather(cdf, low + offset)
    pmf = gather(cdf, low + offset + 1) - start
    rest = where(pmf > 0.0, (u - start) / where(pmf > 0.0, pmf, 1.0), 0.0)
    return low, pmf, minimum(rest, ONE_MINUS_EPSILON)


@kernel
def pmf_discrete(cdf, offset, index):
    """Probability of an entry, as `sample_discrete` returns it."""
    return gather(cdf, offset + index + 1) - gather(cdf, offset + index)


@kernel
def sample_1d(cdf, offset, n, u):
    """Draw from a density on [0, 1) that is constant on n intervals of equal length.

    Returns
    -------
    x : float
        In [0, 1).
    pdf : float
    index : uint32
        The interval.
    """
    index, pmf, rest = sample_discrete(cdf, offset, n, u)
    count = to_float(lanes_u32(n))
    x = (to_float(index) + rest) / count
    return minimum(x, ONE_MINUS_EPSILON), pmf * count, index


@kernel
def sample_2d(cdf, rows, columns, u2):
    """Draw from a density on [0, 1)^2 that is constant on rows x columns cells.

    Parameters
    ----------
    cdf : View
        Of `cumulative_2d`.
    rows, columns : int
        Uniform.
    u2 : tuple of 2 floats
        Uniform in [0, 1).

    Returns
    -------
    x, y : float
        In [0, 1); x runs along the columns.
    pdf : float
    """
    y, pdf_y, row = sample_1d(cdf, rows * (columns + 1), rows, u2[1])
    x, pdf_x, _ = sample_1d(cdf, row * (columns + 1), columns, u2[0])
    return x, y, pdf_x * pdf_y


@kernel
def pdf_2d(cdf, rows, columns, x, y):
    """The density of `sample_2d` at (x, y)."""
    row = minimum_u32(to_uint(y * as_float(rows)), rows - 1)
    column = minimum_u32(to_uint(x * as_float(columns)), columns - 1)
    pmf = pmf_discrete(cdf, rows * (columns + 1), row)
    pmf = pmf * pmf_discrete(cdf, row * (columns + 1), column)
    return pmf * as_float(rows * columns)
