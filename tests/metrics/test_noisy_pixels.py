"""The error of pictures that are mostly noise: brightness from the other replicates and around."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special, stats

from alight.metrics import noisy_pixels
from alight.metrics.error_estimate import Figure
from alight.metrics.own_error import estimate_relmse
from alight.metrics.relmse import relmse
from alight.metrics.surroundings import around, by_cells, neighbours, spread_out

SIZE = 40


def smooth():
    y, x = np.mgrid[0:SIZE, 0:SIZE] / SIZE
    return 0.5 + 0.3 * np.sin(5 * x) * np.cos(4 * y)


def caustic(rng, samples):
    """Dim light everywhere, and in a corner rare bright samples that bring as much again."""
    base, bright = smooth(), np.zeros((SIZE, SIZE))
    bright[8:24, 8:24] = 1.0
    hits = rng.binomial(samples, 0.02, (4, SIZE, SIZE)) / samples / 0.02
    noise = 1.0 + 0.2 * rng.normal(size=(4, SIZE, SIZE)) / math.sqrt(samples)
    return base * (1.0 + bright), base * (noise + bright * hits)


def lamps(rng, samples):
    """Lamps that fill a part of single pixels, among dark ones."""
    where = np.random.default_rng(1)
    cover = np.where(where.random((SIZE, SIZE)) < 0.05, where.uniform(0.1, 0.9, (SIZE, SIZE)), 0.0)
    base = 0.1 * smooth()
    hits = rng.binomial(samples, cover, (4, SIZE, SIZE)) / samples
    noise = 1.0 + 0.3 * rng.normal(size=(4, SIZE, SIZE)) / math.sqrt(samples)
    return base + 20.0 * cover, base * noise + 20.0 * hits


def uneven(rng, samples):
    """Brightness that differs from pixel to pixel, with log-normal noise."""
    truth = smooth() * np.exp(0.6 * np.random.default_rng(2).normal(size=(SIZE, SIZE)))
    factors = np.exp(1.5 * rng.normal(size=(samples, 4, SIZE, SIZE)) - 1.125).mean(axis=0)
    return truth, truth * factors


def means_of(planes):
    """As a film gives them: (h, w, R, 3), the channels in step."""
    colours = np.array([1.0, 0.8, 0.5])
    return (np.moveaxis(planes, 0, 2)[..., None] * colours).astype(np.float32), colours


@pytest.mark.parametrize("scene", [caustic, lamps, uneven])
@pytest.mark.parametrize("samples", [4, 16])
def test_the_interval_holds_the_error_of_noisy_pictures(scene, samples):
    held, ratios = 0, []
    for seed in range(24):
        truth, planes = scene(np.random.default_rng(100 + seed), samples)
        means, colours = means_of(planes)
        found = estimate_relmse(means, np.full(means.shape[:3], samples), literature=False).relmse
        error = relmse(means.mean(axis=2), truth[..., None] * colours)
        held += found.low <= error <= found.high
        ratios.append(found.value / error)
    # Of 24 at 95 %, fewer than 19 have a probability of 0.1 %.
    assert held >= 19
    # Brightness by the own half alone is wrong here by factors of 2 to 1000.
    assert 0.6 < np.median(ratios) < 1.6


def test_what_is_bright_and_noisy_is_not_what_is_dark_and_noisy():
    # The lamps' pixels look to one half as the caustic's do: rare bright samples in the dark.
    figures = {}
    for scene in (caustic, lamps):
        _, planes = scene(np.random.default_rng(3), 4)
        means, _ = means_of(planes)
        figures[scene] = estimate_relmse(means, np.full(means.shape[:3], 4), literature=False)
    truth, planes = lamps(np.random.default_rng(3), 4)
    # Divided by the surroundings' brightness the lamps' error would be hundreds of times larger.
    error = ((planes.mean(axis=0) - truth) ** 2).mean() / (0.1 * smooth().mean()) ** 2
    assert figures[lamps].relmse.value < 0.1 * error


def picture_of_all_kinds(seed=4):
    _, planes = uneven(np.random.default_rng(seed), 8)
    return means_of(planes)[0]


def figure_of(means):
    return estimate_relmse(means, np.full(means.shape[:3], 8), literature=False).figure


@pytest.mark.parametrize(
    "change",
    [
        lambda m: 4.0 * m,
        lambda m: m[..., ::-1].copy(),
        lambda m: m[:, :, ::-1].copy(),
        lambda m: m[:, :, [2, 0, 3, 1]].copy(),
    ],
    ids=["brighter", "other channels", "replicates backwards", "replicates shuffled"],
)
def test_the_figure_knows_no_units_and_no_order(change):
    means = picture_of_all_kinds()
    a, b = figure_of(means), figure_of(change(means))
    assert b.value == pytest.approx(a.value, rel=1e-4)
    assert b.freedom == pytest.approx(a.freedom, rel=1e-3)
    assert b.brightness == pytest.approx(a.brightness, rel=1e-2)


def test_the_freedom_of_even_pictures_is_their_number_of_pixels():
    """Pixels alike whose channels go together: each is one term, whatever it is weighted with."""
    places = np.array([0.0, 1.0, 3.0, 7.0])
    means = np.ones((16, 24, 4, 3)) + 1e-3 * places[:, None]
    s = (places[:, None] - places) ** 2
    halves = [s[0, 1] * s[2, 3], s[0, 2] * s[1, 3], s[0, 3] * s[1, 2]]
    square = np.mean(s[np.triu_indices(4, 1)]) ** 2
    # Products of halves, and once their deviation; the square itself is 3/5 of that by all four.
    spread = np.mean(halves) + np.sqrt(8.0 / (16 * 24)) * 0.6 * square
    assert spread < 0.6 * square
    freedom = 16 * 24 * square / spread - 2.0 / 3.0
    assert figure_of(means.astype(np.float32)).freedom == pytest.approx(freedom, rel=5e-3)


def test_the_doubt_about_noisy_pixels_counts_by_their_share():
    """Where others have an error that they know, relative doubt shrinks, squared, as the share."""
    noisy = picture_of_all_kinds()
    noisy[:, 10:] = 0.5
    both = noisy.copy()
    both[:, 10:] += 0.06 * np.array([1.0, -1.0, 1.0, -1.0])[:, None]
    alone, joined = figure_of(noisy), figure_of(both)
    share = alone.value / joined.value
    assert 0.5 < share < 0.95
    assert joined.brightness == pytest.approx(alone.brightness * share**2, rel=2e-3)
    assert 1.0 - joined.lowest == pytest.approx((1.0 - alone.lowest) * share, rel=2e-3)


@pytest.mark.parametrize(("least", "most", "ground"), [(0.05, 20.0, 0.001), (0.3, 100.0, 0.1)])
def test_the_interval_holds_where_lamps_cover_any_part_of_a_pixel(least, most, ground):
    """Light comes in hits, in some pixels of dozens, in others of one in twenty pictures."""
    side, held, pictures = 48, 0, 40
    for seed in range(pictures):
        rng = np.random.default_rng((7, seed))
        hits = np.exp(rng.uniform(math.log(least), math.log(most), (side, side)))
        truth = hits + ground
        seen = rng.poisson(np.repeat(hits[:, :, None], 4, axis=2)) + ground
        scale = truth**2 + (0.1 * truth.mean()) ** 2
        own = float(((seen.mean(axis=2) - truth) ** 2 / scale).mean())
        found = figure_of(np.repeat(seen[..., None], 3, axis=3).astype(np.float32)).interval()
        held += found.low <= own <= found.high
    # 22 and 62 % with one class for all pixels that are no brighter than twice their surroundings.
    assert held >= 0.8 * pictures


@pytest.mark.parametrize("replicates", [4, 8, 16])
def test_pixels_that_one_replicate_lights_are_in_classes_of_their_own(replicates):
    """Half A has hits in one replicate, in two, or everywhere; any brightness, any surroundings."""
    rng, half = np.random.default_rng(8), replicates // 2
    around = np.exp(3.0 * rng.normal(size=500))
    classes = []
    for lit in (1, 2, half):
        values = np.where(np.arange(half) < lit, 1.0, 0.0)[:, None] * around**0.5
        values *= np.exp(4.0 * np.random.default_rng(9).normal(size=500))
        brightness, error = values.mean(axis=0) ** 2, values.var(axis=0, ddof=1) / replicates
        classes.append(noisy_pixels.class_of(brightness, around, error).astype(int))
    alone, two, even = classes
    own = noisy_pixels.CLASSES // 2
    assert (alone >= own).all() and (two < own).all() and (even < own).all()
    # Otherwise by brightness beside the surroundings', in the same order.
    assert set(alone - own) == set(two) == set(range(own))
    assert (two >= alone - own).all() and (even >= two).all()


def gathered(rho, replicates, r, floor=1e-9, seed=5, noise=0.0, ratio=2.0):
    """Sums of pixels of which B sees rho, with normal noise."""
    rng, n = np.random.default_rng(seed), len(rho)
    one, two = rho * (1.0 + noise * rng.normal(size=(2, n)))
    sums = noisy_pixels.no_sums()
    noisy_pixels.gather(
        sums, np.zeros(n, np.uint8), np.arange(n) % noisy_pixels.GROUPS, r,
        0.5 * (one + two), one * two,
        np.full(n, floor), np.full(n, ratio), 0.25 * (one - two) ** 2,
    )  # fmt: skip
    return noisy_pixels.believe(sums, 9, 2, 2, replicates)


@pytest.mark.parametrize("floor", [1e-9, 0.25])
def test_pixels_alike_weigh_what_their_brightness_says(floor):
    found = gathered(np.full(4800, 1.7), 4, np.ones(4800), floor)
    assert found.weights[0] == pytest.approx(1.0 / (1.7**2 + floor), rel=0.01)
    assert found.value == pytest.approx(4800 * found.weights[0])


def test_log_normal_pixels_weigh_the_mean_of_their_inverse_squares():
    rho = np.exp(0.4 * np.random.default_rng(6).normal(size=100_000))
    found = gathered(rho, 4, np.ones(len(rho)), 0.1, noise=0.5)
    assert found.weights[0] == pytest.approx((1.0 / (rho * rho + 0.1)).mean(), rel=0.02)


def test_the_doubt_about_classes_is_that_of_their_noise():
    # Twenty times the noise of rho, twenty times the deviation of log(weight) and more.
    r, logs = np.ones(1600), {0.05: [], 1.0: []}
    for noise, found in logs.items():
        for seed in range(60):
            found.append(gathered(np.ones(1600), 4, r, seed=seed, noise=noise))
    for noise, found in logs.items():
        truth = np.std([math.log(f.weights[0]) for f in found])
        believed = math.sqrt(np.mean([f.variance for f in found]))
        # Each of 16 groups that look the same hides a sixteenth of the doubt of 126 samples.
        floor = math.sqrt(4.0 * special.polygamma(1, 127) / 16)
        assert believed > 0.8 * truth
        assert believed < 1.6 * math.hypot(truth, floor), noise


@pytest.mark.parametrize("largest", [0.1, 0.5, 0.9])
def test_groups_of_any_size_add_up_to_the_variance(largest):
    """A mean of 40 numbers: one group has a part of them, three share the rest."""
    at = np.arange(40)
    of = np.eye(4)[np.where(at < 40 * largest, 0, 1 + at % 3)]
    x = 0.01 * np.random.default_rng(7).normal(size=(4000, 40))
    left = 1.0 - of.mean(axis=0)
    moves = (x.sum(axis=1, keepdims=True) - x @ of) / (40 * left) - x.mean(axis=1, keepdims=True)
    terms = [noisy_pixels.left_out(one[None], left[None]).sum() for one in moves]
    assert np.mean(terms) == pytest.approx(0.01**2 / 40, rel=0.1)


def test_without_a_sample_pixels_are_as_bright_as_their_surroundings():
    # One bright sample of 1000 times the surroundings in each of 9 gathered entries, none in B.
    r = np.full(9, 1000.0**2 / 8)
    found = gathered(np.zeros(9), 4, r)
    assert found.weights[0] == pytest.approx(1.0, rel=0.05)
    # And nothing speaks against their being as bright as A saw.
    assert found.lowest < 0.6 * found.value
    many = gathered(np.full(9000, 30.0), 4, np.full(9000, 1000.0**2 / 8), noise=0.1)
    assert many.weights[0] == pytest.approx(1.0 / 900.0, rel=0.1)
    assert many.lowest > 0.95 * many.value


@pytest.mark.parametrize("rho", [2.0, 3.0, 6.0])
def test_the_doubt_reaches_from_what_is_believed_to_what_a_saw(rho):
    """As far as the prior speaks, weight^share of A, and nothing at all where A saw no more."""
    low, high = (gathered(np.full(9, rho), 4, np.full(9, 2.0), ratio=x) for x in (1e4, 1e6))
    depth = [-math.log(found.lowest / found.value) for found in (low, high)]
    share = (depth[1] - depth[0]) / math.log(100.0)
    assert 0.0 < share < 1.0
    believed = math.exp(0.5 * (math.log(1e4) - depth[0] / share))
    assert believed == pytest.approx(rho * (1.0 - share) + share, rel=1e-4)
    for ratio in (1.0, 0.999 * believed**2):
        found = gathered(np.full(9, rho), 4, np.full(9, 2.0), ratio=ratio)
        assert found.lowest == found.value


@pytest.mark.parametrize("pixels", [1, 2, 5, 10])
def test_where_b_sees_nothing_the_prior_alone_speaks(pixels):
    """Of E expected samples none seen, a prior of weight 1: all have rho = 1 / (1 + E)."""
    found = gathered(np.zeros(9 * pixels), 4, np.ones(9 * pixels))
    expected = 2.0 * pixels / math.sqrt(8.0)
    assert found.weights[0] == pytest.approx((1.0 + expected) ** 2, rel=2e-3)


@pytest.mark.parametrize("mean", [0.01, 0.5, 3.0, 20.0, 49.0, 300.0])
def test_the_poisson_tail_is_scipys(mean):
    for k in (0, 1, 2, round(mean), round(mean + 2 * math.sqrt(mean)) + 1):
        expected = stats.poisson.sf(k - 1, mean)
        assert noisy_pixels.poisson_tail(k, mean) == pytest.approx(
            expected, abs=1e-12 if mean <= 50.0 else 5e-3
        )


def test_terms_are_counted_by_their_part_in_the_sum():
    assert noisy_pixels.effective(np.ones(7)) == pytest.approx(7.0)
    assert noisy_pixels.effective(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0)
    assert noisy_pixels.effective(np.array([2.0, 1.0])) == pytest.approx(9 / 5)
    assert noisy_pixels.effective(np.zeros(3)) == math.inf


def test_doubts_about_error_and_brightness_add_up():
    noise, light = Figure(1.0, 50.0, 4), Figure(1.0, 1e12, 4, 0.09)
    both = Figure(1.0, 50.0, 4, 0.09)
    assert light.quantile(0.975) == pytest.approx(math.exp(1.96 * 0.3), rel=1e-3)
    # What may be missing counts upwards only.
    missing = both._replace(brightness=0.05, rise=0.04)
    assert missing.quantile(0.975) == both.quantile(0.975)
    assert missing.quantile(0.025) == both._replace(brightness=0.05).quantile(0.025)
    for p in (0.025, 0.9, 0.975):
        parts = math.hypot(math.log(noise.quantile(p)), math.log(light.quantile(p)))
        assert abs(math.log(both.quantile(p))) == pytest.approx(parts, rel=1e-3)
    # Where there is no evidence only the lower end moves.
    low = Figure(1.0, 50.0, 4, 0.09, 0.25)
    assert low.quantile(0.975) == both.quantile(0.975)
    assert low.quantile(0.025) == pytest.approx(0.25 * both.quantile(0.025))


@pytest.mark.parametrize("confidence", [0.002, 0.01, 0.5, 0.95])
def test_an_interval_holds_its_value_however_little_is_asked(confidence):
    for figure in (Figure(3.0, 1e6, 4, 0.01), Figure(3.0, 1e6, 4, 0.01, 0.25)):
        found = figure.interval(confidence)
        assert found.low < found.value < found.high


# ------------------------------------------------------------------------- surroundings


@pytest.mark.parametrize("size", [(40, 40), (13, 21), (8, 8), (5, 3), (1, 9)])
@pytest.mark.parametrize("noise", [0.0, 0.5, 30.0, 1e6])
def test_a_plain_picture_is_as_bright_around_as_it_is(size, noise):
    mean = np.ones((3, *size), np.float32) * np.array([1.0, 2.0, 3.0], np.float32)[:, None, None]
    found = around(mean, np.full_like(mean, noise), 1e-6)
    np.testing.assert_allclose(found, mean, rtol=1e-5)


@pytest.mark.parametrize(("noise", "window"), [(1e-4, 8), (8.0, 63), (40.0, 575)])
def test_a_pixel_has_no_part_in_its_own_surroundings(noise, window):
    mean = np.ones((3, 48, 48), np.float32)
    lifted = mean.copy()
    lifted[:, 20, 21] += 0.1
    found = around(lifted, np.full_like(mean, noise), 1e-6)
    assert found[0, 20, 21] == pytest.approx(1.0)
    # The noisier, the farther a pixel is seen, and the less.
    shares = (found[0] - 1.0)[found[0] > 1.0 + 1e-5]
    assert len(shares) == window
    np.testing.assert_allclose(shares, 0.1 / window, rtol=0.02)


def test_cells_and_neighbours_are_plain_sums():
    plane = np.random.default_rng(8).random((2, 20, 13)).astype(np.float32)
    cells = by_cells(plane)
    assert cells.shape == (2, 3, 2)
    assert cells[1, 2, 1] == pytest.approx(plane[1, 16:, 8:].sum(), rel=1e-5)
    assert (spread_out(cells, 20, 13)[1, 16:, 8:] == cells[1, 2, 1]).all()
    for reach in (1, 2):
        sums = neighbours(plane, reach)
        assert sums[0, 10, 6] == pytest.approx(
            plane[0, 10 - reach : 11 + reach, 6 - reach : 7 + reach].sum(), rel=1e-5
        )
        assert sums[0, 0, 12] == pytest.approx(plane[0, : 1 + reach, 12 - reach :].sum(), rel=1e-5)
