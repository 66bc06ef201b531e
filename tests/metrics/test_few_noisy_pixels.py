"""A picture whose error is in a few pixels knows little of it, and says so."""

import math

import numpy as np
import pytest

from alight.metrics.few_pixels import FewPixels
from alight.metrics.own_error import estimate_relmse
from alight.metrics.relmse import relmse
from alight.metrics.statistics import f_quantile

SHARES = {
    "grey": np.ones((3, 3)) / math.sqrt(3.0),
    "independent": np.eye(3),
    "red": np.diag([1.0, 0.0, 0.0]),
}


def quiet_but_for(pixels, replicates, share, rng):
    """8x8 pixels of brightness 1, some of them with normal noise of 5 %."""
    means = np.ones((64, replicates, 3))
    noise = rng.normal(0.0, 0.05 * math.sqrt(replicates), (pixels, replicates, 3)) @ share
    means[rng.permutation(64)[:pixels]] += noise
    return means.reshape(8, 8, replicates, 3).astype(np.float32)


@pytest.mark.parametrize(
    ("pixels", "replicates", "share"),
    [
        (1, 4, "grey"),
        (1, 4, "independent"),
        (2, 4, "red"),
        (1, 8, "red"),
    ],
)
def test_the_interval_holds_where_few_pixels_carry_the_error(pixels, replicates, share):
    rng = np.random.default_rng([pixels, replicates])
    held = 0
    for _ in range(100):
        means = quiet_but_for(pixels, replicates, SHARES[share], rng)
        interval = estimate_relmse(means, np.full(means.shape[:3], 4)).relmse
        truth = relmse(means.astype(float).mean(axis=2), np.ones((8, 8, 3)))
        held += interval.low <= truth <= interval.high
    # Of 95 %: fewer than 88 of 100 have a probability of 0.2 %.
    assert held >= 88


@pytest.mark.parametrize("replicates", [4, 8])
def test_one_pixel_is_one_term_whatever_its_replicates_are(replicates):
    """Its true error over the estimate has the distribution F(1, R - 1)."""
    rng = np.random.default_rng(replicates)
    for _ in range(10):
        means = quiet_but_for(1, replicates, SHARES["grey"], rng)
        figure = estimate_relmse(means, np.full(means.shape[:3], 4)).figure
        assert figure.freedom == pytest.approx(1.0, abs=0.15)
        high = figure.value * f_quantile(0.975, 1.0, replicates - 1.0)
        assert figure.quantile(0.975) == pytest.approx(high, rel=0.3)


def test_many_alike_pixels_are_as_sure_as_their_number_makes_them():
    rng = np.random.default_rng(5)
    means = 1.0 + 0.05 * rng.normal(size=(48, 48, 4, 1)) * np.ones(3)
    figure = estimate_relmse(means.astype(np.float32), np.full(means.shape[:3], 4)).figure
    assert figure.freedom == pytest.approx(48 * 48, rel=0.12)


@pytest.mark.parametrize("replicates", [4, 6, 8, 16])
def test_chance_is_the_deviation_of_a_product_of_two_halves(replicates):
    """A variance with k degrees of freedom is a chi-squared number over k: 1 + 2/k its square."""
    size = replicates // 2
    few = FewPixels(replicates, size)
    few.add_sums(traces=3.0, squares=1e9, fourth_powers=4.0)
    deviation = math.sqrt((1.0 + 2.0 / (size - 1)) ** 2 - 1.0)
    # The estimate of the sum of traces is twice as large as by all replicates.
    assert few.at_least(5.0, 6.0) == pytest.approx(5.0 + 4.0 * 2.0 * deviation)
