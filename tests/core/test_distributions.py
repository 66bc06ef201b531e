"""Discrete and piecewise constant distributions against their weights."""

import numpy as np
import pytest

from alight.core.distributions import (
    cumulative,
    cumulative_2d,
    pdf_2d,
    pmf_discrete,
    sample_1d,
    sample_2d,
    sample_discrete,
)
from alight.core.jit import instantiate, kernel
from alight.core.simd import LANES, load_lanes, store_lanes, to_float
from alight.core.view import View
from tests.sampling.statistics import SIGNIFICANCE, chi_square

N = 4096
U = ((np.arange(N) + 0.5) / N).astype(np.float32)
WEIGHTS = [
    [1.0],
    [0.0, 2.0, 0.0, 0.0, 5.0, 1.0, 0.0],
    [3.0, 0.0],
    list(range(1, 18)),
]


def test_cumulative_ends_at_one_and_never_falls():
    for weights in (*WEIGHTS, np.random.default_rng(1).random(100_000)):
        cdf = cumulative(weights)
        assert cdf[0] == 0.0 and cdf[-1] == 1.0 and np.all(np.diff(cdf) >= 0.0)
        assert np.all((np.diff(cdf) > 0.0) <= (np.asarray(weights) > 0.0))


def test_cumulative_of_zeros_gives_everything_to_the_last():
    np.testing.assert_array_equal(cumulative([0.0, 0.0, 0.0]), [0, 0, 0, 1])


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize("offset", [0, 3])
def test_stratified_numbers_choose_each_entry_by_its_share(weights, offset):
    n = len(weights)
    view = View(np.concatenate([np.full(offset, 9.0), cumulative(weights)]).astype(np.float32))
    index, pmf, rest = np.broadcast_arrays(*sample_discrete(view, offset, n, U))
    share = np.array(weights) / np.sum(weights)
    assert np.all(np.abs(np.bincount(index, minlength=n) - N * share) <= 1.0)
    np.testing.assert_allclose(pmf, share[index], rtol=1e-6)
    np.testing.assert_array_equal(pmf, pmf_discrete(view, offset, index))
    # What is left of each number is stratified again.
    for i in np.unique(index):
        mine = np.sort(rest[index == i])
        even = (np.arange(len(mine)) + 0.5) / len(mine)
        assert np.all(np.abs(mine - even) <= 1.5 / len(mine) + 1e-3)
    assert np.all((rest >= 0.0) & (rest < 1.0))


def test_ends_of_the_interval():
    view = View(cumulative([0.0, 1.0, 1.0, 0.0]))
    below = np.nextafter(np.float32(0.5), np.float32(0))
    ends = np.array([0.0, below, 0.5, 1 - 2.0**-24], np.float32)
    index, _, _ = sample_discrete(view, 0, 4, ends)
    np.testing.assert_array_equal(index, [1, 1, 2, 2])


def test_piecewise_constant_1d():
    view = View(cumulative([1.0, 3.0, 0.0, 4.0]))
    x, pdf, index = sample_1d(view, 0, 4, U)
    np.testing.assert_allclose(pdf, np.array([0.5, 1.5, 0.0, 2.0])[index], rtol=1e-6)
    np.testing.assert_array_equal(np.floor(4 * x), index)
    # The inverse of the distribution function, exactly.
    expected = np.interp(U, [0, 0.125, 0.5, 0.5, 1.0], [0, 0.25, 0.5, 0.75, 1.0])
    np.testing.assert_allclose(x, expected, atol=1e-6)


def test_piecewise_constant_2d():
    rng = np.random.default_rng(2)
    weights = rng.random((5, 7)) * (rng.random((5, 7)) > 0.2)
    view = View(cumulative_2d(weights))
    u = rng.random((2, 100_000), np.float32)
    x, y, pdf = sample_2d(view, 5, 7, (u[0], u[1]))
    cells = np.minimum((y * 5).astype(int), 4) * 7 + np.minimum((x * 7).astype(int), 6)
    share = weights.ravel() / weights.sum()
    counts = np.bincount(cells, minlength=35)
    assert chi_square(np.append(counts, 0), share) > SIGNIFICANCE
    np.testing.assert_allclose(pdf, 35.0 * share[cells], rtol=1e-4)
    inside = (np.abs(x * 7 - np.rint(x * 7)) > 1e-4) & (np.abs(y * 5 - np.rint(y * 5)) > 1e-4)
    np.testing.assert_allclose(pdf_2d(view, 5, 7, x, y)[inside], pdf[inside], rtol=1e-6)
    # Within a cell all places are alike.
    inner = np.histogram2d(x * 7 % 1.0, y * 5 % 1.0, bins=6, range=[[0, 1], [0, 1]])[0].ravel()
    assert chi_square(np.append(inner, 0), np.full(36, 1 / 36)) > SIGNIFICANCE


@kernel
def _root(cdf, u, out, n, count):
    i = 0
    while i < count:
        index, pmf, rest = sample_discrete(cdf, 0, n, load_lanes(u, i))
        x, y, pdf = sample_2d(cdf, 1, n, (load_lanes(u, i), rest))
        store_lanes(out, i, to_float(index))
        store_lanes(out, count + i, pmf)
        store_lanes(out, 2 * count + i, rest)
        store_lanes(out, 3 * count + i, x)
        store_lanes(out, 4 * count + i, y * pdf)
        i += LANES


def test_compiled_distributions_are_those_of_numpy():
    cdf, results = View(cumulative_2d([WEIGHTS[1]])), []
    for compiled in (True, False):
        out = View(np.zeros(5 * N, np.float32))
        instantiate(_root, compiled=compiled)(cdf, View(U), out, len(WEIGHTS[1]), N)
        results.append(out.array.reshape(5, N))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_allclose(results[0], results[1], rtol=1e-5, atol=1e-5)
