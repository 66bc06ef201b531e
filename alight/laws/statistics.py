"""Tests of hypotheses for samples, without SciPy, at one significance for a whole suite.

A suite may fail by chance with probability `FAMILY`; a single test among at most `TESTS` gets
Sidak's share of it. Seeds are fixed, so a test that passes keeps passing.
"""

from __future__ import annotations

from functools import cache
from statistics import NormalDist

import numpy as np

from alight.laws.report import demand
from alight.metrics.statistics import chi_square_tail, student_t_quantile, upper_gamma

FAMILY = 0.01
TESTS = 2000
SIGNIFICANCE = 1.0 - (1.0 - FAMILY) ** (1.0 / TESTS)
#: Rounding of one operation of float32, and of 64 in a row that all err to one side.
UNIT = 2.0**-24
ROUNDING = 64 * UNIT
#: Two-sided bound of a standard normal number.
LARGEST_Z = -NormalDist().inv_cdf(SIGNIFICANCE / 2.0)

# Cochran's rule of thumb wants 5; below it the statistic is not distributed like chi squared.
_FEWEST = 10.0


def poisson_tail(count: float, mean: float) -> float:
    """P(N >= count) of Poisson's distribution."""
    return 1.0 - upper_gamma(count, mean) if count > 0 else 1.0


def chi_square(counts, probabilities) -> float:
    """P-value of counts in cells of known probability; what is left over is one more cell.

    Parameters
    ----------
    counts : (n,) int
        The last entry counts what fell into none of the cells.
    probabilities : (n - 1,) float
        Of the cells; the last one gets the rest.
    """
    counts = np.asarray(counts, float)
    total = counts.sum()
    expected = np.append(probabilities, max(0.0, 1.0 - np.sum(probabilities))) * total
    order = np.argsort(expected)
    pooled = int(np.searchsorted(np.cumsum(expected[order]), _FEWEST)) + 1
    small, large = order[:pooled], order[pooled:]
    seen = np.append(counts[large], counts[small].sum())
    wanted = np.append(expected[large], expected[small].sum())
    if wanted[-1] < _FEWEST:
        # Not even all small cells together are expected to be hit: being hit too often is Poisson.
        return min(1.0, poisson_tail(float(seen[-1]), max(float(wanted[-1]), 1e-12)))
    statistic = float(np.sum((seen - wanted) ** 2 / wanted))
    return chi_square_tail(statistic, max(len(seen) - 1, 1))


def uniform_p_value(values, cells: int = 64) -> float:
    """P-value of numbers in [0, 1) that should be uniform."""
    counts = np.histogram(values, bins=cells, range=(0.0, 1.0))[0]
    expected = len(np.ravel(values)) / cells
    return chi_square_tail(float(((counts - expected) ** 2 / expected).sum()), cells - 1)


def z_of_mean(values, expected, known_error=0.0):
    """How many standard errors the mean of independent values is away from `expected`."""
    error = np.hypot(values.std(ddof=1) / np.sqrt(len(values)), known_error)
    return (values.mean() - expected) / max(error, 1e-12)


def demand_mean(values, expected, message, known_error=0.0):
    """Raise `BrokenLawError` unless the mean of a few replicates is `expected`, by Student's t.

    known_error: what arithmetic may add.
    """
    values = np.asarray(values, float)
    t = student_t_quantile(1.0 - 0.5 * SIGNIFICANCE, len(values) - 1)
    bound = t * values.std(ddof=1) / np.sqrt(len(values)) + known_error
    found = values.mean()
    demand(abs(found - expected) <= bound, f"{message}: {found:.7g} against {expected:.7g}")


class SphereCells:
    """The sphere cut along meridians and parallels, each cell with a grid of points.

    Attributes
    ----------
    points : (3, n) float32
        Unit vectors; the first `side`^2 of them lie in cell 0, and so on.
    """

    def __init__(self, rows=12, columns=12, side=32):
        self.rows, self.columns, self.side = rows, columns, side
        i, j, a, b = np.mgrid[:rows, :columns, :side, :side]
        # Equal steps of the angle, not of its cosine: narrow lobes at the pole are resolved too.
        # Midpoints: for smooth lobes the error of their sum falls faster than any power.
        theta = np.pi * (i + (a + 0.5) / side) / rows
        phi = 2.0 * np.pi * (j + (b + 0.5) / side) / columns
        r = np.sin(theta)
        points = np.stack([r * np.cos(phi), r * np.sin(phi), np.cos(theta)])
        self.points = points.reshape(3, -1).astype(np.float32)
        self._area = (2.0 * np.pi**2 / (rows * columns) * r).reshape(-1, side * side)

    def integrals(self, density):
        """Integral over each cell of values given at `points`."""
        return (np.asarray(density, float).reshape(-1, self.side**2) * self._area).mean(1)

    def counts(self, directions, valid):
        """How many of the valid directions (3, n) lie in each cell, and how many are not valid."""
        x, y, z = np.asarray(directions, float)[:, valid]
        row = (np.arctan2(np.hypot(x, y), z) / np.pi * self.rows).astype(int)
        column = (np.arctan2(y, x) / (2.0 * np.pi) % 1.0 * self.columns).astype(int)
        row, column = np.minimum(row, self.rows - 1), np.minimum(column, self.columns - 1)
        cells = np.bincount(row * self.columns + column, minlength=self.rows * self.columns)
        return np.append(cells, np.count_nonzero(~valid))


#: Sides of grids of a cell, ever finer, on which densities are judged until one resolves them.
SIDES = (32, 64, 128)


@cache
def sphere_cells(side):
    """`SphereCells` of a side, made once: the finest have two million points."""
    return SphereCells(side=side)


def unit_vectors(n, seed):
    """(3, n) float32 unit vectors, uniform on the sphere."""
    v = np.random.default_rng(seed).normal(size=(3, n))
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


def turns(n, seed):
    """(n, 3, 3) orthogonal matrices, uniformly distributed."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(n, 3, 3)))
    return q * np.sign(np.diagonal(r, axis1=1, axis2=2))[:, None, :]


def length_error(v):
    """Largest deviation of the length of float32 vectors (3, n) from 1."""
    return np.max(np.abs(np.linalg.norm(np.asarray(v, float), axis=0) - 1.0))
