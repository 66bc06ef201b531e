"""Laws of plans and of the series beyond a depth cap: power laws, units, coverage on both sides."""

import json
import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from alight.metrics.own_error import estimate_relmse
from alight.rendering.depth_cap import _series
from alight.rendering.plan import PilotSchedule, _look_after, _times, plan_of
from alight.rendering.schedules.rare_noise import RareNoise
from alight.rendering.schedules.stopping import (
    GROWTH,
    Promise,
    first_look,
    judge_means,
    next_look,
)


def pilot_of(slope=1.0, error=0.01, need=None, spread=0.03, relmse=4e-4, **changes):
    """A pilot whose relMSE falls as a power of the samples, exactly."""
    seen = [(spp, spread, relmse * (64 / spp) ** slope) for spp in (16, 32, 64)]
    pilot = PilotSchedule(Promise(error), seen, [0.2, 0.1, 0.2], [0.03, 0.02, 0.02])
    pilot.need = relmse / error**2 if need is None else need
    return replace(pilot, **changes)


def looks_up_to(spp, replicates=4):
    looks = [first_look(replicates)]
    while looks[-1] < spp:
        looks.append(next_look(looks[-1], replicates))
    return looks


@pytest.mark.parametrize("slope", [0.9, 1.0, 1.4, 2.0])
def test_samples_follow_the_power_law(slope):
    for times in (1.5, 4.0, 30.0):
        plan = plan_of(pilot_of(slope, need=times, spread=0.0), 4)
        needed = 64.0 * times ** (1.0 / slope)
        # Half a step between looks is lost on average.
        expected = max(needed * math.sqrt(GROWTH), plan.spp.low)
        assert plan.spp.value == pytest.approx(expected, rel=1e-9)
        assert plan.spp.low < 1.25 * needed + 4
        assert plan.spp.high >= needed
        assert plan.slope.value == pytest.approx(-slope)
        assert plan.slope.low <= plan.slope.value <= plan.slope.high
        assert (plan.pilot_error, plan.pilot_spp) == (pytest.approx(0.02), 64)


def test_the_interval_of_the_slope_is_its_noise_and_a_doubt_of_8_percent():
    for spread in (0.0, 0.05, 0.2):
        plan = plan_of(pilot_of(1.45, spread=spread), 4)
        width = 1.96 * math.hypot(math.sqrt(2.0) * spread / math.log(4.0), 0.08)
        assert plan.slope.low == pytest.approx(-1.45 - width)
        assert plan.slope.high == pytest.approx(-1.45 + width)


@pytest.mark.parametrize(("slope", "shown"), [(0.3, 0.9), (0.85, 0.9), (2.6, 2.0)])
def test_slopes_that_cannot_be_are_cut(slope, shown):
    plan = plan_of(pilot_of(slope, spread=0.0), 4)
    assert plan.slope.value == -shown
    assert -2.0 <= plan.slope.low <= plan.slope.value <= plan.slope.high <= -0.9


def test_intervals_of_slopes_cover_as_often_as_they_say():
    """The pilot's errors vary by what it says, and the slope beyond it by the doubt."""
    rng, misses, trials = np.random.default_rng(1), np.zeros(2), 2000
    for _ in range(trials):
        errors = zip((16, 32, 64), 0.06 * rng.standard_normal(3), strict=True)
        seen = [(spp, 0.06, spp**-1.45 * math.exp(e)) for spp, e in errors]
        found, true = plan_of(pilot_of(seen=seen), 4).slope, 1.45 + 0.08 * rng.standard_normal()
        misses += [-true < found.low, -true > found.high]
    for missed in misses:
        assert abs(missed - 0.025 * trials) < 4.0 * math.sqrt(0.025 * trials)


def test_ends_of_the_interval_are_looks_that_leave_room_for_the_rules_noise():
    for times in (2.0, 7.0, 50.0):
        pilot = pilot_of(1.3, need=times)
        plan = plan_of(pilot, 4)
        ends = [64.0 * times ** (1.0 / -s) for s in (plan.slope.low, plan.slope.high)]
        looks = looks_up_to(10 * max(ends))
        assert plan.spp.low == next(look for look in looks if look >= 0.94 * min(ends))
        last = next(i for i, look in enumerate(looks) if look >= 1.06 * max(ends))
        assert plan.spp.high == looks[last + 1]


@pytest.mark.parametrize("slope", [0.9, 1.5, 2.0])
def test_rare_light_is_noise_of_independent_samples(slope):
    """Of which no sample, few or many tell."""
    for known, met, told in ((1.0, 0.0, 0.09), (0.5, 0.04, 0.06), (0.0, 0.04, 0.04)):
        rare = RareNoise(0.09, 0.09 * known, 0.09 * known)
        plan = plan_of(pilot_of(slope, 0.05, need=1e-9, relmse=1e-9, rare=rare, met=met), 4)
        needed = 64.0 * told * 1.2**2 / 0.05**2
        assert plan.spp.value == pytest.approx(needed * math.sqrt(GROWTH), rel=1e-3)
        # 95 % of what the pilot and the samples know.
        doubt = math.exp(1.96 * math.sqrt(known / 16))
        assert plan.spp.low == _look_after(0.94 * needed / doubt, 4)
        assert plan.spp.high >= 1.06 * needed * doubt
        assert plan.pilot_error == pytest.approx(math.sqrt(1e-9 + met))


def test_two_kinds_of_noise_are_the_error_together():
    for slope in (0.9, 1.2, 2.0):
        for noise, need in ((2e-4, 16.0), (2e-9, 1e4), (2e-4, 1e9), (0.0, 1.1), (0.9, 1e3)):
            pilot = pilot_of(slope, 0.005, need=need, rare=RareNoise(noise, noise, noise))
            times = _times(pilot, slope)
            rare = noise * 1.2**2 / 0.005**2
            assert need * times**-slope + rare / times == pytest.approx(1.0, rel=1e-9)


def test_plans_for_pixels_have_the_margin_of_normal_noise():
    rare, promise = RareNoise(0.09, 0.09, 0.09), Promise(0.05, metric="pixel", share=0.95)
    pilot = pilot_of(need=1e-9, relmse=1e-9, rare=rare, promise=promise)
    assert _times(pilot, 1.0) == pytest.approx(0.09 * 1.96**2 / 0.05**2, rel=1e-3)


def test_a_pilot_without_an_error_that_has_met_no_rare_light_needs_more_than_one_look():
    plan = plan_of(pilot_of(relmse=0.0, need=1.0, rare=RareNoise(0.01, 0.01, 0.01)), 4)
    assert plan.spp.value > 64.0 * 0.01 / 0.01**2


def one_bright_sample(size):
    """A smooth picture with a single sample of that size, at 64 spp."""
    means = 1.0 + 0.1 * np.random.default_rng(5).standard_normal((24, 24, 4, 3))
    means[11, 5, 2] += size / 16.0
    return means.astype(np.float32), np.full((24, 24, 4), 16)


@pytest.mark.parametrize("size", [3.0, 30.0, 1e3, 1e5, 1e8])
def test_samples_are_told_where_the_error_has_a_bound_of_use(size):
    judgement = judge_means(*one_bright_sample(size), Promise(0.05))
    assert math.isfinite(judgement.factor) == (judgement.achieved <= 10.0)
    assert math.isfinite(judgement.factor) == (size < 1e4)


@pytest.mark.parametrize("noise", [0.0, 0.09])
@pytest.mark.parametrize("by_chance", [False, True])
@pytest.mark.parametrize("relmse", [0.0, 0.2, 3e4])
def test_a_plan_without_an_end_says_so_and_names_no_more_than_what_is_known(
    noise, by_chance, relmse
):
    rare = RareNoise(noise, noise, noise)
    pilot = pilot_of(error=0.05, relmse=relmse, need=math.inf, rare=rare, by_chance=by_chance)
    plan = plan_of(pilot, 4)
    assert math.isnan(plan.spp.value)
    assert plan.spp.high == plan.seconds.high == math.inf
    known = replace(pilot, need=max(relmse / 0.05**2, 1e-6))
    if relmse + noise > 0.0:
        assert plan.spp.low == plan_of(known, 4).spp.low
    found = json.loads(json.dumps(plan.to_dict(), allow_nan=False))
    assert found["spp"] == {"value": None, "low": plan.spp.low, "high": None}
    assert ("chance" in found["doubt"]) == by_chance
    assert str(plan).splitlines()[1:] == [
        f"samples: at least {plan.spp.low:.0f} per pixel; no upper limit is known",
        f"processor time: at least {plan.seconds.low:.3g} s",
        f"why: {plan.doubt}",
        f"what helps: {plan.remedy}",
    ]


def test_the_plan_is_what_the_rule_takes_within_a_factor_of_two():
    """A picture of numbers, a third of it by samples that one in 36 pixels has met at 64 spp."""
    rate, size, asked = 4.5e-4, 1.1e3, Promise(0.15)
    points = np.arange(256)
    light = np.full((256, 3), rate * size)
    rows = np.column_stack([points, points % 4, light, np.full((256, 2), rate)])

    def samples(seed):
        """Means and counts after as many samples as are sent."""
        rng, sums, spp = np.random.default_rng(seed), np.zeros((16, 16, 4)), 0
        means = counts = None
        while True:
            more = ((yield means, counts) - spp) // 4
            noise = more + 0.3 * math.sqrt(more) * rng.standard_normal(sums.shape)
            sums, spp = sums + noise + size * rng.binomial(more, rate, sums.shape), spp + 4 * more
            means = np.repeat(4.0 / spp * sums[..., None], 3, axis=3).astype(np.float32)
            counts = np.full(sums.shape, spp // 4)

    picture, spp = samples(1), 4096
    next(picture)
    while not judge_means(*picture.send(spp), asked, behind=rows).met:
        spp = next_look(spp, 4)
    for seed in range(2, 6):
        picture, pilot = samples(seed), pilot_of(promise=asked, seen=[])
        next(picture)
        for count in (16, 64):
            means, counts = picture.send(count)
            film = SimpleNamespace(
                replicate_means=lambda found=(means, counts): found,
                relmse_estimate=lambda literature, found=(means, counts): estimate_relmse(*found),
                rare_light=rows, largest_sample=None, by_chance=False,
            )  # fmt: skip
            pilot.seen.append((count, 0.05, pilot._look(film).value))
        assert 0.5 < plan_of(pilot, 4).spp.value / spp < 2.0


def test_a_look_takes_the_time_of_what_the_rule_does(monkeypatch):
    """The pilot's own estimate is no part of it."""
    means, counts = np.ones((8, 8, 4, 3), np.float32), np.full((8, 8, 4), 16)
    clock = [0.0]

    def takes(seconds, what):
        clock[0] += seconds
        return what

    film = SimpleNamespace(
        replicate_means=lambda: takes(1.0, (means, counts)),
        relmse_estimate=lambda literature: takes(100.0, estimate_relmse(means, counts)),
        rare_light=None, largest_sample=None, by_chance=False,
    )  # fmt: skip
    monkeypatch.setattr("alight.rendering.plan.time.process_time", lambda: clock[0])
    pilot = pilot_of(looks=[])
    pilot._look(film)
    assert pilot.looks == [1.0]


@pytest.mark.parametrize("replicates", [1, 4, 6])
def test_a_look_is_the_first_one_at_or_after_so_many_samples(replicates):
    looks = looks_up_to(5000, replicates)
    for before, look in pairwise(looks):
        assert _look_after(look, replicates) == look
        assert _look_after(before + 0.5, replicates) == look
        assert _look_after(look - 0.5, replicates) == look


def test_a_promise_that_is_kept_already_needs_fewer_samples_than_the_pilot():
    plan = plan_of(pilot_of(1.2, error=0.04, need=1.0), 4)
    # relMSE of a quarter: 64 times (1/4)^(1/1.2).
    assert plan.spp.value == pytest.approx(64.0 * 4.0 ** (-1.0 / 1.2) * math.sqrt(GROWTH), rel=1e-9)
    assert plan.spp.low <= plan.spp.value <= plan.spp.high
    # A steeper slope leads to more samples on the way back.
    steeper = plan_of(pilot_of(1.8, error=0.04, need=1.0), 4)
    assert steeper.spp.value > plan.spp.value


def test_a_pilot_without_an_error_needs_one_look():
    plan = plan_of(pilot_of(relmse=0.0, need=1.0), 8)
    assert plan.spp == (16.0, 16.0, 16.0)
    assert plan.pilot_error == 0.0
    assert plan.seconds.low < plan.seconds.value < plan.seconds.high


def test_seconds_are_a_start_the_samples_and_the_looks():
    pilot = pilot_of(need=20.0, passes=[0.5, 0.16, 0.32], looks=[0.9, 0.03, 0.02])
    plan = plan_of(pilot, 4)
    rate = (0.16 + 0.32) / 48

    def until(spp):
        # The middle one of the pilot's looks; the first of them had to be compiled.
        return 0.5 - 16 * rate + spp * rate + 0.03 * len(looks_up_to(spp))

    assert plan.seconds.value == pytest.approx(until(plan.spp.value))
    # Both later passes took 10 ms a sample: a doubt of 25 % is left.
    assert plan.seconds.low == pytest.approx(until(plan.spp.low) / math.exp(0.25))
    assert plan.seconds.high == pytest.approx(until(plan.spp.high) * math.exp(0.25))
    slower = replace(pilot, passes=[3.0 * t for t in pilot.passes],
                     looks=[3.0 * t for t in pilot.looks])  # fmt: skip
    assert plan_of(slower, 4).seconds == pytest.approx([3.0 * v for v in plan.seconds])
    # A pass that took twice as long doubts the rate as much.
    uneven = plan_of(replace(pilot, passes=[0.5, 0.32, 0.32]), 4)
    doubt = math.exp(math.hypot(0.25, math.log(2.0)))
    rate = 0.64 / 48
    assert uneven.seconds.high == pytest.approx(
        (0.5 - 16 * rate + uneven.spp.high * rate + 0.03 * len(looks_up_to(uneven.spp.high)))
        * doubt
    )


# ---------------------------------------------------------------------------- depth caps


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 0.9])
def test_a_geometric_series_is_summed_and_its_slope_is_the_difference_quotient(ratio):
    """Light of depth d is ratio^d: the halves of 8 edges each, and all that follows."""
    q = ratio ** (1.0 / 8.0) if ratio else 0.0
    a = sum(q**d for d in range(8))
    b = sum(q**d for d in range(8, 16))
    value, slope = _series(np.array([a, b]))
    assert value == pytest.approx(1.0 / (1.0 - q) if q else 1.0)
    step = 1e-6
    for i in range(2):
        ahead = np.array([a, b]) + step * np.eye(2)[i]
        assert (_series(ahead)[0] - value) / step == pytest.approx(slope[i], rel=1e-4, abs=1e-5)
    # Radiance is linear.
    twice, same = _series(np.array([2.0 * a, 2.0 * b]))
    assert twice == pytest.approx(2.0 * value)
    assert same == pytest.approx(slope)


def test_what_roulette_ends_is_all_that_is_missing():
    value, slope = _series(np.array([0.7]))
    assert (value, slope.tolist()) == (pytest.approx(0.7), [1.0])
    assert _series(np.array([0.0, 0.0]))[0] == 0.0
    for endless in ([0.5, 0.5], [0.2, 0.5], [0.5, -0.1]):
        assert _series(np.array(endless))[0] == math.inf


def test_the_time_on_the_clock_is_shared_among_threads():
    plan = plan_of(pilot_of(need=4.0), 4)
    for threads in (1, 8):
        (time,) = [text for name, text in replace(plan, threads=threads)._lines() if "time" in name]
        seconds = float(time.rpartition("about ")[2].removesuffix(" s"))
        assert seconds == pytest.approx(plan.seconds.value / threads, rel=1e-2)
