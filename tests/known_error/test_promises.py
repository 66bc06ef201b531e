"""The promise of an error is kept, steering is unbiased, and rare light is not passed over."""

from __future__ import annotations

import math

import numpy as np
import pytest

from alight.core.errors import OptionError
from alight.films import Film, PartialFilm
from alight.films.fixed_point import to_limbs
from alight.films.sample_ranges import empty_cells
from alight.metrics.own_error import estimate_relmse
from alight.rendering.plan import PilotSchedule, plan_of
from alight.rendering.schedules.adaptive import LEAST, MOST, counts_at, shares_of
from alight.rendering.schedules.cycles import Cycles, cycles_error, first_decision, in_noise
from alight.rendering.schedules.schedule import Goal, Verdict
from alight.rendering.schedules.steering import Steered
from alight.rendering.schedules.stopping import (
    WHOLE_DOUBT,
    Promise,
    first_look,
    judge,
    judge_means,
    line_of,
    next_look,
    share_within,
    word_of,
)
from alight.rendering.schedules.unseen import unseen_error


def noisy(rng, spp, sigma=1.0, size=32):
    """Replicate means of a grey picture whose samples have the relative deviation `sigma`."""
    truth = np.linspace(0.2, 1.0, size)[None, :, None, None] * np.ones((size, 1, 1, 3))
    noise = rng.normal(0.0, sigma / math.sqrt(spp / 4), (size, size, 4, 1))
    means = truth * (1.0 + noise)
    return truth[:, :, 0], means, np.full((size, size, 4), spp // 4)


def true_error(truth, means):
    scale = truth**2 + (0.1 * truth.mean()) ** 2
    return math.sqrt((((means.mean(axis=2) - truth) ** 2) / scale).mean())


def test_the_interval_covers_and_is_no_wider_than_it_must_be():
    rng, z = np.random.default_rng(1), []
    for _ in range(60):
        truth, means, counts = noisy(rng, 100)
        relative = estimate_relmse(means.astype(np.float32), counts).relrmse
        width = math.log(relative.high / relative.low) / 3.92
        z.append(math.log(relative.value / true_error(np.broadcast_to(truth, means.mean(2).shape),
                                                     means)) / width)  # fmt: skip
    # The deviation of 60 standard normal numbers is 1 within 0.28 (3 sigma), their mean 0.39.
    assert np.std(z) == pytest.approx(0.95, abs=0.28)
    assert abs(np.mean(z)) < 0.39


def test_a_promise_is_kept_and_not_paid_twice():
    rng, kept, ratios = np.random.default_rng(2), 0, []
    for _ in range(12):
        asked = float(rng.uniform(0.08, 0.12))
        spp, done, sums = first_look(4), 0, 0.0
        while True:
            truth, means, counts = noisy(rng, spp - done)
            # Sums of independent parts, as a film's.
            sums, done = sums + means * (spp - done), spp
            judgement = judge_means((sums / spp).astype(np.float32), 0 * counts + spp // 4,
                                    Promise(asked))  # fmt: skip
            if judgement.met:
                break
            spp = next_look(spp, 4)
        truth = np.broadcast_to(truth, means.mean(2).shape)
        kept += true_error(truth, sums / spp) <= asked
        ratios.append(spp / (1.0 / asked**2))
    assert kept >= 11
    # Half a look on average, and the price of being sure.
    assert 1.0 < np.mean(ratios) < 1.5


def test_a_look_asks_for_the_error_that_is_not_exceeded():
    _, means, counts = noisy(np.random.default_rng(7), 100)
    means = means.astype(np.float32)
    estimate = estimate_relmse(means, counts)
    for confidence in (0.5, 0.95, 0.999):
        judgement = judge_means(means, counts, Promise(0.1, confidence))
        # Many pixels carry the error: all looks together are wrong no more often than one may be.
        assert estimate.figure.deviation < WHOLE_DOUBT
        below = estimate.relrmse_below(confidence)
        assert judgement.achieved == pytest.approx(below, rel=1e-9)
        assert estimate.relrmse.value < judgement.achieved


def test_where_samples_have_both_signs_a_dip_tells_as_much_as_a_spike():
    """A replicate of 1 - 99 / 4 says that a sample of about -98 has been."""
    counts = np.full((64, 64, 4), 4)
    figures = []
    for sign in (1.0, -1.0):
        means = np.ones((64, 64, 4, 3))
        means[20, 20, 1] += sign * 99.0 / 4
        figures.append(unseen_error(means, counts, 0.02).indicator)
    # The brightness of the cell is 1 + 99 / 1024 and 1 - 99 / 1024, epsilon 0.01 of it.
    assert figures[1] / figures[0] == pytest.approx((1 + 99 / 1024) / (1 - 99 / 1024), rel=0.01)
    # A replicate that is dark, and not negative, lacks what the others have met: no sample does.
    means = np.ones((64, 64, 4, 3))
    means[20, 20, 1] = 0.0
    assert unseen_error(means, counts, 0.02).indicator < 3 * 2 / 1024 / 8


def test_one_spike_makes_a_noiseless_picture_uncertain():
    means = np.ones((64, 64, 4, 3))
    counts = np.full((64, 64, 4), 4)
    assert unseen_error(means, counts, 0.02).figure == 0.0
    # One sample of 100 in one pixel: 3 * 99 / (64 * 16) of light may be missing in its cell.
    means[20, 20, 1] += 99.0 / 4
    unseen = unseen_error(means, counts, 0.02)
    cell = 1.0 + 99 / 16 / 64
    assert unseen.indicator == pytest.approx(3 * 99 / 1024 / cell / 8, rel=0.01)
    assert unseen.doubtful == 1 / 64
    assert math.isnan(unseen.bound)
    # No sample above 5: 15 / 1024 in every cell of brightness 1 is the bound.
    assert unseen_error(0 * means + 1, counts, 0.02, 5.0).bound == pytest.approx(
        15 / 1024 / math.sqrt(1.01)
    )
    judgement = judge_means(means.astype(np.float32), counts, Promise(0.03))
    assert not judgement.met
    # All pixels but one are within the error, and still something may be hidden.
    judgement = judge_means(means.astype(np.float32), counts, Promise(0.03, metric="pixel"))
    assert judgement.within
    assert not judgement.met


@pytest.mark.parametrize("error", [0.05, 0.1, 0.2])
def test_the_share_of_pixels_is_that_of_normal_noise(error):
    truth, means, counts = noisy(np.random.default_rng(3), 100, size=128)
    inside = (np.abs(means.mean(axis=2) - truth) <= error * truth).mean()
    # Student's distribution for the doubt about each variance: a little on the safe side.
    assert inside - 0.055 <= share_within(means, counts, error, 0.005) <= inside


class Pixels:
    """What steering reads of a film."""

    def __init__(self, means, counts):
        h, w = counts.shape[:2]
        self.crop, self.cells, self.replicates = (0, 0, w, h), empty_cells(w, h), counts.shape[2]
        self.means, self.counts, self.aov_channels = means, counts, {}
        self.largest_sample, self.by_chance, self.rare_light = None, False, None
        self.spp = float(counts.sum(axis=2).mean())

    def replicate_means(self):
        return self.means, self.counts

    @property
    def sample_count(self):
        return self.counts.sum(axis=2)


def test_samples_go_where_the_noise_is():
    rng = np.random.default_rng(4)
    sigma = np.where(np.arange(64) < 32, 0.1, 0.4)[None, :, None, None]
    means = 1.0 + rng.normal(0.0, 1.0, (64, 64, 4, 1)) * sigma * np.ones(3)
    shares = shares_of(Pixels(means, np.full((64, 64, 4), 2)))
    assert shares.mean() == pytest.approx(1.0, rel=0.02)
    assert shares[:, 5:].mean() / shares[:, :3].mean() == pytest.approx(4.0, rel=0.15)
    assert shares.min() >= LEAST * 0.999
    assert shares.max() <= MOST * 1.001


def test_counts_are_whole_rounds_and_only_grow():
    shares = np.array([[0.0, 0.2, 1.0, 3.3]])
    before = counts_at(shares, 8, 4)
    for spp in range(12, 200, 4):
        now = counts_at(shares, spp, 4)
        assert (now >= before).all()
        assert (now % 4 == 0).all()
        assert now[0, 0] == 0
        before = now


def test_a_steered_render_asks_for_pilot_and_picture_in_different_films():
    schedule = Steered(64, 32, None, adaptive=True)
    film = Pixels(np.ones((16, 16, 4, 3)), np.zeros((16, 16, 4), int))
    pilot = schedule.next([film])
    assert isinstance(pilot, Goal)
    # Its own film, hence random numbers of its own: else it would choose by what it then counts.
    assert pilot.round == 1
    seen = Pixels(np.ones((16, 16, 4, 3)), np.full((16, 16, 4), 2))
    goal = schedule.next([film, seen])
    assert isinstance(goal, Goal)
    assert goal.round == 0
    assert (goal.first == 64).all()
    again = Steered.restored(schedule.state())
    assert again.state().keys() == schedule.state().keys()
    assert again.next([film, seen]) == Verdict("done")


def test_a_promise_ends_with_one_of_three_words():
    flat = Pixels(np.ones((16, 16, 4, 3), np.float32), np.full((16, 16, 4), 4))
    schedule = Steered(0, 32, Promise(0.02))
    assert isinstance(schedule.next([flat]), Goal)
    assert schedule.next([flat]).word == "met"
    rng = np.random.default_rng(5)
    rough = Pixels((1 + rng.normal(0, 0.5, (16, 16, 4, 3))).astype(np.float32), flat.counts)
    schedule = Steered(0, 16, Promise(0.02))
    schedule.next([rough])
    verdict = schedule.next([rough])
    assert verdict.word == "not met"
    assert "more are needed" in verdict.line
    black = Pixels(np.zeros((16, 16, 4, 3), np.float32), flat.counts)
    schedule = Steered(0, 16, Promise(0.02))
    schedule.next([black])
    assert schedule.next([black]).word == "not certifiable"


def spiked(rng, spikes):
    """A dim picture whose noise comes from a few pixels, each with one bright sample."""
    means = 1.0 + 0.01 * rng.normal(size=(32, 32, 4, 1)) * np.ones(3)
    for y, x, r in zip(*rng.integers(0, (32, 32, 4), (spikes, 3)).T, strict=True):
        means[y, x, r] += 12.0
    return means.astype(np.float32), np.full((32, 32, 4), 16)


def test_an_error_that_hangs_on_unknown_brightness_is_not_certifiable():
    means, counts = spiked(np.random.default_rng(8), 4)
    figure = estimate_relmse(means, counts).figure
    error = math.sqrt(figure._replace(brightness=0.0).quantile(0.99))
    assert error < 0.9 * math.sqrt(figure.quantile(0.99))
    judgement = judge_means(means, counts, Promise(error))
    assert judgement.doubted
    assert not judgement.within
    assert word_of(judgement) == "not certifiable"
    line = line_of("not certifiable", judgement, Promise(error), 64)
    assert "too little is known of the brightness" in line
    # With the same noise everywhere it is only not met.
    _, means, counts = noisy(np.random.default_rng(9), 64)
    figure = estimate_relmse(means.astype(np.float32), counts).figure
    asked = Promise(0.9 * math.sqrt(figure.value))
    judgement = judge_means(means.astype(np.float32), counts, asked)
    assert not judgement.doubted
    assert word_of(judgement) == "not met"


def test_no_absurd_number_is_told():
    _, means, counts = noisy(np.random.default_rng(10), 64)
    judgement = judge_means(means.astype(np.float32), counts, Promise(0.02))
    for achieved, factor in ((9.9, 3e5), (11.0, math.inf), (math.inf, math.inf)):
        line = line_of(
            "not met", judgement._replace(achieved=achieved, factor=factor), Promise(0.15), 64
        )
        assert "e+" not in line
        assert "inf" not in line
        bounded = achieved < 10.0
        assert ("without a useful bound" in line) != bounded
        assert ("far more samples" in line) == bounded
        assert ("is unknown" in line) != bounded
    for factor, more in ((1.2, "12.8"), (3.0, "128"), (9000.0, "576,000")):
        told = judgement._replace(achieved=0.5, factor=factor)
        assert line_of("not met", told, Promise(0.15), 64) == (
            f"not met: relRMSE at most 50 %, asked 15 %; about {more} spp more are needed"
        )


def test_cycles_rule_is_its_formula():
    means = np.array([0.3, 0.5, 0.3, 0.5])[None, None, :, None] * np.ones((1, 1, 4, 3))
    counts = np.full((1, 1, 4), 3)
    # All samples 0.4, every second one 0.3; the sum of the channels is above 1.
    assert cycles_error(means, counts)[0, 0] == pytest.approx(0.3 / 1.2, rel=1e-3)
    assert cycles_error(0.1 * means, counts)[0, 0] == pytest.approx(
        0.03 / math.sqrt(0.12), rel=1e-3
    )


@pytest.mark.parametrize(
    ("threshold", "samples"), [(0.1, 48), (0.111, 48), (0.01, 80), (0.001, 144), (1, 32)]
)
def test_cycles_decides_first_where_cycles_does(threshold, samples):
    # By its integrator: ceil(16 / threshold^0.3) is 32, 31, 64, 128, 16; the last sample has an
    # index above that, and 15 more than a multiple of 16.
    assert first_decision(threshold) == samples


def test_cycles_lets_the_eight_pixels_around_go_on():
    error = np.zeros((6, 6))
    error[2, 3] = 0.05
    expected = np.zeros((6, 6), bool)
    expected[1:4, 2:5] = True
    active = np.ones((6, 6), bool)
    # Five times the threshold.
    assert (in_noise(error, 0.01, active) == expected).all()
    assert not in_noise(error, 0.0101, active).any()
    # A pixel that was finished is not looked at again.
    assert not in_noise(error, 0.01, ~expected).any()


def test_cycles_stops_cells_that_look_finished():
    schedule = Cycles(0, 128, 0.01)
    rng = np.random.default_rng(6)
    means = np.ones((40, 16, 4, 3))
    means[:8] += rng.normal(0.0, 0.1, (8, 16, 4, 3))
    film = Pixels(means, np.full((40, 16, 4), 20))
    assert (schedule.next([film]).count == 80).all()
    # The noisy cells, and those whose pixels touch them.
    assert schedule.next([film]).count[:, 0].tolist() == [96, 96, 80, 80, 80]
    means[:8], means[15] = 1.0, rng.normal(1.0, 0.1, (16, 4, 3))
    goal = Cycles.restored(schedule.state()).next([film])
    # The first ones have ended; the third starts again, and will not catch up.
    assert goal.count[:, 0].tolist() == [96, 112, 96, 80, 80]


@pytest.mark.parametrize("replicates", [1, 2, 3])
def test_no_error_is_promised_without_an_interval(replicates):
    film = Pixels(np.ones((8, 8, replicates, 3)), np.full((8, 8, replicates), 16))
    said = ""
    try:
        Steered(0, 64, Promise(0.5)).next([film])
    except OptionError as error:
        said = str(error)
    assert said == f"replicates: an error can be promised from 4 replicates on, got {replicates}"
    judgement = judge_means(film.means, film.counts, Promise(0.5))
    assert not judgement.met
    assert math.isnan(judgement.achieved)
    # Without a promise there is nothing to ask for.
    assert isinstance(Steered(0, 64, None).next([film]), Goal)


def test_cycles_needs_two_halves():
    film = Pixels(np.ones((8, 8, 3, 3)), np.full((8, 8, 3), 20))
    with pytest.raises(OptionError, match="even number of replicates, got 3"):
        Cycles(0, 128, 0.01).next([film])


def test_a_plan_follows_the_slope_of_the_pilot():
    seen = [(16, 0.03, 0.0016), (32, 0.03, 0.0008), (64, 0.03, 0.0004)]
    pilot = PilotSchedule(Promise(0.01), seen=seen,
                  passes=[0.2, 0.1, 0.2], looks=[0.03, 0.02, 0.02], need=4.2)  # fmt: skip
    plan = plan_of(pilot, 4)
    assert plan.slope.value == pytest.approx(-1.0)
    assert plan.spp.low <= 4.0 * 64 <= plan.spp.high
    assert plan.spp.high / plan.spp.low < 2.5
    # A start of 0.1 s, 6.25 ms for a sample per pixel, and 18 looks.
    looks = 1
    spp = first_look(4)
    while spp < plan.spp.value:
        looks, spp = looks + 1, next_look(spp, 4)
    assert looks == 18
    expected = 0.1 + plan.spp.value * 0.00625 + looks * 0.02
    assert plan.seconds.value == pytest.approx(expected)
    assert plan.seconds.low < expected / 1.25
    assert plan.seconds.high > expected * 1.25


def test_a_plan_doubts_its_seconds_as_much_as_the_pilots_passes_differ():
    seen = [(16, 0.03, 0.0016), (32, 0.03, 0.0008), (64, 0.03, 0.0004)]
    steady, restless = (
        plan_of(PilotSchedule(Promise(0.01), seen, [0.1, second, 0.2], [0.01] * 3, 4.2), 4).seconds
        for second in (0.1, 0.2)
    )
    assert steady.high / steady.low < 5.0
    assert restless.high / restless.low > 2.0 * steady.high / steady.low


@pytest.mark.parametrize("wrong", [{"error": 0.0}, {"error": 11.0}, {"error": 0.1, "share": 1.0},
                                   {"error": 0.1, "metric": "psnr"}])  # fmt: skip
def test_promises_that_cannot_be_are_refused(wrong):
    with pytest.raises(OptionError, match=r"error|share|metric"):
        Promise(**wrong)


def test_only_a_look_that_was_planned_says_met():
    """A clock ends where it likes: were it believed, it could wait for a lucky moment."""
    film = Film(16, 16, replicates=4)
    rng, count = np.random.default_rng(3), 18
    counts = np.array([5, 5, 4, 4]) * np.ones((16, 16, 1), np.int64)
    values = counts[..., None] * rng.normal(1.0, 0.01, (16, 16, 4, 3))
    sums, _, _ = to_limbs(values.astype(np.float32))
    film.add_tile(PartialFilm(0, 0, sums, counts, 0, 0, (0, count), {}))
    schedule = Steered(0, None, Promise(0.5))
    schedule.now = 20
    assert judge(film, schedule.promise).met
    verdict = schedule.cut_short([film], "time")
    assert verdict.word == "not met" and not verdict.figures["met"]
    assert "ended before the look at 20 spp" in verdict.line
