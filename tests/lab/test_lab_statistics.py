"""Closed forms of the laboratory's statistics."""

import math

import numpy as np
import pytest
from scipy import stats

from alight.lab.figures import Figures
from alight.lab.statistics.decomposition import Moments, decompose, reference_spread
from alight.lab.statistics.intervals import (
    bootstrap_ratio,
    holm_adjusted,
    log_mean,
    log_ratio,
    log_slope,
    mean_interval,
)
from alight.metrics.relmse import relmse
from alight.metrics.smape import smape


def test_mean_interval_is_students():
    x = np.array([1.0, 2.0, 4.0, 8.0])
    low, high = stats.t.interval(0.95, 3, x.mean(), stats.sem(x))
    assert mean_interval(x) == pytest.approx((x.mean(), low, high), rel=1e-12)


def test_jackknife_of_a_logarithm():
    x = np.array([1.0, 2.0, 4.0, 8.0])
    without = np.log([14 / 3, 13 / 3, 11 / 3, 7 / 3])
    variance = 3 / 4 * ((without - without.mean()) ** 2).sum()
    assert log_mean(x).value == pytest.approx(math.log(3.75))
    assert log_mean(x).variance == pytest.approx(variance, rel=1e-12)


def test_log_mean_refuses_what_is_not_positive():
    with pytest.raises(ValueError, match="not positive"):
        log_mean(np.array([5.0, -1.0, -1.0]))


def test_ratio_of_two_arms_is_welchs():
    rng = np.random.default_rng(1)
    # Of numbers that hardly vary the logarithm is linear, and the jackknife the t test.
    a, b = 1.0 + 1e-4 * rng.standard_normal(9), 1.0 + 3e-4 * rng.standard_normal(16)
    found = log_ratio(log_mean(a), log_mean(b))
    expected = stats.ttest_ind(a, b, equal_var=False)
    assert found.p_value == pytest.approx(expected.pvalue, rel=2e-3)
    low, high = expected.confidence_interval()
    assert found.estimate.low == pytest.approx(1.0 + low, abs=1e-6)
    assert found.estimate.high == pytest.approx(1.0 + high, abs=1e-6)


def test_paired_ratio_is_the_paired_test():
    rng = np.random.default_rng(2)
    common = rng.standard_normal(12)
    a = 1.0 + 1e-3 * (common + 0.1 * rng.standard_normal(12))
    b = 1.0 + 1e-3 * (common + 0.1 * rng.standard_normal(12))
    found = log_ratio(log_mean(a), log_mean(b), paired=True)
    assert found.p_value == pytest.approx(stats.ttest_rel(a, b).pvalue, rel=5e-3)
    assert found.p_value < log_ratio(log_mean(a), log_mean(b)).p_value


def test_shared_noise_widens_the_interval():
    x = np.array([1.0, 1.1, 0.9, 1.05])
    alone = log_ratio(log_mean(x), log_mean(x[::-1] * 1.01))
    wide = log_ratio(log_mean(x), log_mean(x[::-1] * 1.01), extra_variance=0.04)
    assert math.log(wide.estimate.high / wide.estimate.low) > 2 * 1.9 * 0.2
    assert wide.p_value > alone.p_value


def test_holm_by_hand():
    assert holm_adjusted([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm_adjusted([0.9, 0.8]) == [1.0, 1.0]


def test_bootstrap_agrees_with_the_jackknife_where_both_are_right():
    rng = np.random.default_rng(3)
    a, b = rng.gamma(50.0, size=64), rng.gamma(50.0, size=64)
    ones = np.ones(64)
    jack = log_ratio(log_mean(a), log_mean(b)).estimate
    boot = bootstrap_ratio([a, ones], [b, ones], 5)
    assert boot.value == pytest.approx(jack.value)
    width = math.log(boot.high / boot.low) / math.log(jack.high / jack.low)
    assert 0.85 < width < 1.15


def test_slope_of_a_power_law():
    n = np.array([4.0, 16.0, 64.0])[:, None]
    scale = np.array([0.9, 1.0, 1.1, 1.2])
    found = log_slope(np.repeat(n, 4, axis=1), 3.0 / n * scale)
    # A factor common to all points of a replicate is no error of the slope.
    assert found == pytest.approx((-1.0, -1.0, -1.0), abs=1e-9)


def test_moments_are_numpys():
    rng = np.random.default_rng(4)
    pictures = rng.random((7, 4, 5, 3))
    moments = Moments()
    for picture in pictures:
        moments.add(picture)
    assert moments.mean == pytest.approx(pictures.mean(axis=0))
    assert moments.variance == pytest.approx(pictures.var(axis=0, ddof=1))


def test_mse_is_bias_and_variance_exactly():
    rng = np.random.default_rng(5)
    reference, variance = rng.random((6, 6, 3)).astype(np.float32), np.full((6, 6, 3), 1e-3)
    pictures = (reference + 0.1 + 0.2 * rng.standard_normal((9, 6, 6, 3))).astype(np.float32)
    moments, figures = Moments(), Figures(reference, variance)
    for picture in pictures:
        moments.add(picture.astype(np.float64))
    parts = decompose(moments, reference, variance)
    mse = np.mean([figures.of(picture)["mse"] for picture in pictures])
    assert parts.bias2.value + parts.variance == pytest.approx(mse, rel=1e-5)


@pytest.mark.parametrize("bias", [0.0, 0.3])
def test_the_interval_of_a_bias_has_the_variance_of_its_square(bias):
    n, moments = 5 * 7, Moments()
    for noise in (0.1, -0.1, 0.1, -0.1):
        moments.add(np.full((5, 7, 3), 1.0 + bias + noise))
    low, high = decompose(moments, np.ones((5, 7, 3)), None).bias2[1:]
    # Channels of a pixel count as alike: its square has three times the noise, and the bias.
    noise = 0.1**2 * 4.0 / 3.0 / 4.0
    b2 = bias**2 - noise
    variance = 2.0 * (3.0 * noise) ** 2 + 4.0 * max(9.0 * b2 * noise, 0.0)
    width = stats.norm.ppf(0.975) * math.sqrt(n * variance) / (3.0 * n)
    assert (low, high) == pytest.approx((b2 - width, b2 + width), rel=1e-5)


def test_figures_are_those_of_the_metrics():
    rng = np.random.default_rng(6)
    image = rng.random((8, 8, 3)).astype(np.float32)
    picture = (image + 0.1 * rng.standard_normal(image.shape)).astype(np.float32)
    noise = rng.random(image.shape) * 1e-3
    found = Figures(image, noise).of(picture)
    assert found["relmse"] == pytest.approx(relmse(picture, image, reference_variance=noise), 1e-4)
    literature = relmse(picture, image, reference_variance=noise, epsilon=0.01)
    assert found["relmse_literature"] == pytest.approx(literature, 1e-4)
    assert found["smape"] == pytest.approx(smape(picture, image), 1e-5)


def test_two_arms_that_are_not_pairs_share_no_noise():
    """The same numbers on both sides, as if by chance: their noise does not cancel."""
    x = np.random.default_rng(11).gamma(20.0, size=48)
    apart, paired = (bootstrap_ratio([x], [x], 3, paired=way) for way in (False, True))
    assert math.isnan(paired.value) or paired.high == pytest.approx(paired.low)
    expected = log_ratio(log_mean(x), log_mean(x)).estimate
    width = math.log(apart.high / apart.low) / math.log(expected.high / expected.low)
    assert 0.8 < width < 1.25
    # Nor need they be as many.
    fewer = bootstrap_ratio([x], [x[:24]], 3)
    assert fewer.high / fewer.low > apart.high / apart.low


def test_what_a_reference_adds_to_an_error_spreads_as_told():
    """Simulated: noise that three channels share, whose own variance is taken off as estimated."""
    rng, size, blocks = np.random.default_rng(12), 24, 9
    sigma = rng.uniform(0.2, 1.0, (size, 1, 1)) * np.ones((size, 1, 3))
    draws = rng.standard_normal((4000, blocks, size, 1, 1)) * sigma * math.sqrt(blocks)
    errors = draws.mean(axis=1) ** 2 - draws.var(axis=1, ddof=1) / blocks
    found = errors.mean(axis=(1, 2, 3)).var()
    assert reference_spread(sigma**2, blocks) == pytest.approx(found, rel=0.1)
