r"""Discrete and bilinear distributions: tables on the host, sampling in lanes.

A table is a cumulative distribution c of n + 1 numbers, c_0 = 0 and c_n = 1, in float32; entry i
has probability c_{i+1} - c_i *exactly as stored*, so sampling and density always agree. The largest
i with c_i <= u is found by bisection: well-stratified u give well-stratified choices, and
(u - c_i) / (c_{i+1} - c_i) is again uniform and stratified.

A u has 24 bits, so all numbers of a table are multiples of 2^-24: between others more or fewer u
would lie than the table says. Every weight above 0 gets at least one of these units: whatever can
be drawn is drawn, however large its neighbours are.

Source: PBR4 sections 2.3, A.4 and A.5 (in the online edition "Sampling 1D functions" and what
follows).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.core.constants import ONE_MINUS_EPSILON
from lanewise.jit import kernel
from lanewise.simd import (
    any_lane,
    as_float,
    as_int,
    floor,
    gather,
    gather_row,
    lanes_u32,
    maximum,
    minimum,
    sqrt,
    to_uint,
    where,
)

#: Resolution of the random numbers that choose.
UNIT = 2.0**-24

#: Of more entries not each gets a unit: most of them would have no other.
MOST_WITH_UNITS = 1 << 23


def cumulative(weights: ArrayLike) -> NDArray[np.float32]:
    """The cumulative distribution of weights.

    Parameters
    ----------
    weights : (n,) float
        Not negative; n >= 1. If all are zero the last entry gets everything.

    Returns
    -------
    (n + 1,) float32
        From 0 to exactly 1, non-decreasing multiples of 2^-24. Entries of weight 0 have
        probability 0, others at least 2^-24; only of more than 2^23 entries some may get nothing.
    """
    return _cumulative_units(np.asarray(weights, np.float64)).astype(np.float32)


def cumulative_2d(weights: ArrayLike) -> NDArray[np.float32]:
    """Tables for `sample_cell`: a conditional distribution a row, then the marginal one.

    Guides follow, which leave few steps to bisection: their sizes for a row and for the marginal
    distribution, then the numbers of `guide` for each row and for the marginal distribution.

    Parameters
    ----------
    weights : (rows, columns) float
        Not negative; at most 2^23 of either.

    Returns
    -------
    (m,) float32
        The first rows (columns + 1) + rows + 1 are as of `cumulative`.
    """
    weights = np.asarray(weights, np.float64)
    conditional, marginal = _cumulative_units(weights), _cumulative_units(weights.sum(axis=1))
    rows, columns = (guide_size(n) for n in weights.shape)
    guides = [guide(row, columns) for row in conditional]
    tables = [conditional.ravel(), marginal, (columns, rows), *guides, guide(marginal, rows)]
    return np.concatenate(tables).astype(np.float32)


def guide_size(n: int) -> int:
    """How many equal parts of [0, 1] the guide of n entries knows: a power of two, about n / 4."""
    return 2 ** max(round(np.log2(n)) - 2, 0)


def guide(table: NDArray[np.float64], size: int) -> NDArray[np.intp]:
    """The entry that holds k / size, for k = 0 ... size: where bisection may begin and end.

    Source: Chen and Asau 1974, On generating random variates from an empirical distribution, AIIE
    Transactions 6(2). As `size` is a power of two, nothing is rounded.
    """
    entries = np.searchsorted(table, np.arange(size + 1) / size, side="right") - 1
    return np.minimum(entries, len(table) - 2)


def _cumulative_units(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cumulative distributions along the last axis, in steps of `UNIT`."""
    sums = np.cumsum(weights, axis=-1)
    total = sums[..., -1:]
    # One unit for each weight above 0, the others by share.
    least = np.cumsum((weights > 0.0) & (weights.shape[-1] <= MOST_WITH_UNITS), axis=-1)
    shared = np.rint(sums / np.where(total > 0.0, total, 1.0) * (1.0 / UNIT - least[..., -1:]))
    table = np.asarray((least + shared) * UNIT, np.float64)
    table[..., -1] = 1.0
    return np.concatenate([np.zeros_like(total), table], axis=-1)


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
    return bisect(cdf, offset, lanes_u32(0), lanes_u32(n), u)


@kernel
def bisect(cdf, offset, low, high, u):
    """`sample_discrete` where the entry is known to lie in [low, high)."""
    # Halve [low, high) until one entry is left; it keeps cdf[low] <= u.
    while any_lane(low + 1 < high):
        middle = (low + high) >> 1
        below = gather(cdf, middle + offset) <= u
        low, high = where(below, middle, low), where(below, high, middle)
    start, end = gather_row(cdf, low + offset, 2)
    pmf = end - start
    rest = where(pmf > 0.0, (u - start) / where(pmf > 0.0, pmf, 1.0), 0.0)
    return low, pmf, minimum(rest, ONE_MINUS_EPSILON)


@kernel
def sample_guided(cdf, offset, at, size, u):
    """`sample_discrete` with the guide that starts at number `at` of the table (lanes)."""
    part = to_uint(u * as_float(size))
    first, last = gather_row(cdf, at + part, 2)
    return bisect(cdf, offset, to_uint(first), to_uint(last) + 1, u)


@kernel
def pmf_discrete(cdf, offset, index):
    """Probability of an entry, as `sample_discrete` returns it."""
    start, end = gather_row(cdf, offset + index, 2)
    return end - start


@kernel
def sample_cell(cdf, offset, rows, columns, u, u2):
    """Choose one of rows x columns cells.

    Parameters
    ----------
    cdf : View
        Holds the tables of `cumulative_2d` from `offset` on.
    offset, rows, columns : int
        Uniform.
    u : float
        Uniform in [0, 1): the digits that the 24 bits of u2 lack where a cell is improbable.
    u2 : tuple of 2 floats
        Uniform in [0, 1).

    Returns
    -------
    column, row : uint32
    pmf : float
        Probability of the cell.
    rest : tuple of 2 floats
        Again uniform in [0, 1), for the place inside the cell.
    """
    marginal = offset + rows * (columns + 1)
    sizes = marginal + rows + 1
    of_columns, of_rows = as_int(cdf[sizes]), as_int(cdf[sizes + 1])
    guides = sizes + 2
    row, pmf_row, rest_y = sample_guided(
        cdf, marginal, guides + rows * (of_columns + 1), of_rows, u2[1]
    )
    column, pmf_column, rest_x = sample_guided(
        cdf, offset + row * (columns + 1), guides + row * (of_columns + 1), of_columns, u2[0]
    )
    rest = _spread(u, (rest_x, rest_y), (pmf_column, pmf_row))
    return column, row, pmf_row * pmf_column, rest


@kernel
def pmf_cell(cdf, offset, rows, columns, column, row):
    """Probability of a cell, as `sample_cell` returns it."""
    pmf = pmf_discrete(cdf, offset + rows * (columns + 1), row)
    return pmf * pmf_discrete(cdf, offset + row * (columns + 1), column)


def cumulative_grid(weights: ArrayLike) -> NDArray[np.float32]:
    """Tables for `sample_grid`: a conditional distribution a row, then the marginal one.

    Parameters
    ----------
    weights : (rows, columns) float
        Not negative; at most 2^23 of either.

    Returns
    -------
    (rows (columns + 1) + rows + 1,) float32
    """
    weights = np.asarray(weights, np.float64)
    parts = _cumulative_units(weights).ravel(), _cumulative_units(weights.sum(axis=1))
    return np.concatenate(parts).astype(np.float32)


@kernel
def sample_grid(cdf, offset, rows, columns, u, u2):
    """`sample_cell` where each lane may have a table of its own, of `cumulative_grid`.

    Parameters
    ----------
    cdf : View
    offset, rows, columns : uint32
        Lanes.
    u, u2
        As for `sample_cell`.

    Returns
    -------
    column, row, pmf, rest
        As of `sample_cell`.
    """
    row, pmf_row, rest_y = sample_discrete(cdf, offset + rows * (columns + 1), rows, u2[1])
    column, pmf_column, rest_x = sample_discrete(cdf, offset + row * (columns + 1), columns, u2[0])
    pmf, rest = pmf_row * pmf_column, (rest_x, rest_y)
    return column, row, pmf, _spread(u, rest, (pmf_column, pmf_row))


@kernel
def pmf_grid(cdf, offset, rows, columns, column, row):
    """Probability of a cell, as `sample_grid` returns it."""
    pmf = pmf_discrete(cdf, offset + rows * (columns + 1), row)
    return pmf * pmf_discrete(cdf, offset + row * (columns + 1), column)


@kernel
def _spread(u, rest, pmf):
    """Places inside a cell with the digits of u where the numbers that chose it have few left."""
    # A cell of k units of 2^-24 meets k values of them only; u is spread between.
    lower = u * 4096.0
    y = rest[1] + u * (UNIT / maximum(pmf[1], UNIT))
    x = rest[0] + (lower - floor(lower)) * (UNIT / maximum(pmf[0], UNIT))
    return minimum(x, ONE_MINUS_EPSILON), minimum(y, ONE_MINUS_EPSILON)


@kernel
def bilinear(corners, x, y):
    """The bilinear function with the values (at (0, 0), (1, 0), (0, 1), (1, 1))."""
    low = corners[0] + x * (corners[1] - corners[0])
    high = corners[2] + x * (corners[3] - corners[2])
    return low + y * (high - low)


@kernel
def sample_linear(a, b, u):
    """Draw from the density on [0, 1] that goes from a to b >= 0, up to a factor; PBR4 2.3.2."""
    root = sqrt(a * a + u * (b * b - a * a))
    return minimum(u * (a + b) / maximum(a + root, 1e-30), ONE_MINUS_EPSILON)


@kernel
def sample_bilinear(corners, u2):
    """Draw (x, y) from the density on [0, 1]^2 in proportion to `bilinear`; PBR4 A.5.1."""
    y = sample_linear(corners[0] + corners[1], corners[2] + corners[3], u2[1])
    left = corners[0] + y * (corners[2] - corners[0])
    right = corners[1] + y * (corners[3] - corners[1])
    return sample_linear(left, right, u2[0]), y
