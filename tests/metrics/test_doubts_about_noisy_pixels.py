"""What is left open about the brightness of noisy pixels: how many, how unlike, how few samples."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special, stats

from alight.metrics import noisy_pixels
from alight.metrics.own_error import estimate_relmse
from alight.metrics.relmse import relmse
from alight.metrics.surroundings import around


def one_group(pixels, r=1.0, rho=1.0, noise=0.0, floor=0.0, unevenness=0.0, differing=1.0):
    """What is believed of pixels in one group, and the samples that B should hold, by the prior."""
    sums, one = noisy_pixels.no_sums(), np.ones(9 * pixels)
    noisy_pixels.gather(
        sums, np.zeros(len(one), np.uint8), np.zeros(len(one), np.uint8), r * one, rho * one,
        differing * rho * rho * one, floor * one, one, noise * one,
    )  # fmt: skip
    expected = 2.0 * pixels / math.sqrt(8.0 * r)
    tail = stats.poisson.sf(math.ceil(expected * rho) - 1, expected) if expected * rho > 0.5 else 1
    found = noisy_pixels.believe(sums, 9, 2, 2, 4, unevenness)
    return found, expected, tail / (expected + tail)


@pytest.mark.parametrize("floor", [0.0, 0.25])
@pytest.mark.parametrize(("pixels", "rho"), [(1, 1.0), (3, 1.0), (20, 1.0), (40, 0.5)])
def test_few_bright_samples_leave_open_what_a_rate_is(pixels, rho, floor):
    """log(rate) after K events has the variance trigamma(K + 1), and log(weight) up to four times
    that; all of it where one group tells nothing, as far as the samples speak."""
    found, expected, share = one_group(pixels, rho=rho, floor=floor)
    believed = (1.0 - share) * rho + share
    slope = 2.0 * believed**2 / (believed**2 + floor)
    few = (slope * (1.0 - share)) ** 2 * special.polygamma(1, expected * rho + 1.0)
    assert found.variance == pytest.approx(math.log1p(few), rel=0.01)


@pytest.mark.parametrize("pixels", [4, 20])
def test_pixels_that_differ_are_as_many_degrees_of_freedom(pixels):
    """log(rho) with the variance v: the weight has the relative variance exp(4 v) - 1, and its
    doubt by shape is a third of 4 v."""
    alike, _, share = one_group(pixels)
    found = one_group(pixels, differing=1.3)[0]
    v = math.log((1.0 - share) * 1.3 + share)
    student = stats.t.ppf(0.975, pixels) / stats.norm.ppf(0.975)
    within = math.log1p((math.exp(4.0 * v) - 1.0) / pixels) * student**2
    expected = alike.variance + within + (4.0 * v / 3.0) ** 2
    assert found.variance == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("pixels", [1, 4])
def test_unseen_pixels_are_as_unlike_their_surroundings_as_others(pixels):
    """One bright sample of 1000 times the surroundings a pixel: B should hold next to nothing."""
    found, _, share = one_group(pixels, r=1e6 / 8, unevenness=0.7)
    assert share > 0.98
    assert found.variance == pytest.approx(math.log1p(0.7 * share**2 / pixels), rel=0.02)


@pytest.mark.parametrize("spread", [0.0, 0.4])
def test_how_unlike_pixels_are_is_seen_in_precise_ones(spread):
    """One bright sample in a floor, even or not; its noise, 0.03 by each half, is in no product."""
    rng = np.random.default_rng(8)
    truth = np.exp(spread * rng.normal(size=(48, 48)))
    seen = truth[..., None] * (1.0 + 0.12 * rng.normal(size=(48, 48, 4)))
    seen[20, 20, 0] += 400.0
    picture = np.repeat(seen.mean(axis=2)[None], 3, axis=0).astype(np.float32)
    epsilon = 0.01 * picture.mean() ** 2
    q2 = around(picture, 0.0 * picture, 0.0)[0] ** 2
    unlike = np.log((truth**2 + epsilon) / (q2 + epsilon)) ** 2
    unlike[20, 20] = 1.0 / 3.0
    means, counts = np.repeat(seen[..., None], 3, axis=3), np.full(seen.shape, 8)
    doubt = estimate_relmse(means.astype(np.float32), counts, literature=False).figure.brightness
    assert doubt == pytest.approx(math.log1p(unlike.mean()), rel=0.12)


@pytest.mark.parametrize(
    ("pixels", "noise", "differing"),
    [(400, 0.5, math.exp(0.05)), (100, 0.1, math.exp(0.02)), (1, 50.0, 1.0), (2, 50.0, 2.0)],
)
def test_pixels_differ_by_no_more_than_their_number_and_coincidences_tell(pixels, noise, differing):
    """Seen alike, with rho = 1: E[rho^2] may be exp(1 / sqrt(pairs)), in n pixels at most n; and
    rho^-2 has the mean E[rho^2]^3 in a log-normal distribution of mean 1."""
    found = one_group(pixels, noise=noise)[0]
    assert found.weights[0] == pytest.approx(1.0)
    assert found.rise == pytest.approx(math.log1p((differing**3 - 1.0) ** 2), rel=2e-3)


def test_where_samples_have_both_signs_pixels_may_be_black():
    """Twice what pixels whose B is negative were if they were black, or nothing of that: uniform.

    A B of exactly nothing is no sign of cancelling samples: it has not met its light.
    """
    rng, sums = np.random.default_rng(3), noisy_pixels.no_sums()
    r, floor = rng.uniform(0.5, 2.0, 900), rng.uniform(0.01, 0.1, 900)
    rho = np.where(np.arange(900) < 90, -0.2, 1.0)
    rho[90:180] = 0.0
    noisy_pixels.gather(
        sums, np.repeat([1, 7], 450).astype(np.uint8), np.arange(900) % noisy_pixels.GROUPS, r,
        rho, np.ones(900), floor, np.ones(900), np.zeros(900),
    )  # fmt: skip
    found = noisy_pixels.believe(sums, 9, 2, 2, 4)
    black = 2.0 * float((r / floor)[:90].sum()) / found.value
    assert black > 1.0
    assert found.rise == pytest.approx(math.log1p(black) ** 2 / 3.0, rel=1e-6)


@pytest.mark.parametrize("hits", [0.5, 5.0])
def test_the_interval_holds_where_samples_cancel(hits):
    """A third of the pixels are all but black, with as much noise of both signs as the others."""
    held = 0
    for seed in range(24):
        rng = np.random.default_rng(40 + seed)
        level = np.kron(np.exp(1.5 * rng.normal(size=(6, 6))), np.ones((8, 8)))
        truth = level * np.where(rng.random((48, 48)) < 0.3, 0.02, 1.4)
        cancelling = rng.poisson(hits, (4, 48, 48)) - rng.poisson(hits, (4, 48, 48))
        means = np.moveaxis(truth + 0.5 * level * cancelling / math.sqrt(hits), 0, 2)
        means = np.repeat(means[..., None], 3, axis=3).astype(np.float32)
        error = relmse(means.mean(axis=2), np.repeat(truth[..., None], 3, axis=2))
        found = estimate_relmse(means, np.full(means.shape[:3], 4), literature=False).relmse
        held += found.low <= error <= found.high
    # Of 24 at 95 %, fewer than 19 have a probability of 0.1 %.
    assert held >= 19
