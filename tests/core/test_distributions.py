"""Distributions from tables and between four corners, against their weights."""

import numpy as np
import pytest

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.distributions import (
    MOST_WITH_UNITS,
    UNIT,
    bilinear,
    cumulative,
    cumulative_2d,
    cumulative_grid,
    guide_size,
    pmf_cell,
    pmf_discrete,
    pmf_grid,
    sample_bilinear,
    sample_cell,
    sample_discrete,
    sample_grid,
    sample_guided,
)
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, load_lanes, store_lanes, to_float
from lanewise.view import View
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
    # Up to the units of the table, one for each end of an entry.
    np.testing.assert_allclose(pmf, share[index], rtol=0.0, atol=1.5 * UNIT)
    np.testing.assert_array_equal(pmf, pmf_discrete(view, offset, index))
    # What is left of each number is stratified again.
    for i in np.unique(index):
        mine = np.sort(rest[index == i])
        even = (np.arange(len(mine)) + 0.5) / len(mine)
        assert np.all(np.abs(mine - even) <= 1.5 / len(mine) + 1e-3)
    assert np.all((rest >= 0.0) & (rest < 1.0))


@pytest.mark.parametrize("weights", [[1e-10, 1.0], [1.0, 1e-10], [1.7e-7, 0.0, 1.0, 4e-8, 2.0]])
def test_numbers_of_24_bits_choose_each_entry_as_often_as_it_says(weights):
    n, cdf = len(weights), cumulative(weights)
    # All of them near the ends of entries.
    near = np.rint(cdf[:, None] / UNIT) + np.arange(-64, 64)
    u = np.unique(near[(near >= 0) & (near < 2**24)]) * UNIT
    index, pmf, _ = np.broadcast_arrays(*sample_discrete(View(cdf), 0, n, np.float32(u)))
    for i in np.flatnonzero(np.array(weights) < 0.1):
        assert np.count_nonzero(index == i) * UNIT == cdf[i + 1] - cdf[i]
    assert set(index) == set(np.flatnonzero(weights)) and np.all(pmf > 0.0)


def test_of_very_many_entries_each_need_not_have_a_unit():
    cdf = cumulative(np.ones(MOST_WITH_UNITS + 1))
    assert cdf[-1] == 1.0 and np.all(np.diff(cdf) <= 3.0 * UNIT)


def test_ends_of_the_interval():
    view = View(cumulative([0.0, 1.0, 1.0, 0.0]))
    below = np.nextafter(np.float32(0.5), np.float32(0))
    ends = np.array([0.0, below, 0.5, 1 - 2.0**-24], np.float32)
    index, _, _ = sample_discrete(view, 0, 4, ends)
    np.testing.assert_array_equal(index, [1, 1, 2, 2])


def test_cells_are_chosen_by_their_share():
    rng = np.random.default_rng(2)
    weights = rng.random((5, 7)) * (rng.random((5, 7)) > 0.2)
    view = View(np.concatenate([[9.0, 9.0], cumulative_2d(weights)]).astype(np.float32))
    u = rng.random((3, 100_000), np.float32)
    column, row, pmf, (x, y) = sample_cell(view, 2, 5, 7, u[0], (u[1], u[2]))
    share = weights.ravel() / weights.sum()
    counts = np.bincount(row * 7 + column, minlength=35)
    assert chi_square(np.append(counts, 0), share) > SIGNIFICANCE
    np.testing.assert_allclose(pmf, share[row * 7 + column], rtol=1e-5)
    np.testing.assert_array_equal(pmf_cell(view, 2, 5, 7, column, row), pmf)
    # Within a cell all places are alike.
    inner = np.histogram2d(x, y, bins=6, range=[[0, 1], [0, 1]])[0].ravel()
    assert chi_square(np.append(inner, 0), np.full(36, 1 / 36)) > SIGNIFICANCE


def test_lanes_choose_cells_of_their_own_tables():
    rng = np.random.default_rng(4)
    grids = [rng.random((3, 5)) ** 4, np.array([[0.0, 1.0], [3.0, 0.0]]), np.ones((1, 1))]
    tables = [cumulative_grid(grid) for grid in grids]
    starts = np.cumsum([2, *(table.size for table in tables)])
    view = View(np.concatenate([np.zeros(2), *tables]).astype(np.float32))
    which = rng.integers(0, 3, 60_000)
    u, x, y = rng.random((3, which.size), np.float32)
    at = starts[which].astype(np.uint32)
    rows, columns = (np.array([g.shape[i] for g in grids], np.uint32)[which] for i in (0, 1))
    column, row, pmf, rest = sample_grid(view, at, rows, columns, u, (x, y))
    np.testing.assert_array_equal(pmf, pmf_grid(view, at, rows, columns, column, row))
    for number, grid in enumerate(grids):
        mine, share = which == number, grid / grid.sum()
        cells = row[mine] * grid.shape[1] + column[mine]
        np.testing.assert_allclose(pmf[mine], share.ravel()[cells], rtol=1e-5, atol=3.0 * UNIT)
        drawn = np.bincount(cells, minlength=grid.size)[share.ravel() > 0.0]
        assert chi_square([*drawn, 0], share[share > 0.0]) > SIGNIFICANCE
    for along in rest:
        counts, _ = np.histogram(along, 20, (0.0, 1.0))
        assert chi_square([*counts, 0], np.full(20, 0.05)) > SIGNIFICANCE


def test_improbable_cells_keep_their_units_and_all_of_their_places():
    # One cell of 10^9 and 1023 of 1: by share alone these had less than a unit of 2^-24.
    weights = np.ones((2, 512))
    weights[1, 100] = 1e9
    table = cumulative_2d(weights)
    parts = np.diff(table[:1026].reshape(2, 513)), np.diff(table[1026:1029])
    assert all(np.all(part >= UNIT) and np.all(part / UNIT % 1.0 == 0.0) for part in parts)
    assert table[1028] == 1.0 and np.all(table[:1026].reshape(2, 513)[:, -1] == 1.0)
    zero = weights * (weights > 1.0)
    assert np.count_nonzero(np.diff(cumulative_2d(zero)[513:1026])) == 1
    # Numbers that meet such a cell hit one of its corners; the third number moves them apart.
    view, n = View(table), 4096
    start, row = table[513 + 7], table[1026 + 1]
    u = np.random.default_rng(5).random(n, np.float32)
    column, _, _, (x, _) = sample_cell(view, 0, 2, 512, u, (start + 0 * u, row + 0 * u))
    assert np.all(column == 7)
    steps = round((table[513 + 8] - start) / UNIT)
    assert 0.99 / steps < np.ptp(x) <= 1.0 / steps


@pytest.mark.parametrize("n", [1, 2, 3, 5, 64, 700])
def test_guides_lead_to_the_entry_that_bisection_finds(n):
    # Every fourth entry has nearly everything; where entries begin, parts of the guide begin too.
    rng = np.random.default_rng(n)
    weights = np.where(np.arange(n) % 4 == 0, 1e4, rng.random(n) < 0.7)
    table, size = cumulative_2d(weights[None]), guide_size(n)
    guide_at = n + 1 + 2 + 2
    parts = np.float32(np.arange(size) / size)
    u = np.concatenate([rng.random(4096), table[:n], parts, np.nextafter(parts, -parts)])
    u = np.clip(u.astype(np.float32), 0.0, ONE_MINUS_EPSILON)
    guided = sample_guided(View(table), 0, guide_at, size, u)
    for a, b in zip(guided, sample_discrete(View(table), 0, n, u), strict=True):
        np.testing.assert_array_equal(a, b)


CORNERS = [(1.0, 3.0, 0.5, 2.0), (0.0, 0.0, 0.0, 7.0), (2.0, 2.0, 2.0, 2.0), (1e-3, 0.0, 0.0, 0.0)]


@pytest.mark.parametrize("corners", CORNERS)
def test_places_follow_the_bilinear_density(corners):
    u = np.random.default_rng(3).random((2, 100_000), np.float32)
    x, y = sample_bilinear(np.float32(corners), (u[0], u[1]))
    assert np.all((x >= 0.0) & (x < 1.0) & (y >= 0.0) & (y < 1.0))
    cells = (8 * y).astype(int) * 8 + (8 * x).astype(int)
    # The mean of a bilinear function over a cell is its value in the middle.
    middle = (np.arange(8) + 0.5) / 8
    share = bilinear(corners, *np.meshgrid(middle, middle)).ravel() / 16.0 / np.sum(corners)
    counts = np.bincount(cells, minlength=64)
    assert chi_square(np.append(counts, 0), share) > SIGNIFICANCE


@kernel
def _root(cdf, u, out, n, count):
    i = 0
    while i < count:
        index, pmf, rest = sample_discrete(cdf, 0, n, load_lanes(u, i))
        column, _, cell, place = sample_cell(cdf, 0, 1, n, rest, (load_lanes(u, i), rest))
        x, y = sample_bilinear((pmf, 1.0 - pmf, cell, rest), place)
        store_lanes(out, i, to_float(index))
        store_lanes(out, count + i, pmf)
        store_lanes(out, 2 * count + i, rest)
        store_lanes(out, 3 * count + i, x)
        store_lanes(out, 4 * count + i, y + to_float(column))
        i += LANES


def test_compiled_distributions_are_those_of_numpy():
    cdf, results = View(cumulative_2d([WEIGHTS[1]])), []
    for compiled in (True, False):
        out = View(np.zeros(5 * N, np.float32))
        instantiate(_root, compiled=compiled)(cdf, View(U), out, len(WEIGHTS[1]), N)
        results.append(out.array.reshape(5, N))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_allclose(results[0], results[1], rtol=1e-5, atol=1e-5)
