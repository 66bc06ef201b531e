"""Laws of a pixel's mean and standard error: the truth, units, numbers of samples, coverage."""

import math

import numpy as np
import pytest
from scipy import stats

from alight.films import Film
from alight.films.fixed_point import MAX_SAMPLES, to_limbs
from alight.films.ledger import Bias
from alight.films.statistics import mean_and_error, pixel_mean, replicate_means


def sums_of(samples):
    """Sums and counts of samples (n, h, w, R, C), as a film holds them."""
    limbs, _, _ = to_limbs(samples.astype(np.float32))
    sums = limbs.sum(axis=0)
    carry = sums[..., 1] >> 40
    sums[..., 0] += carry
    sums[..., 1] -= carry << 40
    return sums, np.full(samples.shape[1:4], len(samples))


@pytest.mark.parametrize("replicates", [2, 3, 4, 8])
def test_equal_replicates_have_scipys_standard_error(replicates):
    rng = np.random.default_rng(replicates)
    samples = rng.gamma(1.0, size=(6, 3, 4, replicates, 3))
    sums, counts = sums_of(samples)
    means = replicate_means(sums, counts)
    np.testing.assert_allclose(means, samples.mean(axis=0), rtol=1e-6)
    mean, error = mean_and_error(sums, counts)
    np.testing.assert_allclose(mean, means.mean(axis=2), rtol=1e-12)
    np.testing.assert_allclose(mean, pixel_mean(sums, counts), rtol=1e-12)
    np.testing.assert_allclose(error, stats.sem(means, axis=2), rtol=1e-9)


def test_unequal_replicates_count_by_their_samples():
    rng = np.random.default_rng(1)
    sums, _ = sums_of(rng.gamma(1.0, size=(1, 2, 2, 4, 3)))
    counts = np.broadcast_to([1, 2, 5, 8], (2, 2, 4)).copy()
    values = sums[..., 0] / 2.0**8 + sums[..., 1] / 2.0**48
    mean, error = mean_and_error(sums, counts)
    np.testing.assert_allclose(mean, values.sum(axis=2) / 16)
    np.testing.assert_allclose(replicate_means(sums, counts), values / counts[..., None])
    squares = ((values - counts[..., None] * mean[:, :, None]) ** 2).sum(axis=2)
    np.testing.assert_allclose(error, np.sqrt(squares / (16**2 - 94)))


@pytest.mark.parametrize(("power", "expected"), [(1.0, 1.0), (2.0, 3.46875 * 256 / 4 / 162)])
def test_squared_errors_of_unequal_replicates_are_unbiased_for_independent_samples(power, expected):
    counts = np.array([1, 2, 5, 8])
    rng = np.random.default_rng(6)
    means = 5.0 + rng.standard_normal((120, 120, 4, 1)) * counts[:, None] ** (-0.5 * power)
    limbs, _, _ = to_limbs((means * counts[:, None]).astype(np.float32))
    _, error = mean_and_error(limbs, np.broadcast_to(counts, (120, 120, 4)))
    truth = (counts ** (2.0 - power)).sum() / 256
    assert (error**2).mean() / truth == pytest.approx(expected, rel=0.05)


def test_intervals_cover_and_errors_fall_by_the_root_of_the_samples():
    rng, medians = np.random.default_rng(2), []
    for count in (2, 8):
        samples = 0.5 + 0.1 * rng.standard_normal((count, 60, 60, 4, 1))
        mean, error = mean_and_error(*sums_of(samples))
        missed = np.abs(mean - 0.5) > stats.t.ppf(0.975, 3) * error
        assert abs(missed.mean() - 0.05) < 4.0 * math.sqrt(0.05 * 0.95 / missed.size)
        # SE^2 is unbiased: 3600 of 3 degrees of freedom.
        truth = 0.1**2 / (4 * count)
        assert (error**2).mean() == pytest.approx(truth, rel=4.0 * math.sqrt(2.0 / 3.0 / 3600))
        medians.append(np.median(error))
    assert medians[0] / medians[1] == pytest.approx(2.0, rel=0.06)


def test_units_and_the_order_of_replicates_and_pixels():
    samples = np.random.default_rng(3).gamma(1.0, size=(3, 4, 5, 4, 3))
    one = mean_and_error(*sums_of(samples))
    for scaled, of in (
        (4.0 * samples, lambda x: 4.0 * x),
        (samples[:, :, :, ::-1], lambda x: x),
        (samples[..., ::-1], lambda x: x[..., ::-1]),
        (samples.swapaxes(1, 2), lambda x: x.swapaxes(0, 1)),
    ):
        for found, expected in zip(mean_and_error(*sums_of(scaled)), one, strict=True):
            np.testing.assert_allclose(found, of(expected), rtol=1e-6)


def test_the_error_is_unknown_while_any_replicate_is_empty():
    samples = np.random.default_rng(4).gamma(1.0, size=(2, 2, 2, 4, 3))
    sums, counts = sums_of(samples)
    sums[0, 0, 1:], counts[0, 0, 1:] = 0, 0
    sums[1, 1], counts[1, 1] = 0, 0
    mean, error = mean_and_error(sums, counts)
    assert np.isnan(error[0, 0]).all()
    assert np.isnan(error[1, 1]).all()
    assert np.isfinite(error[[0, 1], [1, 0]]).all()
    assert (mean[1, 1] == 0.0).all()
    np.testing.assert_allclose(mean[0, 0], samples[:, 0, 0, 0].mean(axis=0), rtol=1e-6)
    assert (replicate_means(sums, counts)[0, 0, 1:] == 0.0).all()
    assert np.isnan(mean_and_error(sums[:, :, :1], counts[:, :, :1])[1]).all()


def test_so_many_bright_samples_that_whole_numbers_would_overflow():
    """Each replicate's sum fits in an int64; that of all of them does not."""
    each = MAX_SAMPLES - 1
    sums = np.zeros((1, 2, 4, 3, 2), np.int64)
    sums[..., 0] = each * 2**44
    counts = np.full((1, 2, 4), each)
    assert int(sums[0, 0, :, 0, 0].astype(object).sum()) > 2**63
    mean = pixel_mean(sums, counts)
    np.testing.assert_allclose(mean, 2.0**36)
    empty = pixel_mean(0 * sums[:, :1], 0 * counts[:, :1])
    assert (empty == 0.0).all()
    # One sample in a pixel beside them is its own mean.
    counts[0, 1], sums[0, 1] = [1, 0, 0, 0], 0
    sums[0, 1, 0, :, 0] = 3 * 2**8
    np.testing.assert_allclose(pixel_mean(sums, counts)[0, 1], 3.0)


def test_a_fourth_channel_changes_nothing_of_the_picture_and_its_error():
    films = Film(24, 16), Film(24, 16, channels=("R", "G", "B", "A"))
    samples = np.random.default_rng(5).lognormal(0.0, 0.3, (2, 16, 24, 4, 3))
    for film in films:
        film.sums[..., :3, :], film.counts[...] = sums_of(samples)
    films[1].sums[..., 3, 0] = 10**9
    for said in ("image", "standard_error", "error"):
        np.testing.assert_equal(*(getattr(film, said) for film in films), said)
    np.testing.assert_equal(*(film.replicate_means() for film in films))
    np.testing.assert_equal(*(film.interval() for film in films))


@pytest.mark.parametrize("effect", [-0.25, 0.125])
def test_a_bias_is_a_part_of_the_light_that_there_would_be_without_it(effect):
    light, doubt = 0.5, 0.0625
    found = Bias("clamp", "said", effect, doubt).relative(light + effect)
    assert (found.effect, found.error) == (effect / light, doubt / light)
    assert f"{100 * effect / light:+.0f} ± 12 %".replace("-", "\N{MINUS SIGN}") in found.line
    # Of no light at all there is no part.
    assert Bias("clamp", "said", effect, doubt).relative(effect).effect is None
