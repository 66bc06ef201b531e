"""Laws of adaptive shares: Neyman's formula without chance, calibration with it, whole counts."""

import math

import numpy as np
import pytest

from alight.films.sample_ranges import cells_of, empty_cells
from alight.rendering.schedules.adaptive import (
    LEAST,
    MOST,
    PILOT_SPP,
    _correlation,
    counts_at,
    over_cells,
    shares_of,
)
from alight.rendering.schedules.cycles import Cycles, cycles_error, first_decision

#: Four replicates whose two halves have the same spread.
SIGNS = np.array([1.0, 1.0, -1.0, -1.0])


class Pilot:
    """What shares are made of: a window (x, y, w, h) of a picture, and its replicates."""

    def __init__(self, means, corner=(0, 0), size=None):
        h, w, self.replicates = means.shape[:3]
        self.crop = (*corner, w, h)
        self.cells = empty_cells(*(size or (corner[0] + w, corner[1] + h)))
        self.means, self.counts = means, np.full(means.shape[:3], 2)

    def replicate_means(self):
        return self.means, self.counts


def stepping(mean, step):
    """Replicates that differ from the mean by exactly `step`."""
    return (mean[..., None] + step[..., None] * SIGNS)[..., None] * np.ones(3)


def of_cells(cells):
    """Each value for 8x8 pixels."""
    return np.kron(cells, np.ones((8, 8)))


def with_neighbours(cells):
    """Mean of 3x3 cells, the border repeated."""
    wide = np.pad(cells, 1, mode="edge")
    h, w = cells.shape
    return sum(wide[i : i + h, j : j + w] for i in range(3) for j in range(3)) / 9.0


def neyman(mean, step):
    """Shares of cells of even brightness: the root of the variance, a fifth of it from around."""
    variance = step**2 / (mean**2 + (0.1 * mean.mean()) ** 2)
    shares = np.sqrt(0.8 * variance + 0.2 * with_neighbours(variance))
    return shares / shares.mean()


@pytest.mark.parametrize("dark", [1.0, 0.1, 0.01, 0.0])
def test_shares_are_the_root_of_the_relative_variance_and_epsilon_holds_the_dark_back(dark):
    """A dark half, 2.5 times as noisy over its brightness and a tenth of the picture's mean.

    Without the latter it would get nearly all samples.
    """
    rng = np.random.default_rng(1)
    step = 0.05 * (1.0 + rng.random((12, 20)))
    mean = np.ones((12, 20))
    mean[:, :10] = dark
    step[:, :10] *= 2.5 * math.hypot(dark, 0.1 * mean.mean())
    found = shares_of(Pilot(stepping(of_cells(mean), of_cells(step))))
    expected = neyman(mean, step)
    # Where brightness jumps, pixels of the first cells see their neighbours' through the filter.
    clear = np.abs(np.arange(20) - 9.5) > 1.6
    ratio = (found / expected)[:, clear]
    assert ratio == pytest.approx(np.full(ratio.shape, np.median(ratio)), rel=2e-3)
    assert found.mean() == pytest.approx(1.0, rel=1e-6)


def test_shares_have_no_unit_no_channel_and_no_orientation():
    rng = np.random.default_rng(2)
    mean, step = 0.2 + rng.random((40, 64)), of_cells(0.02 + 0.2 * rng.random((5, 8)))
    means = stepping(mean, step) * np.array([1.0, 0.7, 0.4])
    one = shares_of(Pilot(means))
    assert one.std() > 0.2
    assert shares_of(Pilot(16.0 * means)) == pytest.approx(one, rel=1e-4)
    assert shares_of(Pilot(means[..., [2, 0, 1]])) == pytest.approx(one, rel=1e-4)
    assert shares_of(Pilot(means[:, :, ::-1])) == pytest.approx(one, rel=1e-4)
    turned = shares_of(Pilot(means.transpose(1, 0, 2, 3)))
    np.testing.assert_allclose(turned.T, one, rtol=1e-4)
    assert shares_of(Pilot(means[::-1])) == pytest.approx(one[::-1], rel=1e-4)


@pytest.mark.parametrize("corner", [(0, 0), (13, 6), (8, 16)])
def test_a_window_has_its_shares_in_its_own_cells(corner):
    """Cells that the window cuts count by their pixels, and cells outside get nothing."""
    rng = np.random.default_rng(3)
    x, y = corner
    step = of_cells(0.05 + 0.1 * rng.random((7, 9)) ** 2)
    whole = stepping(np.ones(step.shape), step)
    pilot = Pilot(whole[y : y + 35, x : x + 42], corner, (72, 56))
    found, inside = shares_of(pilot), cells_of(*pilot.crop)
    pixels = over_cells(pilot, np.ones((35, 42)), np.add)
    assert pixels.sum() == 35 * 42
    assert (found[inside] * pixels).sum() / pixels.sum() == pytest.approx(1.0, rel=1e-6)
    outside = np.ones(found.shape, bool)
    outside[inside] = False
    assert (found[outside] == 0.0).all()
    # Of even brightness, so that only the noise of its cells counts.
    own = step[::8, ::8][inside]
    expected = np.sqrt(0.8 * own**2 + 0.2 * with_neighbours(own**2))
    ratio = found[inside] / expected
    assert ratio == pytest.approx(np.full(ratio.shape, ratio.mean()), rel=2e-3)


def test_pixels_of_a_cell_are_those_at_its_place():
    plane = np.random.default_rng(4).random((20, 30))
    pilot = Pilot(plane[:, :, None, None] * np.ones((1, 1, 4, 3)), (5, 11))
    found = over_cells(pilot, plane, np.maximum)
    at = [[((11 + y) // 8, (5 + x) // 8) for x in range(30)] for y in range(20)]
    for (i, j), value in np.ndenumerate(found):
        own = [plane[y, x] for y in range(20) for x in range(30) if at[y][x] == (1 + i, j)]
        assert value == max(own)


def uneven(rng, spread):
    """True deviations of 4x4 cells at a time, and a pilot whose cells see a few bright samples."""
    true = np.exp(spread * rng.standard_normal((10, 10)))
    true = np.kron(true / true.mean(), np.ones((4, 4)))
    events = rng.poisson(0.02, (320, 320, 4, 1)) - 0.02
    return true, 1.0 + 0.1 * of_cells(true)[..., None, None] * events * np.ones(3)


def test_shares_are_no_surer_than_the_pilot():
    """Where the pilot says so much more, it is so much more: the slope of truth over share is 1."""
    rng, slopes = np.random.default_rng(5), []
    for _ in range(4):
        true, means = uneven(rng, 0.35)
        found = shares_of(Pilot(means)) - 1.0
        slopes.append(float((found * (true - 1.0)).sum() / (found**2).sum()))
    # Of shares as the pilot has them it is 0.83, of ones cut by the halves' agreement itself 1.2.
    assert np.mean(slopes) == pytest.approx(1.0, abs=0.08)


def test_halves_agree_as_their_pixels_do():
    """A cell counts by its pixels, as if it stood there so many times; -1 is no agreement."""
    rng = np.random.default_rng(8)
    a, pixels = rng.random((4, 5)), rng.integers(1, 64, (4, 5))
    for b in (a + 0.3 * rng.random((4, 5)), 3.0 + a, 2.0 - a, rng.random((4, 5))):
        each = [np.repeat(plane.ravel(), pixels.ravel()) for plane in (a, b)]
        expected = max(np.corrcoef(each)[0, 1], 0.0)
        assert _correlation(a, b, pixels) == pytest.approx(expected, abs=1e-12)
        assert _correlation(7.0 * b, a, pixels) == pytest.approx(expected, abs=1e-12)
    assert _correlation(a, np.ones((4, 5)), pixels) == 0.0


def test_a_pilot_that_says_nothing_leaves_all_even():
    chance = 1.0 + 0.2 * (np.random.default_rng(6).random((64, 64, 4, 1)) < 0.01) * np.ones(3)
    for means in (np.zeros((16, 24, 4, 3)), np.ones((16, 24, 4, 3)), chance):
        assert (shares_of(Pilot(means)) == 1.0).all()


@pytest.mark.parametrize("replicates", [2, 3])
def test_few_replicates_have_no_halves_that_could_agree(replicates):
    step = of_cells(np.array([[0.1, 0.1, 0.1, 0.5, 0.5, 0.5]] * 4))
    signs = np.array([1.0, -1.0, 0.0])[:replicates]
    means = (1.0 + step[..., None] * signs)[..., None] * np.ones(3)
    found = shares_of(Pilot(means))
    assert found[1, 5] / found[1, 0] == pytest.approx(5.0, rel=1e-3)


@pytest.mark.parametrize(("factor", "even"), [(1.5, True), (1.65, False)])
def test_gains_below_five_percent_are_left_alone(factor, even):
    """Half of the cells with so many times the noise of the others gain 4.0 and 6.0 %."""
    cells = np.ones((24, 24))
    cells[:, 12:] = factor
    gain = np.mean(cells**2) / np.mean(cells) ** 2
    assert (gain < 1.05) == even
    found = shares_of(Pilot(stepping(np.ones((192, 192)), 0.1 * of_cells(cells))))
    assert (found == 1.0).all() == even


def test_no_cell_gets_less_or_more_than_the_bounds():
    cells = np.full((20, 20), 1e-3)
    cells[10, 10] = 10.0
    found = shares_of(Pilot(stepping(np.ones((160, 160)), 0.1 * of_cells(cells))))
    assert (LEAST, MOST, PILOT_SPP) == (0.2, 8.0, 8)
    assert found.max() == pytest.approx(8.0, rel=0.01)
    cells[10, 10] = 1e-3
    cells[:, 10:] = 1.0
    found = shares_of(Pilot(stepping(np.ones((160, 160)), 0.1 * of_cells(cells))))
    assert found.min() == pytest.approx(0.2, rel=0.01)
    assert found.mean() == pytest.approx(1.0, rel=1e-3)


# ---------------------------------------------------------------------------- counts


@pytest.mark.parametrize("replicates", [1, 4, 6])
def test_counts_are_the_even_numbers_of_points_that_are_nearest(replicates):
    shares = np.concatenate([[0.0], np.linspace(0.2, 8.0, 400)])[None]
    good = np.array(sorted({1, 2, 3} | {m * 2**k for k in range(13) for m in (4, 5, 6, 7)}))
    for spp in (8, 32, 100, 256, 1000):
        found = counts_at(shares, spp, replicates)
        assert found.dtype == np.int64
        assert (found % replicates == 0).all()
        assert found[0, 0] == 0
        rounds, wanted = found[0, 1:] // replicates, shares[0, 1:] * spp / replicates
        assert np.isin(rounds, good).all()
        # To whole rounds first; of two that are as near it may be either.
        whole = np.maximum(np.rint(wanted), 1.0)
        nearest = np.abs(good[:, None] - whole).min(axis=0)
        assert (np.abs(rounds - whole) == nearest).all()


def test_even_shares_get_what_was_asked_for():
    for spp in (16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128, 160, 192, 224, 256):
        assert (counts_at(np.ones((3, 4)), spp, 4) == spp).all()
    rng = np.random.default_rng(7)
    shares = rng.gamma(4.0, 0.25, (50, 50))
    for spp in (64, 100, 777):
        mean = counts_at(shares, spp, 4).mean()
        assert mean == pytest.approx(shares.mean() * spp, rel=0.04)
        assert math.isfinite(mean)


def noisy(brightness, step):
    """Every second replicate is brighter by `step`, the others are darker."""
    return (brightness[..., None] + step[..., None] * [1.0, -1.0, 1.0, -1.0])[..., None] * np.ones(
        3
    )


@pytest.mark.parametrize("brightness", [0.0, 0.05, 0.3, 0.4, 5.0])
def test_the_error_of_cycles_is_over_the_root_of_what_is_dark_and_over_what_is_bright(brightness):
    means = noisy(np.full((2, 3), brightness), np.full((2, 3), 0.01))
    # Of three channels together, as its brightness is.
    whole = 3.0 * brightness
    scale = 1e-4 + (whole if whole >= 1.0 else math.sqrt(whole))
    found = cycles_error(means, np.full(means.shape[:3], 2))
    np.testing.assert_allclose(found, 0.03 / scale, rtol=1e-6)


@pytest.mark.parametrize("corner", [(0, 0), (16, 0), (0, 24), (40, 8)])
def test_cycles_goes_on_with_the_noisy_cells_of_a_window(corner):
    """And says what share of the window, not of the picture around it, has ended."""
    step = np.zeros((24, 40))
    step[4, 12], step[20, 36] = 0.5, 0.5
    pilot = Pilot(noisy(np.ones(step.shape), step), corner, (96, 64))
    begin = first_decision(0.01)
    rule = Cycles(0, begin + 16, 0.01)
    first = rule.next([pilot]).count
    more = rule.next([pilot]).count - first
    wanted = np.zeros((3, 5))
    wanted[0, 1], wanted[2, 4] = 16, 16
    inside = cells_of(*pilot.crop)
    np.testing.assert_array_equal(more[inside], wanted)
    assert more.sum() == wanted.sum()
    assert first.sum() == (first == begin).sum() * begin == 15 * begin
    assert rule.next([pilot]).line.endswith("stopped 86.7 % of the cells early")
