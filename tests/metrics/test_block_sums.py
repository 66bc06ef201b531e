"""Sums over blocks: they add up, and their third cumulant is that of the noise."""

import math

import numpy as np
import pytest

from alight.metrics import Measured, block_sums
from alight.metrics.block_sums import BlockSums
from alight.metrics.statistics import t_to_z

NAMES = ("pixels", "size", "difference", "squares", "variance", "exchanged", "fourth", "spread")


def noisy(seed, shape=(300, 40, 2), shape_of_noise=2.0, replicates=4, scale=1.0, spp=16):
    """Gamma noise of mean 1: its cumulants are known."""
    rng = np.random.default_rng(seed)
    means = scale * rng.gamma(shape_of_noise, 1 / shape_of_noise, (replicates, *shape))
    error = means.std(axis=0, ddof=1) / math.sqrt(replicates)
    return Measured(means.mean(axis=0), error, replicates, np.full(shape[:2], spp))


def test_blocks_of_blocks_are_blocks():
    """The picture is taller than what is worked on at a time, and no multiple of a block."""
    a, b = noisy(1), noisy(2, spp=64)
    fine, coarse = BlockSums.of(a, b, 4), BlockSums.of(a, b, 16)
    whole = fine.whole
    assert fine.count == (75, 10)
    assert whole.count == (1, 1)
    for name in NAMES:
        joined = getattr(fine.joined(4), name)
        np.testing.assert_allclose(joined, getattr(coarse, name), rtol=1e-9, atol=1e-12)
        total = getattr(fine, name).sum(axis=(0, 1))
        np.testing.assert_allclose(getattr(whole, name)[0, 0], total, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(fine.third, coarse.third)


@pytest.mark.parametrize("strip", [1, 24, 1000])
def test_how_many_rows_are_worked_on_at_a_time_does_not_matter(strip, monkeypatch):
    """Fewer than a block has, too: a block may be as large as the picture."""
    a, b = noisy(1, (70, 40, 2)), noisy(2, (70, 40, 2), spp=64)
    expected = BlockSums.of(a, b, 16)
    monkeypatch.setattr(block_sums, "_STRIP", strip)
    found = BlockSums.of(a, b, 16)
    for name in NAMES:
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-9)


def test_what_each_picture_says_of_the_other_is_exchanged():
    """Four times the samples have a quarter of the squared error."""
    a, b = noisy(1, spp=16), noisy(2, spp=64)
    sums = BlockSums.of(a, b, 4).whole
    own, other = (np.sum(side.error**2, axis=(0, 1)) for side in (a, b))
    np.testing.assert_allclose(sums.variance[0, 0], own + other)
    np.testing.assert_allclose(sums.exchanged[0, 0], own / 4 + other * 4)
    unknown = Measured(b.mean, b.error, b.replicates)
    assert not BlockSums.of(a, unknown, 4).exchanged.any()


def test_the_third_cumulant_is_that_of_the_noise():
    """Of a gamma mean over R replicates it is 2 / (k R)^2; both sides' are subtracted."""
    shape, k, r = (256, 256, 1), 2.0, 4
    n = shape[0] * shape[1]
    exact = Measured(np.ones(shape), np.zeros(shape), r)
    one = BlockSums.of(noisy(3, shape, k, r), exact, 4)
    # `third` has one standard error of itself on top: 2 % of it here.
    assert float(one.third[0]) / n == pytest.approx(2.0 / (k * r) ** 2, rel=0.12)
    # About the mean difference: one that is the same everywhere is no skewness.
    for shift in (0.5, -0.5):
        shifted = BlockSums.of(noisy(3, shape, k, r), Measured(np.full(shape, 1.0 + shift),
                               np.zeros(shape), r), 4)  # fmt: skip
        assert shifted.third[0] == pytest.approx(float(one.third[0]), rel=0.12)
    two = BlockSums.of(noisy(3, shape, k, r), noisy(4, shape, k, r), 4)
    assert float(two.third[0]) < 0.15 * float(one.third[0])


def test_skewness_falls_with_the_root_of_the_number_of_pixels():
    a, exact = noisy(3), Measured(np.ones((300, 40, 2)), np.zeros((300, 40, 2)), 4)
    sums = BlockSums.of(a, exact, 2)
    # Skewness 2 / sqrt(k R) of one pixel; four pixels have half of it.
    assert sums.skewness == pytest.approx(0.5 * 2.0 / math.sqrt(2.0 * 4), rel=0.25)
    assert sums.joined().skewness == pytest.approx(0.5 * sums.skewness, rel=0.1)


@pytest.mark.parametrize("shape", [(1, 2, 1), (1, 3, 1), (4, 4, 1)])
def test_pixels_that_differ_by_more_than_they_say_are_judged_by_their_spread(shape):
    """The sum over n times the spread of its terms, however small the errors claim to be."""
    d = np.random.default_rng(11).normal(0.2, 1.0, shape)
    few = Measured(1.0 + d, np.full(shape, 1e-3), 4)
    sums = BlockSums.of(few, Measured(np.ones(shape), np.zeros(shape), 4), 4)
    dof = np.maximum(sums.variance**2 / sums.spread - 2.0, 1.0)
    expected = d.sum() / math.sqrt(d.size * d.var(ddof=1))
    np.testing.assert_allclose(sums.z(), t_to_z(np.full((1, 1, 1), expected), dof), rtol=1e-5)
    # By themselves they would say that it is a thousand times the error.
    assert abs(sums.z(own=True)).min() > abs(sums.z()).max()


def test_a_block_of_unknown_error_is_not_judged_and_others_are():
    a, b = noisy(1), noisy(2)
    a.error[:8, :8] = np.nan
    a.mean[:8, :8] = 100.0
    z = BlockSums.of(a, b, 8).z()
    assert np.isnan(z[0, 0]).all()
    assert np.isfinite(z).sum() == z.size - 2
    assert np.abs(BlockSums.of(a, b, 8).whole.z()).max() < 5.0


def test_noise_below_rounding_is_none():
    """A sky of one colour: its z would be 0 and make the others' rms look too small."""
    a, b = noisy(1), noisy(2)
    for side, rest in ((a, 0.0), (b, 1e-8)):
        side.mean[:160] = 1.0 + rest
        side.error[:160] = 1e-9
    sums = BlockSums.of(a, b, 4)
    assert np.isnan(sums.z()[:40]).all()
    assert np.isfinite(sums.z()[40:]).all()
    b.mean[:160] += 1e-4
    assert np.abs(BlockSums.of(a, b, 4).z()[:40]).min() > 10.0
