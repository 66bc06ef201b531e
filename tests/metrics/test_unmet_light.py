"""Light that no sample has met, and products of errors where a bright sample excuses itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

from alight.metrics.own_error import estimate_relmse, relmse_of
from alight.metrics.survey import survey
from alight.metrics.unmet_light import EVENTS, unmet_light


def in_colour(planes):
    """Replicates (h, w, R) in three channels, float32."""
    return np.repeat(planes[..., None], 3, axis=3).astype(np.float32)


@pytest.mark.parametrize("size", [(32, 32), (264, 256)])
def test_one_event_tells_how_much_more_darkness_may_hide(size):
    """Dark pixels are filled up to the root of epsilon, where each counts a half; 3.7 events that
    bring 0.5 each fill 3.7 * 0.5 / 0.1 of them."""
    means = np.ones((*size, 4))
    means[8:24] = 0.0
    means[12, 12, 3] = 2.0
    seen = survey(in_colour(means), np.full(means.shape, 16))
    expected = 3.689 * 0.5 / 0.1 / 2.0 / (size[0] * size[1])
    assert unmet_light(seen, 0.01) == pytest.approx(expected, rel=1e-3)
    # Where a dark pixel has four times the samples, less can hide there; elsewhere as much.
    counts = np.full(means.shape, 16)
    counts[8:16] *= 4
    events = survey(in_colour(means), counts)
    assert unmet_light(events, 0.01) == pytest.approx(4.0 * expected, rel=1e-3)


@pytest.mark.parametrize("size", [(1, 70000), (2, 35000), (7, 10000), (70000, 1), (266, 256)])
def test_a_large_picture_of_any_height_is_looked_at_in_proportion(size):
    """As many pixels of a small picture, that is looked at whole, hide as much."""
    means = np.ones((size[0] * size[1], 4))
    means[::3] = 0.0
    means[3 * 999, 3] = 2.0
    counts = np.full(means.shape, 16)

    def of(shape, part):
        seen = survey(in_colour(means[part].reshape(*shape, 4)), counts[part].reshape(*shape, 4))
        return unmet_light(seen, 0.01)

    small, part = (60, 60), slice(0, 3600)
    assert of(size, slice(None)) * means.shape[0] == pytest.approx(of(small, part) * 3600, rel=0.02)


def test_a_large_picture_with_few_known_rows_is_looked_at_there():
    means = np.ones((300, 400, 4))
    means[101:104:2, :, :] = 0.0
    means[102, 7] = (0.0, 0.0, 0.0, 2.0)
    counts = np.zeros(means.shape, int)
    counts[101:104] = 16
    assert unmet_light(survey(in_colour(means), counts), 0.01) > 0.0


def test_no_way_to_hide_the_light_makes_more_of_it():
    rng = np.random.default_rng(5)
    truth = rng.exponential(1.0, (16, 16)) ** 2
    means = truth[..., None] * (1.0 + 0.1 * rng.normal(size=(16, 16, 4)))
    means[3, 3] = (0.0, 0.0, 3.0, 0.0)
    counts = np.repeat(rng.integers(1, 9, (16, 16))[..., None], 4, axis=2)
    counts[3, 3] = 4
    seen = survey(in_colour(means), counts)
    epsilon, n, m = 0.01, counts.sum(axis=2), seen.picture[0].astype(float)
    bound, budget, most = unmet_light(seen, epsilon), EVENTS * 16 * 0.75, 0.0
    for _ in range(400):
        chosen = rng.permutation(256)[: rng.integers(1, 200)]
        # As much as each likes best, times anything, until all is spent; and the best ones first.
        likes = np.sqrt(m.flat[chosen] ** 2 + epsilon) * np.exp(0.3 * rng.normal(size=len(chosen)))
        if rng.random() < 0.7:
            order = np.argsort(n.flat[chosen] * (m.flat[chosen] + likes))
            chosen, likes = chosen[order], likes[order]
        left = budget - (np.cumsum(n.flat[chosen] * likes) - n.flat[chosen] * likes)
        x = np.clip(left / n.flat[chosen], 0.0, likes)
        most = max(most, float((x * x / ((m.flat[chosen] + x) ** 2 + epsilon)).sum()) / 256)
    assert 0.6 * bound < most <= bound


@pytest.mark.parametrize(("events", "hidden"), [(3.0, True), (4.5, False)])
def test_light_of_many_events_is_not_overlooked(events, hidden):
    """m^2 / SE^2 is how many events a pixel's light came in."""
    means = np.full((16, 16, 4), 1.0)
    z = math.sqrt(3.0 / events)
    means[5, 5] *= (1.0 + z, 1.0 + z, 1.0 - z, 1.0 - z)
    seen = survey(in_colour(means), np.full(means.shape, 16))
    assert (unmet_light(seen, 1e-4) > 0.0) == hidden


def test_the_interval_reaches_up_to_light_that_was_not_met():
    """An event in a dark patch; alike, but seen by all replicates, it tells of no missed light."""
    rng = np.random.default_rng(7)
    means = 1.0 + 0.1 * rng.normal(size=(32, 32, 4))
    means[8:24, 8:24] *= 0.02
    confirmed = means.copy()
    means[12, 12, 3] += 0.4
    confirmed[12, 12] += 0.1
    figures = []
    for planes in (means, confirmed):
        seen = survey(in_colour(planes), np.full(means.shape, 16))
        figure = relmse_of(seen, literature=False).figure
        unmet = math.log1p(unmet_light(seen, seen.epsilon) / figure.value) / 1.96
        assert figure.rise == pytest.approx(unmet**2, rel=0.05, abs=1e-6)
        figures.append(figure)
    assert figures[0].rise > 0.04
    assert figures[1].rise < 1e-3
    # The interval reaches at least as far.
    assert figures[0].interval().high > figures[0].value * math.exp(1.96 * figures[0].rise ** 0.5)


def test_a_bright_sample_does_not_excuse_its_part_in_the_spread():
    """One pixel of twenty is dark, its light comes in six events; Var(relMSE - estimate) is known.

    By brightness that holds the error itself, the claim is 0.4 of it.
    """
    rng = np.random.default_rng(11)
    dark = rng.random((64, 64)) < 0.05
    truth, events = np.where(dark, 0.2, 1.0), np.where(dark, 6.0, 400.0)
    relative = truth**2 / events / (truth**2 + (0.1 * truth.mean()) ** 2)
    expected = 8.0 / 3.0 * float((relative**2).mean()) / 64**2
    claimed = []
    for _ in range(8):
        hits = rng.poisson(events[..., None] / 4.0, (64, 64, 4))
        means = in_colour((truth / events)[..., None] * 4.0 * hits)
        found = estimate_relmse(means, np.full(hits.shape, 16), literature=False).figure
        claimed.append(8.0 / 3.0 * found.value**2 / found.freedom)
    assert 0.8 < np.mean(claimed) / expected < 1.6
