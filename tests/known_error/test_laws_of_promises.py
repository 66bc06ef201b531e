"""Laws of shares of pixels, of unseen light and of looks: closed forms, units and sizes."""

import math
from functools import partial

import numpy as np
import pytest
from scipy import stats

from alight.core.errors import OptionError
from alight.metrics.error_estimate import ErrorEstimate, Figure
from alight.metrics.own_error import estimate_relmse
from alight.rendering.schedules import stopping
from alight.rendering.schedules.stopping import (
    GROWTH,
    WHOLE_DOUBT,
    Promise,
    first_look,
    judge_means,
    look_doubt,
    next_look,
    share_within,
)
from alight.rendering.schedules.unseen import Unseen, cell_sum, spread_over_pixels, unseen_error

#: Signs of four replicates around their mean: a variance of 4/3 times the square of the step.
SIGNS = np.array([1.0, 1.0, -1.0, -1.0])[:, None]


def stepping(mean, step, counts=4):
    """Replicates that differ from the mean by exactly `step`: no chance is in them."""
    means = (mean[..., None] + step[..., None] * SIGNS[:, 0])[..., None] * np.ones(3)
    return means, np.full(means.shape[:3], counts)


def parts_of_share(means, counts, error, doubt=0.025):
    """The expected share and its margin, from the picture and four copies of it."""
    height, width = counts.shape[:2]
    assert height % 8 == width % 8 == 0
    one = share_within(means, counts, error, doubt)
    four = share_within(np.tile(means, (2, 2, 1, 1)), np.tile(counts, (2, 2, 1)), error, doubt)
    # Four times the pixels, half the margin.
    return 2.0 * four - one, 2.0 * (four - one)


# ---------------------------------------------------------------------------- share of the pixels


@pytest.mark.parametrize("doubt", [0.25, 0.025, 0.0005])
@pytest.mark.parametrize("error", [0.02, 0.06, 0.1, 0.25])
def test_the_share_is_students_and_its_margin_the_binomial_one(error, doubt):
    """All pixels equally noisy: SE^2 = 4/3 step^2 / 4 with 3 + 5 degrees of freedom."""
    means, counts = stepping(np.full((16, 24), 2.0), np.full((16, 24), 0.2))
    share, margin = parts_of_share(means, counts, error, doubt)
    standard_error = 0.2 / math.sqrt(3.0) / 2.0
    expected = 1.0 - 2.0 * stats.t.sf(error / standard_error, 8)
    assert share == pytest.approx(expected, rel=1e-6)
    # Pixels are independent, their channels are not.
    normal = stats.norm.isf(doubt) * math.sqrt(expected * (1.0 - expected) / (16 * 24))
    assert margin == pytest.approx(normal, rel=1e-3, abs=1e-9)


def test_units_do_not_matter_and_samples_count_by_their_root():
    rng = np.random.default_rng(1)
    means = 1.0 + 0.2 * rng.standard_normal((16, 16, 4, 3))
    counts = np.full((16, 16, 4), 4)

    def found(means, counts, error):
        return share_within(means, counts, error, 0.025)

    share = found(means, counts, 0.1)
    assert found(2.0 * means, counts, 0.1) == pytest.approx(share, rel=1e-9)
    assert found(means[..., ::-1], counts, 0.1) == pytest.approx(share, rel=1e-9)
    assert found(means[:, :, ::-1], counts, 0.1) == pytest.approx(share, rel=1e-9)
    turned = found(means.transpose(1, 0, 2, 3), counts, 0.1)
    assert turned == pytest.approx(share, rel=1e-9)
    # Half the deviations are within half the error.
    mean = means.mean(axis=2, keepdims=True)
    calmer = found(mean + 0.5 * (means - mean), counts, 0.05)
    assert calmer == pytest.approx(share, rel=1e-9)
    # A sample counts the same in every replicate, however many there are.
    assert found(means, 7 * counts, 0.1) == pytest.approx(share, rel=1e-9)


def test_a_pixel_has_its_own_spread_as_3_of_8_and_that_of_its_cell_as_5():
    """In the first cell half of the pixels are quiet; the second cell is quiet altogether."""
    step = np.zeros((8, 16))
    step[::2, :8] = 0.2
    means, counts = stepping(np.ones((8, 16)), step)
    share, _ = parts_of_share(means, counts, 0.08)
    variance = 0.04 / 3.0
    inside = [
        1.0 - 2.0 * stats.t.sf(0.08 / math.sqrt(part * variance), 8)
        for part in ((3.0 + 5.0 * 0.5) / 8.0, 5.0 * 0.5 / 8.0)
    ]
    assert share == pytest.approx(0.25 * sum(inside) + 0.5, rel=1e-6)


def test_dark_pixels_are_allowed_a_tenth_of_the_mean():
    """Half of the picture at 0.01, of mean about 1: its error is one over 0.1."""
    mean = np.where(np.arange(16) < 8, 0.01, 1.99)[None, :] * np.ones((8, 1))
    means, counts = stepping(mean, np.full((8, 16), 0.03))
    share, _ = parts_of_share(means, counts, 0.15)
    inside = [
        1.0 - 2.0 * stats.t.sf(0.15 * scale / (0.03 / math.sqrt(3.0)), 8) for scale in (0.1, 1.99)
    ]
    assert share == pytest.approx(np.mean(inside), rel=1e-6)


def test_replicates_count_by_their_samples():
    rng = np.random.default_rng(2)
    means = 1.0 + 0.1 * rng.standard_normal((8, 8, 4, 3))
    counts = rng.integers(1, 9, (8, 8, 4))
    n = counts.sum(axis=2)[..., None]
    mean = (means * counts[..., None]).sum(axis=2) / n
    squares = (counts[..., None] * (means - mean[:, :, None]) ** 2).sum(axis=2) / 3.0 / n
    relative = squares / np.maximum(mean, 0.1 * mean.mean()) ** 2
    joined = (3.0 * relative + 5.0 * relative.mean(axis=(0, 1))) / 8.0
    expected = (1.0 - 2.0 * stats.t.sf(0.08 / np.sqrt(joined), 8)).mean()
    assert parts_of_share(means, counts, 0.08)[0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("replicates", [2, 4, 8])
def test_the_lower_bound_is_below_the_share_that_is_expected_and_no_farther_than_it_must_be(
    replicates,
):
    """Grey noise of known size: the bound is on the safe side, by the margin and some percent."""
    rng, bounds = np.random.default_rng(3), []
    error, sigma, doubt = 0.1, 0.1, 0.005
    expected = 1.0 - 2.0 * stats.norm.sf(error / sigma)
    for _ in range(60):
        noise = sigma * math.sqrt(replicates) * rng.standard_normal((24, 24, replicates, 1))
        means = 1.0 + noise * np.ones(3)
        bounds.append(share_within(means, np.full(means.shape[:3], 4), error, doubt))
    assert sum(bound <= expected for bound in bounds) >= 58
    margin = stats.norm.isf(doubt) * math.sqrt(expected * (1.0 - expected)) / 24
    assert expected - margin - 0.06 < np.mean(bounds) < expected - 0.7 * margin


def test_a_noiseless_picture_is_within_every_error():
    means, counts = stepping(np.ones((9, 11)), np.zeros((9, 11)))
    assert share_within(means, counts, 1e-6, 1e-6) == 1.0


# ---------------------------------------------------------------------------- unseen light


def plain_unseen(means, counts, error, largest):
    """The definition, cell by cell."""
    height, width = counts.shape[:2]
    n = counts.sum(axis=2)
    mean = (means * counts[..., None]).sum(axis=2) / n[..., None]
    epsilon = (0.1 * mean.mean()) ** 2
    sums = dict.fromkeys(("seen", "possible", "doubtful"), 0.0)
    for y in range(0, height, 8):
        for x in range(0, width, 8):
            cell = slice(y, y + 8), slice(x, x + 8)
            others = (n[cell][..., None] - counts[cell])[..., None]
            # What a replicate's sum has more than the others say.
            rest = (
                mean[cell][:, :, None] * n[cell][..., None, None]
                - means[cell] * counts[cell][..., None]
            ) / others
            excess = np.maximum((means[cell] - rest) * counts[cell][..., None], 0.0)
            share = n[cell].size / n.size
            scale = mean[cell].mean(axis=(0, 1)) ** 2 + epsilon
            seen, possible = (
                (((3.0 * brightest / n[cell].sum()) ** 2) / scale).mean()
                for brightest in (excess.max(axis=(0, 1, 2)), largest)
            )
            sums["seen"] += share * seen
            sums["possible"] += share * possible
            sums["doubtful"] += share * (min(seen, possible) > error**2)
    return Unseen(math.sqrt(sums["seen"]), math.sqrt(sums["possible"]), sums["doubtful"])


def spiky(rng, height, width):
    means = rng.gamma(0.5, size=(height, width, 4, 3)) * np.array([1.0, 0.5, 0.2])
    return means * (1.0 + np.arange(width)[:, None, None] / width), rng.integers(
        1, 9, (height, width, 4)
    )


@pytest.mark.parametrize("size", [(16, 16), (20, 37), (5, 8)])
def test_unseen_light_is_its_definition_also_in_cells_that_are_cut(size):
    means, counts = spiky(np.random.default_rng(4), *size)
    for largest in (2.0, 20.0, 60.0):
        for error in (0.03, 0.1, 0.3):
            found = unseen_error(means, counts, error, largest)
            expected = plain_unseen(means, counts, error, largest)
            assert found == pytest.approx(expected, rel=1e-4)
            assert found.figure == min(found.indicator, found.bound)
    unknown = unseen_error(means, counts, 0.05)
    assert math.isnan(unknown.bound)
    assert unknown.figure == unknown.indicator == pytest.approx(expected.indicator, rel=1e-4)
    assert unknown.doubtful == pytest.approx(
        plain_unseen(means, counts, 0.05, 1e9).doubtful, rel=1e-6
    )


def test_units_order_and_samples_of_unseen_light():
    means, counts = spiky(np.random.default_rng(5), 24, 16)
    one = unseen_error(means, counts, 0.1, 30.0)
    same = [
        unseen_error(8.0 * means, counts, 0.1, 240.0),
        unseen_error(means[..., ::-1], counts, 0.1, 30.0),
        unseen_error(means[:, :, [2, 0, 3, 1]], counts[:, :, [2, 0, 3, 1]], 0.1, 30.0),
        unseen_error(means.transpose(1, 0, 2, 3), counts.transpose(1, 0, 2), 0.1, 30.0),
        unseen_error(np.tile(means, (2, 2, 1, 1)), np.tile(counts, (2, 2, 1)), 0.1, 30.0),
    ]
    for other in same:
        assert other == pytest.approx(one, rel=1e-5)
    # The bound falls with the samples, not with their root.
    assert unseen_error(means, 4 * counts, 0.1, 30.0).bound == pytest.approx(one.bound / 4.0)


def test_three_over_n_is_the_rule_for_95_percent():
    """An event of probability 3 / N is missed by N samples in one case of twenty."""
    means, counts = np.ones((8, 8, 4, 3)), np.full((8, 8, 4), 16)
    samples, brightest = counts.sum(), 50.0
    bound = unseen_error(means, counts, 0.1, brightest).bound * math.sqrt(1.01)
    probability = bound / brightest
    assert (1.0 - probability) ** samples == pytest.approx(0.05, abs=0.001)


def test_cells_at_the_edge_are_smaller():
    plane = np.random.default_rng(6).random((19, 10))
    sums = cell_sum(plane)
    expected = [[plane[y : y + 8, x : x + 8].sum() for x in (0, 8)] for y in (0, 8, 16)]
    assert sums == pytest.approx(np.array(expected))
    spread = spread_over_pixels(sums, 19, 10)
    assert all(spread[y, x] == sums[y // 8, x // 8] for y in range(19) for x in range(10))


# ---------------------------------------------------------------------------- promises and looks


@pytest.mark.parametrize(
    ("pixels", "renders"), [(1, 200_000), (2, 6_000), (3, 5_000), (5, 4_000), (20, 1_000)]
)
def test_looks_without_end_are_wrong_no_more_often_than_one_promises(pixels, renders):
    """Renders by sums of normal noise, whose relMSE over the estimate is F(pixels, 3 pixels)."""
    rng, spp = np.random.default_rng(3), [first_look(4)]
    while spp[-1] < 16_000:
        spp.append(next_look(spp[-1], 4))
    # Between two looks anywhere, the true error is on average the one that is asked for.
    oracle = np.exp(rng.uniform(math.log(256.0), math.log(512.0), renders))
    middle = stats.f.ppf(stats.norm.cdf([-1.0, 1.0]), pixels, 3 * pixels)
    deviation = 0.25 * math.log(middle[1] / middle[0])
    confidences, held = (0.5, 0.8, 0.95, 0.99, 0.999), 0
    sums = np.zeros((renders, pixels, 4))
    bounds = [
        stats.f.isf(look_doubt(1.0 - confidence, deviation), pixels, 3 * pixels)
        for confidence in confidences
    ]
    ended, wrong = np.zeros((2, len(confidences), renders), bool)
    for n in spp:
        sums += rng.standard_normal(sums.shape) * math.sqrt(n - held)
        held = n
        # Replicates hold n / 4 samples, of variance 1 each: relMSE times the oracle's samples.
        scale = 4.0 * oracle / n**2
        true = (sums.mean(axis=2) ** 2).mean(axis=1) * scale
        estimate = sums.var(axis=2, ddof=1).mean(axis=1) / 4.0 * scale
        for i, bound in enumerate(bounds):
            met = ~ended[i] & (estimate * bound <= 1.0)
            ended[i] |= met
            wrong[i] |= met & (true > 1.0)
    for i, confidence in enumerate(confidences):
        broken, doubt = int(wrong[i].sum()), 1.0 - confidence
        assert broken <= stats.binom.isf(1e-4, renders, doubt)
        # And not so rarely that samples are wasted.
        assert broken >= stats.binom.ppf(1e-4, renders, 0.4 * doubt)


@pytest.mark.parametrize("doubt", [0.5, 0.05, 0.001])
def test_a_look_may_be_as_wrong_as_the_promise_unless_errors_deviate(doubt):
    for deviation in (0.0, 0.1, WHOLE_DOUBT):
        assert look_doubt(doubt, deviation) == doubt
    for deviation in (0.5, 1.07, 5.0, 150.0):
        wanted = doubt * (WHOLE_DOUBT / deviation) ** 1.25
        assert look_doubt(doubt, deviation) == pytest.approx(wanted)


@pytest.mark.parametrize("confidence", [0.5, 0.8, 0.95, 0.999])
def test_a_share_of_the_pixels_is_promised_with_the_confidence_that_is_asked_for(confidence):
    """Pictures that fall short of the share at the look at which they end.

    Pixels differ in their noise, and its sums are skewed: few bright samples, many dark ones.
    """
    rng, pictures, short = np.random.default_rng(11), 400, 0
    promise = Promise(0.25, confidence, metric="pixel", share=0.9)
    for _ in range(pictures):
        sigma = np.exp(0.7 * rng.standard_normal((8, 16, 1, 1)))
        sums, done, spp, share = 0.0, 0, first_look(4), 0.0
        while share < promise.share:
            k = 0.1 * (spp - done) / 4
            noise = (rng.gamma(k, size=(8, 16, 4, 1)) - k) / math.sqrt(0.1) * np.ones(3)
            sums, done, spp = sums + sigma * noise, spp, next_look(spp, 4)
            counts = np.full((8, 16, 4), done // 4)
            means = 1.0 + sums / counts[..., None]
            share = share_within(means, counts, promise.error, 0.5 * promise.doubt)
        short += (np.abs(means.mean(axis=2) - 1.0) <= promise.error).mean() < promise.share
    # So many, were the promise false, only once in a million.
    assert short <= stats.binom.isf(1e-6, pictures, 1.0 - confidence)
    assert judge_means(means, counts, promise).share == share


def test_a_look_at_one_noisy_pixel_asks_for_more():
    """Its relRMSE deviates by the root of F(1, 3): by more than the whole doubt is enough for."""
    means = np.ones((8, 8, 4, 3), np.float32)
    means[3, 4] += np.float32([0.1, -0.1, 0.02, -0.06])[:, None]
    counts, promise = np.full((8, 8, 4), 4), Promise(0.5)
    estimate = estimate_relmse(means, counts)
    middle = stats.f.ppf(stats.norm.cdf([-1.0, 1.0]), 1.0, 3.0)
    deviation = 0.25 * math.log(middle[1] / middle[0])
    assert deviation > 0.9
    assert estimate.figure.deviation == pytest.approx(deviation, rel=0.05)
    achieved = judge_means(means, counts, promise).achieved
    assert achieved > 1.02 * estimate.relrmse_below(1.0 - promise.doubt)


def test_the_ranges_of_a_promise():
    for right in (
        {"error": 1e-6}, {"error": 10.0}, {"error": 0.1, "share": 0.5},
        {"error": 1, "confidence": 0.5},
        {"error": 0.1, "confidence": 0.99999, "metric": "pixel"},
    ):  # fmt: skip
        assert Promise(**Promise(**right).state()) == Promise(**right)
    for wrong in (
        {"error": math.nan}, {"error": -0.1}, {"error": 10.01}, {"error": 0.1, "share": 0.49},
        {"error": 0.1, "confidence": 0.49}, {"error": 0.1, "confidence": 1.0},
    ):  # fmt: skip
        with pytest.raises(OptionError):
            Promise(**wrong)


@pytest.mark.parametrize("replicates", [1, 2, 3, 4, 5, 8, 9, 16, 32])
def test_looks_are_even_numbers_of_points_in_every_replicate(replicates):
    """Quarters of a power of two of them, from one to the next; two rounds at least."""
    spp = first_look(replicates)
    # A replicate of one sample has no spread of its own.
    assert spp >= max(16, 2 * replicates)
    assert spp - replicates < 16 or spp == 2 * replicates
    looks = [spp]
    while looks[-1] < 2**20:
        looks.append(next_look(looks[-1], replicates))
    points = np.array(looks) // replicates
    assert (points * replicates == looks).all()
    quarters = {k * 2**e for k in (4, 5, 6, 7) for e in range(30)} | {2, 3}
    assert set(points[1:].tolist()) == {n for n in quarters if points[0] < n <= points[-1]}
    assert points[-1] / points[-5] == pytest.approx(GROWTH**4)
    # From anywhere to the next of them.
    assert next_look(replicates * 37, replicates) == replicates * 40


@pytest.mark.parametrize("metric", ["relrmse", "pixel"])
@pytest.mark.parametrize("counts", [[0, 0, 0, 0], [4, 4, 4, 0], [0, 0, 0, 4]])
def test_with_an_empty_replicate_nothing_is_known(metric, counts):
    """No number, no verdict in favour, and no number of samples that would do."""
    counts = np.broadcast_to(counts, (8, 8, 4))
    found = judge_means(np.ones((8, 8, 4, 3)), counts, Promise(10.0, metric=metric), 1.0)
    unknown = ("achieved", "share", "unseen", "bound", "value")
    assert all(math.isnan(getattr(found, name)) for name in unknown)
    assert (found.within, found.met, found.doubted) == (False, False, False)
    assert (found.doubtful, found.factor) == (1.0, math.inf)


@pytest.mark.parametrize("step", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("error", [0.003, 0.02, 0.3])
def test_samples_that_are_missing_go_with_the_square_of_the_error(step, error):
    """But with what may be unseen itself, where that is more; none are where a promise is met."""
    means, counts = stepping(np.full((16, 16), 2.0), np.full((16, 16), step))
    for largest, by_chance in ((None, False), (3.0, False), (300.0, False), (3.0, True)):
        found = judge_means(means, counts, Promise(error), largest, by_chance)
        if found.met:
            assert found.factor == 1.0
        else:
            noise, unseen = (found.achieved / error) ** 2, found.unseen / error
            assert found.factor == pytest.approx(max(noise, unseen, 1.0))
            assert found.achieved > error or found.unseen > error


def known(estimate, *_, literature):
    """Without the figure of the literature, which no look uses."""
    assert not literature
    return estimate


@pytest.mark.parametrize("doubt", ["brightness", "rise"])
def test_a_promise_is_doubted_where_the_brightness_of_noisy_pixels_alone_stands_in_its_way(
    monkeypatch, doubt
):
    means, counts = stepping(np.ones((8, 8)), np.full((8, 8), 0.1))
    for value, doubted in ((0.01, True), (0.03, False)):
        figure = Figure(value**2, 1e6, 4)._replace(**{doubt: 4.0})
        estimate = ErrorEstimate(figure, figure, 0.01, 1.0)
        monkeypatch.setattr(stopping, "estimate_relmse", partial(known, estimate))
        found = judge_means(means, counts, Promise(0.02))
        assert found.achieved > 0.02
        assert found.doubted == doubted
