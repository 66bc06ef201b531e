"""Noise of light that paths find by chance, before samples tell it."""

import math

import numpy as np
import pytest

from alight.rendering.pilot_rays import POINTS
from alight.rendering.schedules.rare_noise import RareNoise, rare_noise, without_samples
from alight.rendering.schedules.stopping import Promise, judge_means


def numbers_of(rates, sizes, spp, seed, n=32):
    """A picture of numbers, n^2 pixels: 1, and samples of some sizes that come at some rates."""
    rng, shape = np.random.default_rng(seed), (n, n, 4)
    light = sum(s * rng.binomial(spp // 4, r, shape) for r, s in zip(rates, sizes, strict=True))
    means = np.repeat(1.0 + light[..., None] / (spp // 4), 3, axis=3).astype(np.float32)
    return means, np.full(shape, spp // 4)


def rows_of(rates, sizes, n=32):
    """What the pilot knows of that: points in the cells in turn, a row for each kind of sample."""
    points = np.repeat(np.arange(POINTS), len(rates))
    rates, sizes = np.tile(rates, POINTS), np.tile(sizes, POINTS)
    light = np.repeat((rates * sizes)[:, None], 3, axis=1)
    return np.column_stack([points, points % (n // 8) ** 2, light, rates, rates])


def test_the_noise_of_rare_light_is_that_of_pictures_of_it():
    rates, sizes, spp = (3e-3, 4e-3), (100.0, 60.0), 64
    means, counts = numbers_of(rates, sizes, spp, 1, 64)
    rows = rows_of(rates, sizes, 64)
    rare = rare_noise(means, counts, rows)
    true = 1.0 + sum(np.multiply(rates, sizes))
    error = means.mean(axis=2) - true
    assert rare.noise == pytest.approx((error**2).mean() / (1.01 * true**2), rel=0.1)
    # Hundreds of both kinds are met: replicates tell all of it.
    assert rare.unmet < 1e-3 * rare.noise and rare.piloted < 0.1 * rare.noise
    assert rare.doubt < 0.08 and rare.size == pytest.approx(180.0)
    # Without those samples all replicates of nearly all pixels are 1 again.
    rest = without_samples(means, counts, rare.size)
    assert ((rest == 1.0).all(axis=(2, 3))).mean() > 0.9
    assert (means == 1.0).all(axis=(2, 3)).mean() < 0.7
    assert np.array_equal(without_samples(means, counts, math.inf), means)


def test_samples_tell_the_noise_of_what_they_have_met_and_not_of_larger_ones():
    """Of 65 536 samples 655 meet the small kind, and 0.66 the large one."""
    rates, sizes = np.array([1e-3, 1e-5]), np.array([3e3, 3e4])
    means, counts = np.full((32, 32, 4, 3), 2.0, np.float32), np.full((32, 32, 4), 16)
    rare = rare_noise(means, counts, rows_of(rates, sizes))
    part = rates * sizes**2 / (rates * sizes**2).sum()
    met = 65536 * np.array([rates.sum(), rates[1]])
    assert rare.unmet == pytest.approx((part * np.exp(-met)).sum() * rare.noise, rel=1e-6)
    assert rare.piloted == pytest.approx((part * 64 / (64 + met)).sum() * rare.noise, rel=1e-6)
    assert rare.doubt == pytest.approx(2.0 * math.sqrt((part / (64 + met)).sum()))


def test_noise_is_told_over_the_brightness_of_its_own_cell():
    """Of four cells; and light that no path finds brings none."""
    means, counts = np.ones((16, 16, 4, 3), np.float32), np.full((16, 16, 4), 16)
    means[8:, 8:] = 3.0
    rates, light = np.full(POINTS, 1e-5), np.full((POINTS, 3), 0.5)
    rates[7] = 0.0
    rows = np.column_stack([np.arange(POINTS), np.full(POINTS, 3), light, rates, rates])
    for cell, brightness in ((3, 3.0), (0, 1.0)):
        rows[:, 1] = cell
        square = 0.5**2 / ((brightness + 0.5) ** 2 + (0.1 * 1.5) ** 2)
        found = rare_noise(means, counts, rows)
        assert found.noise == pytest.approx(255 / 256 * square / (1e-5 * 64), rel=1e-6)


def test_light_that_most_replicates_have_met_is_not_rare():
    rates, sizes = (0.03,), (20.0,)
    means, counts = numbers_of(rates, sizes, 64, 1)
    assert rare_noise(means, counts, rows_of(rates, sizes)) == RareNoise()
    assert rare_noise(means, counts, None) == RareNoise()


def test_more_samples_are_told_for_the_noise_of_what_none_has_met():
    rates, sizes = (2e-6,), (5e5,)
    means, counts = numbers_of((0.0,), (0.0,), 64, 1)
    noisy = means * np.random.default_rng(2).normal(1.0, 0.05, means.shape).astype(np.float32)
    found = judge_means(noisy, counts, Promise(0.1), behind=rows_of(rates, sizes))
    # m = 1 of 2: its noise takes (m / 2)^2 / (q error^2) samples; but for e^-0.13 it is unmet.
    assert found.factor * 64 == pytest.approx(0.25 / 2e-6 / 0.01 * math.exp(-0.13), rel=0.1)
