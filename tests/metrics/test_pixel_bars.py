"""Error bars of single pixels hold as often as they say, in heavy tails too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from alight.core.errors import OptionError
from alight.films import Film
from alight.metrics.pixel_bars import pixel_bars

SIZE = 48


def gaussian(rng, samples):
    return 1.0 + 0.5 * rng.normal(size=(4, SIZE, SIZE)) / np.sqrt(samples)


def rare(rng, samples):
    """Half of the light comes with one sample in fifty."""
    return 0.5 + 0.5 * rng.binomial(samples, 0.02, (4, SIZE, SIZE)) / samples / 0.02


def log_normal(rng, samples):
    return np.exp(1.8 * rng.normal(size=(samples, 4, SIZE, SIZE)) - 1.62).mean(axis=0)


def bars_of(planes, confidence=0.95):
    means = (np.moveaxis(planes, 0, 2)[..., None] * np.array([1.0, 0.6, 0.3])).astype(np.float32)
    return pixel_bars(means, np.full(means.shape[:3], 4), confidence)


def inside(bars, truth):
    expected = truth * np.array([1.0, 0.6, 0.3])
    return ((bars.low <= expected) & (expected <= bars.high))[~bars.unsure].mean()


@pytest.mark.parametrize("noise", [gaussian, rare, log_normal])
@pytest.mark.parametrize("samples", [1, 4, 16])
@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_bars_hold_as_often_as_they_say(noise, samples, confidence):
    held = [
        inside(bars_of(noise(np.random.default_rng(seed), samples), confidence), 1.0)
        for seed in range(3)
    ]
    # Pixels share their cell's variance: a few per cent of play.
    assert np.mean(held) > confidence - 0.02


@pytest.mark.parametrize("confidence", [0.5, 0.8, 0.95])
def test_bars_of_normal_noise_are_no_longer_than_they_must_be(confidence):
    held = [
        inside(bars_of(gaussian(np.random.default_rng(seed), 4), confidence), 1.0)
        for seed in range(6)
    ]
    assert np.mean(held) == pytest.approx(confidence, abs=0.045)


@pytest.mark.parametrize("replicates", [2, 3, 4, 8])
@pytest.mark.parametrize("confidence", [0.8, 0.95])
def test_bars_of_an_even_picture_are_students_with_five_more_degrees(replicates, confidence):
    """Pixels alike say the same as their cells: nothing is left but the quantile."""
    values = 1.0 + 0.01 * np.random.default_rng(replicates).normal(size=replicates)
    means = np.tile(values[:, None], (SIZE, SIZE, 1, 3)).astype(np.float32)
    bars = pixel_bars(means, np.full(means.shape[:3], 4), confidence)
    error = values.std(ddof=1) / np.sqrt(replicates)
    half = stats.t.ppf(0.5 + 0.5 * confidence, replicates - 1 + 5) * error
    np.testing.assert_allclose(0.5 * (bars.high - bars.low), half, rtol=1e-4)
    np.testing.assert_allclose(0.5 * (bars.high + bars.low), values.mean(), rtol=1e-6)


def test_own_replicates_alone_would_be_far_too_sure():
    planes = rare(np.random.default_rng(1), 4)
    error = planes.std(axis=0, ddof=1) / 2.0
    assert (np.abs(planes.mean(axis=0) - 1.0) <= 3.18 * error).mean() < 0.8


def test_a_plain_background_is_exact_beside_noise():
    planes = rare(np.random.default_rng(2), 4)
    planes[:, :, :24] = 1.0
    bars = bars_of(planes)
    assert (bars.low[:, :24] == bars.high[:, :24]).all()
    assert not bars.unsure[:, :24].any()


def test_a_cell_beside_bright_samples_has_longer_bars_than_its_own_noise_says():
    planes = gaussian(np.random.default_rng(3), 400)
    alone = bars_of(planes)
    for y, x in ((2, 3), (5, 6), (11, 2), (3, 12), (12, 12), (9, 5)):
        planes[1, y, x] += 40.0
    beside = bars_of(planes)
    quiet = np.s_[16:24, 8:16]
    longer = (beside.high - beside.low)[quiet] / (alone.high - alone.low)[quiet]
    assert np.median(longer) > 1.5


def test_one_firefly_leaves_the_pixels_around_unsure():
    planes = gaussian(np.random.default_rng(4), 400)
    assert bars_of(planes).unsure_share == 0.0
    planes[2, 20, 20] += 40.0
    unsure = bars_of(planes).unsure
    assert unsure[16:24, 16:24].all()
    assert not unsure[-4:, -4:].any()
    assert 0.0 < unsure.mean() < 1.0


@pytest.mark.parametrize("channel", range(3))
def test_one_channel_is_enough_to_be_unsure(channel):
    """A lamp behind coloured glass is missing in one."""
    planes = gaussian(np.random.default_rng(4), 400)
    means = np.repeat(np.moveaxis(planes, 0, 2)[..., None], 3, axis=-1).astype(np.float32)
    counts = np.full(means.shape[:3], 4)
    assert pixel_bars(means, counts).unsure_share == 0.0
    means[20, 20, 2, channel] += 40.0
    assert pixel_bars(means, counts).unsure[16:24, 16:24].all()


def test_bars_scale_with_the_light_and_do_not_know_the_order_of_replicates():
    planes = rare(np.random.default_rng(5), 4)
    a, b, c = bars_of(planes), bars_of(4.0 * planes), bars_of(planes[::-1])
    np.testing.assert_allclose(b.high, 4.0 * a.high, rtol=1e-4)
    np.testing.assert_allclose(c.low, a.low, rtol=1e-3, atol=1e-5)
    assert (b.unsure == a.unsure).all()


def test_what_is_not_known_is_nan_and_unsure():
    means = np.ones((16, 16, 4, 3), np.float32)
    counts = np.full((16, 16, 4), 2)
    counts[3, 4, 1] = 0
    bars = pixel_bars(means, counts)
    assert np.isnan(bars.low[3, 4]).all()
    assert bars.unsure[3, 4]
    assert np.isfinite(bars.low).sum() == 3 * 255
    single = pixel_bars(means[:, :, :1], counts[:, :, :1])
    assert np.isnan(single.high).all()
    assert single.unsure.all()


def test_a_film_refuses_an_impossible_confidence():
    with pytest.raises(OptionError, match=r"confidence: must lie in \(0, 1\), as 0.95, got 95"):
        Film(8, 8).interval(95)
