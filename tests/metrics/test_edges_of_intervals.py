"""Intervals of a picture's error where there is hardly a picture, or hardly a replicate."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from alight.metrics.own_error import estimate_relmse
from alight.metrics.pixel_bars import pixel_bars
from alight.rendering.summary import error_line

REPLICATES = (2, 3, 4, 5, 64)


def one_sample(noise, size):
    """A black picture but for one sample."""
    noise = np.zeros_like(noise)
    noise[4, 4, 0] = size
    return noise


def one_black(noise):
    """One replicate has found nothing."""
    noise[:, :, 0] = 0.0
    return noise


#: What becomes of noise (9, 9, R, 3), and whether the error is known then.
PICTURES = {
    "noise": (lambda noise: noise, True),
    "one pixel": (lambda noise: noise[:1, :1], True),
    "one row": (lambda noise: noise[:1], True),
    "one replicate black": (one_black, True),
    "one sample in the dark": (lambda noise: one_sample(noise, 1.0), True),
    "one enormous sample": (lambda noise: 1.0 + one_sample(noise, 6e10), True),
    "hardly any light": (lambda noise: 1e-14 * noise, True),
    "as much light as a film takes": (lambda noise: 1e9 * noise, True),
    "no noise": (np.ones_like, True),
    "black": (np.zeros_like, False),
    "below zero": (lambda noise: -noise, False),
}


@pytest.mark.parametrize("replicates", REPLICATES)
@pytest.mark.parametrize("name", PICTURES)
def test_an_interval_is_in_order_or_unknown(name, replicates):
    make, known = PICTURES[name]
    means = make(np.random.default_rng(3).gamma(2.0, 0.5, (9, 9, replicates, 3)))
    means, counts = means.astype(np.float32), np.full(means.shape[:3], 16)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        found = estimate_relmse(means, counts)
        bars = pixel_bars(means, counts)
    assert not [str(warning.message) for warning in warned]
    for value, low, high in (found.relmse, found.relmse_literature):
        if known and replicates < 4:
            assert value >= 0.0
            assert math.isnan(low)
            assert math.isnan(high)
        elif known:
            assert 0.0 <= low <= value <= high < math.inf
        else:
            assert math.isnan(value)
            assert math.isnan(low)
            assert math.isnan(high)
    assert found.known == 1.0
    assert bars.unsure.shape == means.shape[:2]


@pytest.mark.parametrize("replicates", REPLICATES)
def test_pixels_without_one_replicate_are_unknown_and_no_others(replicates):
    means = np.random.default_rng(4).gamma(2.0, 0.5, (9, 16, replicates, 3)).astype(np.float32)
    counts = np.full(means.shape[:3], 16)
    counts[:, 8:, -1] = means[:, 8:, -1] = 0
    found = estimate_relmse(means, counts)
    assert found.known == 0.5
    if replicates >= 4:
        assert found.relmse.low <= found.relmse.value <= found.relmse.high
    counts[:, :, -1] = means[:, :, -1] = 0
    nothing = estimate_relmse(means, counts)
    assert nothing.known == 0.0
    assert math.isnan(nothing.relmse.value)


@pytest.mark.parametrize("replicates", [4, 8, 16])
def test_any_number_of_replicates_holds_the_error_and_none_is_wide_for_nothing(replicates):
    """Bright and dark pixels, 10 % of noise: there are as many degrees of freedom as pixels."""
    held, freedoms = 0, []
    for seed in range(30):
        rng = np.random.default_rng((5, seed))
        truth = np.where(rng.random((24, 24)) < 0.5, 0.3, 1.0)[..., None]
        noise = 0.2 * math.sqrt(replicates / 4.0) * rng.normal(size=(24, 24, replicates))
        means = np.repeat((truth * (1.0 + noise))[..., None], 3, axis=3).astype(np.float32)
        found = estimate_relmse(means, np.full(noise.shape, 16), literature=False)
        scale = truth[..., 0] ** 2 + (0.1 * truth.mean()) ** 2
        own = float(((means[..., 0].mean(axis=2) - truth[..., 0]) ** 2 / scale).mean())
        held += found.relmse.low <= own <= found.relmse.high
        freedoms.append(found.figure.freedom)
    # At 95 %, 24 of 30 or fewer have a probability below 1 %.
    assert held > 24
    # Weights lean towards the safe side: they leave 0.75, 0.84 and 0.89 of them.
    assert 0.7 < np.mean(freedoms) / 24**2 < 1.0


def test_light_of_few_events_in_half_a_picture_does_not_excuse_itself():
    """Dark pixels are lit by sixteen events, the others have 10 % of noise per replicate."""
    held, replicates, events = 0, 16, 16
    for seed in range(60):
        rng = np.random.default_rng((6, seed))
        truth = np.where(rng.random((64, 64)) < 0.5, 0.2, 1.0)[..., None]
        hits = rng.poisson(events / replicates, (64, 64, replicates)) * (replicates / events)
        even = rng.gamma(100.0, 0.01, hits.shape)
        means = np.repeat((truth * np.where(truth < 0.5, hits, even))[..., None], 3, axis=3)
        found = estimate_relmse(means.astype(np.float32), np.full(hits.shape, 4), literature=False)
        scale = truth[..., 0] ** 2 + (0.1 * truth.mean()) ** 2
        own = float(((means[..., 0].mean(axis=2) - truth[..., 0]) ** 2 / scale).mean())
        held += found.relmse.low <= own <= found.relmse.high
    # At 95 %, 51 of 60 or fewer have a probability of half a per cent; weights that lean to neither
    # side hold in 81 %.
    assert held > 51


@pytest.mark.parametrize("scale", [1e-12, 1e-10, 1.0, 1e10])
def test_no_brightness_makes_an_interval_short(scale):
    """Where epsilon of the literature outweighs the light, products of errors are below float32."""
    noise = np.random.default_rng(8).normal(1.0, 0.1, (24, 24, 4, 1)) * np.ones(3)
    means, counts = (scale * noise).astype(np.float32), np.full((24, 24, 4), 16)
    found = estimate_relmse(means, counts).figure_literature
    assert 0.0 < found.value < 0.1
    assert 1.0 <= found.freedom < 1.1 * 24**2


@pytest.mark.parametrize("replicates", [2, 3])
def test_the_summary_tells_why_there_is_no_interval(replicates):
    means = np.random.default_rng(7).gamma(4.0, 0.25, (16, 16, replicates, 3)).astype(np.float32)
    line = error_line(estimate_relmse(means, np.full(means.shape[:3], 16)))
    assert f"% relRMSE or more (an interval takes 4 replicates, there are {replicates})" in line
