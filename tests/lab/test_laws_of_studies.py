"""What a study claims about its arms, from replicates whose truth is known; nothing is rendered."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from alight.lab.arm_plan import Plan
from alight.lab.evaluate import Measured, _bias_tests, evaluate_arms
from alight.lab.references import Reference
from alight.lab.results import BIASED, DIFFERENT, ReferenceInfo
from alight.lab.run import relmse_after, relmse_gains, variance_ratios
from alight.lab.statistics.block_means import LEVEL, block_row, exact_statistics
from alight.lab.statistics.decomposition import Moments
from alight.lab.statistics.intervals import log_mean, log_ratio
from alight.lab.store import Example, Replicate
from alight.lab.study import ArmSpec, SceneSpec, Study, StudyError
from alight.metrics.estimate import Estimate

SIZE = 8
LADDER = (4, 16)


class Truth:
    """Replicates as a store gives them, of arms with given noise, bias and time."""

    def __init__(self, seed, arms, count=16, noise=0.0, own=False, paired=False, ladder=LADDER):
        self.ladder = ladder
        self.rng, self.count, self.kept, self.plans = np.random.default_rng(seed), count, {}, []
        self.picture = 0.5 + self.rng.random((SIZE, SIZE, 3))
        common = self._reference(noise)
        specs = []
        for name, (sigma, seconds, options) in arms.items():
            reference = self._reference(noise * sigma / arms["base"][0]) if own else common
            specs.append(ArmSpec(name, **options))
            arm = SimpleNamespace(
                spec=specs[-1], size=(SIZE, SIZE), key=name, compile_seconds=1.0, load_seconds=2.0
            )
            self.plans.append(Plan(arm, name, ladder, (), reference, own))
            self._render(name, sigma, seconds, reference)
        scene = SceneSpec("cornell-box")
        self.study = Study("truth", specs, [scene], baseline="base", paired=paired)

    def _reference(self, sigma):
        variance = np.full(self.picture.shape, sigma**2)
        noise = sigma * self.rng.standard_normal((SIZE, SIZE, 1))
        image = (self.picture + noise).astype(np.float32)
        info = ReferenceInfo("rendered", "base", 256, 0.01, False, 0.0, "key")
        return Reference(image, variance, exact_statistics(image, variance), 1e9, info)

    def _render(self, name, sigma, seconds, reference):
        rows, moments, example = [], {spp: Moments() for spp in self.ladder}, None
        for number in range(self.count):
            rungs = {}
            for spp in self.ladder:
                scale = sigma * math.sqrt(LADDER[-1] / spp)
                noise = scale * self.rng.standard_normal((SIZE, SIZE, 1))
                picture = (self.picture + noise).astype(np.float32)
                moments[spp].add(picture.astype(np.float64))
                squared = (picture - reference.image) ** 2
                error = float(squared.mean() - reference.variance.mean())
                rungs[spp] = {
                    "mse": error, "relmse": 2.0 * error, "relmse_literature": 3.0 * error,
                    "smape": 0.1 + number, "flip": None if number % 2 else 0.2 + number,
                    "seconds": seconds * spp**0.5 * (1.0 + 0.01 * self.rng.standard_normal()),
                }  # fmt: skip
            rows.append(Replicate(number, number, 1, rungs, block_row(picture)))
            example = example or Example(16, 0.5, picture)
        self.kept[name] = rows, moments, example

    def replicates(self, key):
        return iter(self.kept[key][0])

    def moments(self, key, spp):
        return self.kept[key][1].get(spp)

    def example(self, key):
        return self.kept[key][2]

    def values(self, key, name, spp=LADDER[-1]):
        return np.array([row.rungs[spp][name] for row in self.kept[key][0]], float)

    def cost(self, key):
        return log_mean(self.values(key, "mse")) + log_mean(self.values(key, "seconds"))

    def results(self):
        found = evaluate_arms(
            self.study, "scenes[0]", "base", self.plans, self, self.count, reference_is_named=True
        )
        return {arm.name: arm for arm in found}


def logs(estimate):
    return [math.log(value) for value in estimate]


@pytest.mark.parametrize("own", [False, True])
def test_the_noise_of_references_is_in_the_speedup(own):
    """A reference's noise is shared by all replicates: no replicate's spread tells of it."""
    arms = {"base": (0.2, 1.0, {}), "quiet": (0.1, 1.0, {}), "same": (0.2, 1.0, {})}
    truth = Truth(1, arms, noise=0.09 if own else 0.045, own=own)
    found = truth.results()
    for name in ("quiet", "same"):
        both = [plan for plan in truth.plans if plan.key in ("base", name)]
        inverse = [1.0 / truth.values(plan.key, "mse").mean() for plan in both]
        # What is left of the squared noise of a pixel has the variance 2 sigma^4.
        spread = [2.0 * plan.reference.noise**2 / SIZE**2 for plan in both]
        if own:
            extra = spread[0] * inverse[0] ** 2 + spread[1] * inverse[1] ** 2
        else:
            extra = spread[0] * (inverse[0] - inverse[1]) ** 2
        expected = log_ratio(truth.cost("base"), truth.cost(name), extra_variance=extra)
        assert logs(found[name].speedup.ratio) == pytest.approx(logs(expected.estimate), rel=1e-5)
        assert found[name].speedup.p_value == pytest.approx(expected.p_value, rel=1e-4)
        bare = log_ratio(truth.cost("base"), truth.cost(name)).estimate
        widths = [logs(one)[2] - logs(one)[1] for one in (found[name].speedup.ratio, bare)]
        if own or name == "quiet":
            assert widths[0] > 1.03 * widths[1]
        else:
            # Of arms that are equally noisy it cancels.
            assert widths[0] == pytest.approx(widths[1], rel=0.05)


def test_speedups_cover_though_the_references_are_noisy():
    """Own references with a fifth of an arm's noise: without it some 70 % would cover."""
    held, trials = 0, 24
    for seed in range(trials):
        arms = {"base": (0.2, 1.0, {}), "quiet": (0.1, 2.0, {})}
        truth = Truth(seed, arms, count=48, noise=0.2 * math.sqrt(0.2), own=True, ladder=(16,))
        # Four times less error in twice the time.
        ratio = truth.results()["quiet"].speedup.ratio
        held += ratio.low <= 2.0 <= ratio.high
    # Four standard errors below 95 %.
    assert held >= 19


def test_speedups_have_their_side_their_pairs_and_their_family():
    arms = {"base": (0.2, 1.0, {}), "fast": (0.2, 0.5, {}), "twin": (0.2, 1.0, {})}
    for paired in (False, True):
        truth = Truth(3, arms, paired=paired)
        found = truth.results()
        assert found["base"].speedup is None
        fast, twin = found["fast"].speedup, found["twin"].speedup
        assert fast.ratio.low < 2.0 < fast.ratio.high
        assert fast.ratio.low > 1.3
        expected = log_ratio(truth.cost("base"), truth.cost("fast"), paired=paired)
        assert fast.ratio == pytest.approx(expected.estimate, rel=1e-6)
        # The bootstrap has the same side, and about the same width.
        assert fast.bootstrap.value == pytest.approx(fast.ratio.value)
        low, high = fast.bootstrap[1:]
        ratio = math.log(high / low) / math.log(fast.ratio.high / fast.ratio.low)
        assert 0.75 < ratio < 1.3
        smaller, larger = sorted([fast, twin], key=lambda one: one.p_value)
        assert smaller.p_adjusted == pytest.approx(2.0 * smaller.p_value)
        assert larger.p_adjusted == max(larger.p_value, smaller.p_adjusted)


def test_the_bootstrap_of_paired_arms_draws_pairs():
    """The twin has the base's replicates but for 1 %: paired, the interval is narrow."""
    widths = []
    for paired in (False, True):
        truth = Truth(4, {"base": (0.2, 1.0, {}), "twin": (0.2, 1.0, {})}, paired=paired)
        rows, moments, example = truth.kept["base"]
        truth.kept["twin"] = ([
            Replicate(row.number, row.seed, 0, {
                spp: {**one, "mse": one["mse"] * (1.0 + 0.01 * math.cos(row.number))}
                for spp, one in row.rungs.items()
            }, row.blocks) for row in rows
        ], moments, example)  # fmt: skip
        found = truth.results()["twin"].speedup
        widths.append([math.log(one.high / one.low) for one in (found.ratio, found.bootstrap)])
    assert widths[1][0] < 0.3 * widths[0][0]
    assert widths[1][1] < 0.3 * widths[0][1]


def test_every_figure_has_its_own_place_and_unit():
    truth = Truth(5, {"base": (0.2, 3.0, {"expected_slope": -0.5})}, count=12, noise=0.06)
    base = truth.results()["base"]
    assert [point.spp for point in base.samples] == list(LADDER)
    figures = ("mse", "relmse", "relmse_literature", "smape", "seconds", "flip")
    for point in base.samples:
        of = {name: truth.values("base", name, point.spp) for name in figures}
        for name, values in of.items():
            mean = np.nanmean(values)
            found = point.seconds if name == "seconds" else point.errors[name]
            assert found.value == pytest.approx(mean), name
        low, high = stats.t.interval(0.95, 11, of["smape"].mean(), stats.sem(of["smape"]))
        assert point.errors["smape"][1:] == pytest.approx((low, high))
        assert point.bias2.value + point.variance.value == pytest.approx(point.mse.value)
        # The bias does not depend on the samples: that of the deepest pictures.
        moments, reference = truth.moments("base", LADDER[-1]), truth.plans[0].reference
        squared = (moments.mean - reference.image) ** 2 - moments.variance / 12
        assert point.bias2.value == pytest.approx(float(squared.mean()) - 0.06**2, rel=1e-4)
        # Errors of both parts add up as squares.
        for i in (1, 2):
            sides = [abs(one[i] - one.value) for one in (point.mse, point.bias2, point.variance)]
            assert sides[2] == pytest.approx(math.hypot(sides[0], sides[1]), rel=1e-6)
        assert point.bias2.low < 0.0 < point.bias2.high
        expected = 0.04 * LADDER[-1] / point.spp
        assert point.variance.low < expected < point.variance.high
    cost = truth.cost("base").interval()
    assert base.efficiency == pytest.approx([math.exp(-cost[i]) for i in (0, 2, 1)])
    # 3 s times root 16 for 64 pixels of 16 samples, in microseconds.
    assert base.microseconds_per_sample.value == pytest.approx(12e6 / 1024, rel=0.02)
    # The error falls as the root of the samples, the time grows as their root.
    assert base.slope_spp.low < -0.5 < base.slope_spp.high
    assert base.slope_spp.value == pytest.approx(-0.5, abs=0.15)
    assert base.slope_time.value == pytest.approx(2.0 * base.slope_spp.value, rel=0.05)
    reference = truth.plans[0].reference.image
    assert base.images.error == pytest.approx(base.images.mean - reference)
    assert np.abs(base.images.error).mean() > 0.01
    assert base.images.count.shape == reference.shape[:2]
    assert np.all(base.images.count == base.images.example_spp)
    assert (base.invalid, base.replicates, base.expected_slope) == (12, 12, -0.5)


def test_an_arm_that_is_declared_different_is_called_so():
    arms = {"base": (0.1, 1.0, {}), "other": (0.1, 1.0, {"declares_different": True})}
    truth = Truth(6, arms, noise=0.02)
    rows, moments, example = truth.kept["other"]
    brighter = [
        Replicate(row.number, row.seed, 0, row.rungs, row.blocks * 1.2 + 0.05) for row in rows
    ]
    truth.kept["other"] = brighter, moments, example
    assert truth.results()["other"].bias.verdict == DIFFERENT


@pytest.mark.parametrize(("count", "seen"), [(2, 1), (3, 2), (4, 2)])
def test_a_figure_that_two_replicates_have_has_an_interval(count, seen):
    """FLIP is kept of every second one."""
    (point, _) = Truth(8, {"base": (0.2, 1.0, {})}, count=count).results()["base"].samples
    if seen < 2:
        assert point.errors["flip"] is None
    else:
        values = 0.2 + 2.0 * np.arange(seen)
        half = stats.t.ppf(0.975, seen - 1) * stats.sem(values)
        mean = values.mean()
        assert point.errors["flip"] == pytest.approx((mean, mean - half, mean + half))


def test_verdicts_are_what_the_p_values_say_at_the_level():
    """Of arms with and without a vote, whose p-values are all corrected for both tests."""
    arms = {name: (0.2, 1.0, {}) for name in ("base", "b", "c")}
    arms["other"] = (0.2, 1.0, {"declares_different": True})
    below = {True: 0, False: 0}
    for seed in range(100):
        truth = Truth(seed, arms, noise=0.02, ladder=(16,))
        measured = {plan.key: Measured.of(truth.replicates(plan.key), plan) for plan in truth.plans}
        for plan, test in zip(truth.plans, _bias_tests(truth.plans, measured, True), strict=True):
            assert (test.verdict == (BIASED if plan.votes else DIFFERENT)) == (test.p_value < LEVEL)
            below[plan.votes] += test.p_value < 1.0
    # Some of each would be named at a level that is no level.
    assert min(below.values()) > 3


def test_a_reference_that_drowns_the_quietest_arm_is_refused():
    arms = {"base": (0.3, 1.0, {}), "quiet": (0.1, 1.0, {})}
    assert set(Truth(7, arms, noise=0.04).results()) == set(arms)
    with pytest.raises(StudyError, match='"quiet"'):
        Truth(7, arms, noise=0.1).results()


# ---------------------------------------------------------------------------- tables


def arm_of(name, variance, is_baseline=False):
    point = SimpleNamespace(variance=Estimate(*variance))
    return SimpleNamespace(name=name, label=name, is_baseline=is_baseline, samples=[point])


def test_ratios_of_variances_are_over_the_baselines_with_both_errors():
    base, arm = arm_of("base", (2.0, 1.8, 2.4), True), arm_of("arm", (6.0, 5.4, 7.2))
    scene = SimpleNamespace(name="s", label="s", arms=[base, arm])
    (table,) = variance_ratios([scene], {"s": {"arm": 3.0}})
    ((_, _, interval, expected),) = table.rows
    assert expected == 3.0
    # The ratio is low where the arm's variance is low (10 %) and the baseline's high (20 %).
    assert interval == pytest.approx(
        [3.0, 3.0 * (1.0 - math.hypot(0.1, 0.2)), 3.0 * (1.0 + math.hypot(0.2, 0.1))]
    )
    swapped = arm_of("base", (2.0, 1.98, 2.02), True)
    scene = SimpleNamespace(name="s", label="s", arms=[swapped, arm])
    ((_, _, interval, _),) = variance_ratios([scene], {"s": {"arm": 3.0}})[0].rows
    assert interval[1] == pytest.approx(3.0 * (1.0 - math.hypot(0.1, 0.01)))
    assert interval[2] == pytest.approx(3.0 * (1.0 + math.hypot(0.2, 0.01)))
    assert variance_ratios([scene], {}) == []


def arm(name, before, each, error, **said):
    """An arm that is trained first: seconds before and for each sample, and relMSE of one."""
    samples = [
        SimpleNamespace(
            spp=n,
            seconds=Estimate(before + n * each, 0.0, 0.0),
            relmse=Estimate(error / n, 0.9 * error / n, 1.1 * error / n),
        )
        for n in (5, 10)
    ]
    said = {"is_baseline": False, "declares_different": False, **said}
    return SimpleNamespace(label=name, samples=samples, **said)


@pytest.mark.parametrize(
    ("base", "other", "cells"),
    [
        ((200.0, 1.0), (0.0, 1.0), ["not reached", 100.0, "not reached"]),
        ((0.0, 1.0), (200.0, 1.0), [100.0, "not reached", "not reached"]),
        ((1.0, 0.0), (0.0, 1.0), ["not measured", 100.0, "not measured"]),
        ((0.0, 1.0), (50.0, -1.0), [100.0, "not measured", "not measured"]),
    ],
)
def test_arms_without_a_sample_by_then_or_without_a_clock_have_no_number(base, other, cells):
    arms = [arm("plain", *base, 1.0, is_baseline=True), arm("other", *other, 1.0)]
    rows = relmse_after([SimpleNamespace(label="s", arms=arms)], 100.0).rows
    assert [rows[0][3], rows[1][3], rows[1][4]] == cells


def test_what_is_trained_first_repays_it_in_longer_renders():
    """In 100 s: 20 s and 2 s a sample against 1 s a sample with three times the error."""
    arms = [
        arm("plain", 0.0, 1.0, 9.0, is_baseline=True),
        arm("trained", 20.0, 2.0, 3.0),
        arm("other", 0.0, 1.0, 1.0, declares_different=True),
    ]
    base, trained = relmse_after([SimpleNamespace(label="s", arms=arms)], 100.0).rows
    assert base[:4] == ["s", "plain", 0.0, pytest.approx(100.0)]
    assert trained[2:4] == pytest.approx([20.0, 40.0])
    width = (1.1 / 0.9) ** (0.5 * 2**0.5)
    assert trained[4] == pytest.approx([1.2, 1.2 / width, 1.2 * width])


def test_gains_of_an_arm_over_itself_are_one():
    point = SimpleNamespace(relmse=Estimate(2.0, 1.0, 4.0), seconds=Estimate(1.0, 0.9, 1.1))
    bias = SimpleNamespace(difference=[Estimate(0.0, -0.01, 0.01)] * 3)
    arms = [
        SimpleNamespace(label=name, is_baseline=name == "a", samples=[point], times=[], bias=bias)
        for name in "ab"
    ]
    (row,) = relmse_gains([SimpleNamespace(label="s", arms=arms)]).rows
    same, at_time, change = row[2:]
    # Twice the squared width of two equal estimates: 2 and 1/2 to the power of root 2.
    assert same == pytest.approx([1.0, 2.0 ** -(2**0.5), 2.0 ** (2**0.5)])
    assert at_time[0] == 1.0
    assert at_time[2] > same[2]
    assert change == pytest.approx([0.0, -1.0, 1.0])
