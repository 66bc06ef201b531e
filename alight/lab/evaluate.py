"""From stored replicates to what is claimed: points, speed-ups, slopes, tests of bias."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from alight.lab.arm_plan import Plan
from alight.lab.arms import seed_of
from alight.lab.references import Reference, demand_quiet
from alight.lab.results import UNKNOWN, ArmImages, ArmResult, BiasTest, Point, Speedup
from alight.lab.statistics.agreement import MOST_VOTERS, Vote, vote
from alight.lab.statistics.block_means import (
    LEVEL,
    BlockMoments,
    RawTest,
    compare_with_reference,
    judge,
)
from alight.lab.statistics.decomposition import Moments, Parts, decompose, reference_spread
from alight.lab.statistics.equal_time import AtTime, Bracket, compared, product
from alight.lab.statistics.intervals import (
    bootstrap_ratio,
    exponential,
    holm_adjusted,
    log_ratio,
    log_slope,
    mean_interval,
    positive_interval,
)
from alight.lab.store import Replicate, Store
from alight.lab.study import Study, StudyError
from alight.metrics import JUDGED, Estimate
from alight.metrics.model import METRICS


@dataclass(frozen=True)
class Measured:
    """All figures of an arm as arrays.

    Attributes
    ----------
    figures : dict of int to dict of str to ndarray of float64, shape (S,)
        By spp, then by name.
    blocks : BlockMoments
    seeds : list of int
    invalid : int
    """

    figures: dict[int, dict[str, np.ndarray]]
    blocks: BlockMoments
    seeds: list[int]
    invalid: int

    @classmethod
    def of(cls, replicates: Iterable[Replicate], plan: Plan) -> Measured:
        """Gather what the store holds."""
        rows: list[Replicate] = []

        def noted():
            for one in replicates:
                # Only the numbers stay: the blocks are few.
                rows.append(Replicate(one.number, one.seed, one.invalid, one.rungs, np.zeros(0)))
                yield one.blocks

        blocks = BlockMoments.calm(noted(), plan.arm.size)
        figures = {
            spp: {
                name: np.array([_number(row.rungs[spp][name]) for row in rows])
                for name in rows[0].rungs[spp]
            }
            for spp in plan.ladder
        }
        seeds, invalid = [row.seed for row in rows], sum(row.invalid for row in rows)
        return cls(figures, blocks, seeds, invalid)

    def clock(self, spp: int) -> np.ndarray:
        """Seconds of the replicates up to a step."""
        return self.figures[spp]["seconds"]

    def at(self, where: Bracket, seconds: float) -> AtTime:
        """The errors in a time."""
        return AtTime.of(self.figures, where, seconds)


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def evaluate_arms(
    study: Study,
    scene_path: str,
    baseline: str,
    plans: Sequence[Plan],
    store: Store,
    count: int,
    reference_is_named: bool,
) -> list[ArmResult]:
    """Everything about the arms of a scene.

    Parameters
    ----------
    study : Study
    scene_path : str
        Key of the scene in the study file, for messages.
    baseline : str
        Name of an arm.
    plans : sequence of Plan
    store : Store
        With at least `count` replicates of each.
    count : int
        S.
    reference_is_named : bool
        Whether the study says what the reference is: then arms are judged by it, not by a vote.

    Raises
    ------
    StudyError
        If an arm has no noise, or a reference has too much.
    """
    measured = {
        plan.arm.spec.name: Measured.of(islice(store.replicates(plan.key), count), plan)
        for plan in plans
    }
    moments = {
        plan.arm.spec.name: {spp: store.moments(plan.key, spp) or Moments() for spp in plan.tops}
        for plan in plans
    }
    _check(study, scene_path, plans, measured, moments)
    speedups = _speedups(study, baseline, plans, measured)
    by_vote = not reference_is_named and sum(plan.votes for plan in plans) <= MOST_VOTERS
    tests = _bias_tests(plans, measured, by_vote)
    # Times are those of the baseline at its steps of equal samples.
    base = next(plan for plan in plans if plan.arm.spec.name == baseline)
    clocks = [measured[baseline].clock(spp) for spp in base.samples]
    return [
        _arm_result(plan, measured[plan.arm.spec.name], moments[plan.arm.spec.name], clocks,
                    speedups.get(plan.arm.spec.name), test, baseline, store)
        for plan, test in zip(plans, tests, strict=True)
    ]  # fmt: skip


def _check(
    study: Study,
    scene_path: str,
    plans: Sequence[Plan],
    measured: Mapping[str, Measured],
    moments: Mapping[str, Mapping[int, Moments]],
) -> None:
    """Refuse what has no noise, and references with too much of it."""
    for plan in plans:
        name = plan.arm.spec.name
        if float(moments[name][plan.shown].variance.max()) == 0.0:
            raise no_noise(study, name)
    for reference in {id(plan.reference): plan.reference for plan in plans}.values():
        errors = {}
        for plan in plans:
            if plan.reference is reference:
                name = plan.arm.spec.name
                errors[name] = float(measured[name].figures[plan.shown][JUDGED].mean())
        name = min(errors, key=lambda name: errors[name])
        demand_quiet(study, f"{scene_path}.reference", reference, name, errors[name])
    for plan in plans:
        name = plan.arm.spec.name
        if not all(measured[name].clock(spp).min() > 0.0 for spp in plan.ladder):
            message = "its time cannot be told from 0: render more samples, or larger pictures"
            raise study.fail(f"arms.{name}", message)
        try:
            for spp in (plan.judged.low, plan.judged.high):
                product([(measured[name].figures[spp][JUDGED], 1.0)])
        except ValueError:
            message = (
                "its error cannot be told from 0 in every replicate: render more replicates or "
                "fewer samples, or give a better reference"
            )
            raise study.fail(f"arms.{name}", message) from None


def no_noise(study: Study, arm: str) -> StudyError:
    """The error for an arm whose pictures are all the same."""
    return study.fail(
        f"arms.{arm}",
        "its pictures have no noise at all, every seed gives the same: there is nothing to compare",
    )


def _speedups(
    study: Study, baseline: str, plans: Sequence[Plan], measured: Mapping[str, Measured]
) -> dict[str, Speedup]:
    """Efficiency of every arm over the baseline's, corrected over the arms."""
    base = next(plan for plan in plans if plan.arm.spec.name == baseline)
    others = [plan for plan in plans if plan is not base]
    clock = measured[baseline].clock(base.samples[-1])
    base_at = measured[baseline].at(base.judged, float(clock.mean()))
    ratios, intervals = [], []
    for plan in others:
        at = measured[plan.arm.spec.name].at(plan.judged, float(clock.mean()))
        above, below = compared(base_at, clock, at)
        shared = _shared_noise(base.reference, base_at.sensitivity, plan.reference, at.sensitivity)
        ratios.append(
            log_ratio(product(above), product(below), paired=study.paired, extra_variance=shared)
        )
        (upper, upper_powers), (lower, lower_powers) = (
            zip(*side, strict=True) for side in (above, below)
        )
        intervals.append(
            bootstrap_ratio(
                upper, lower, seed_of("bootstrap", plan.key), paired=study.paired,
                powers=(upper_powers, lower_powers),
            )
        )  # fmt: skip
    adjusted = holm_adjusted([ratio.p_value for ratio in ratios])
    return {
        plan.arm.spec.name: Speedup(ratio.estimate, ratio.p_value, p, interval)
        for plan, ratio, p, interval in zip(others, ratios, adjusted, intervals, strict=True)
    }


def _shared_noise(a: Reference, effect_a: float, b: Reference, effect_b: float) -> float:
    """Variance of the log ratio from the noise of the references.

    Parameters
    ----------
    a, b : Reference
        Of both sides.
    effect_a, effect_b : float
        Relative change of each side when all its squared errors grow by 1.
    """
    spread_a = reference_spread(a.variance, a.seeds)
    if a is b:
        # The same error on both sides cancels where the arms are equally noisy.
        return spread_a * (effect_a - effect_b) ** 2
    return spread_a * effect_a**2 + reference_spread(b.variance, b.seeds) * effect_b**2


def _bias_tests(
    plans: Sequence[Plan], measured: Mapping[str, Measured], by_vote: bool
) -> list[BiasTest]:
    """What each arm is, at one family level over all arms of the scene."""
    raw: list[RawTest] = []
    for plan in plans:
        statistics = measured[plan.arm.spec.name].blocks.statistics
        raw.append(compare_with_reference(statistics, plan.reference.statistics))
    declared = [plan.arm.spec.declares_different for plan in plans]
    if not by_vote:
        return judge(raw, declared)
    voters = [i for i, plan in enumerate(plans) if plan.votes]
    others = [i for i, plan in enumerate(plans) if not plan.votes]
    # Those without a vote are judged by the reference, and take half of the level.
    share = 0.5 if others else 1.0
    outcome = _vote_of([plans[i] for i in voters], measured, share * LEVEL)
    tests = judge([raw[i] for i in others], [declared[i] for i in others], share * LEVEL)
    found = dict(zip(others, tests, strict=True))
    for i in voters:
        name = plans[i].arm.spec.name
        p, verdict = outcome.p_values[name], outcome.verdicts[name]
        found[i] = replace(raw[i].test, p_value=p, verdict=verdict)
    return [
        replace(found[i], p_value=min(1.0, found[i].p_value / share)) for i in range(len(plans))
    ]


def _vote_of(voters: Sequence[Plan], measured: Mapping[str, Measured], level: float) -> Vote:
    """The voters' comparison with each other."""
    statistics = {
        plan.arm.spec.name: measured[plan.arm.spec.name].blocks.statistics for plan in voters
    }
    references = {}
    for plan in voters:
        name = plan.arm.spec.name
        if plan.reference.info.arm == name:
            references[name] = plan.reference.statistics
    return vote(statistics, references, level)


def _arm_result(
    plan: Plan,
    measured: Measured,
    moments: Mapping[int, Moments],
    clocks: Sequence[np.ndarray],
    speedup: Speedup | None,
    test: BiasTest,
    baseline: str,
    store: Store,
) -> ArmResult:
    spec, reference = plan.arm.spec, plan.reference
    parts = {
        spp: decompose(one, reference.image, reference.variance) for spp, one in moments.items()
    }
    last = plan.ladder[-1]
    per_sample = 1e6 / (last * plan.arm.size[0] * plan.arm.size[1])
    seconds = positive_interval(measured.clock(last))
    single = [(measured.at(Bracket.at(spp), 0.0), measured.clock(spp)) for spp in plan.samples]
    times = []
    # There are none where the study has no equal times.
    for where, clock in zip(plan.times, clocks, strict=False):
        at = measured.at(where, float(clock.mean()))
        times.append((at, measured.clock(where.low) if at.is_single else clock))
    judged, _ = (times or single)[-1]
    return ArmResult(
        name=spec.name,
        label=spec.label or spec.name,
        options=dict(spec.options),
        is_baseline=spec.name == baseline,
        declares_different=spec.declares_different,
        replicates=len(measured.seeds),
        seeds=measured.seeds,
        samples=[_point(at, clock, parts) for at, clock in single],
        times=[_point(at, clock, parts) for at, clock in times],
        efficiency=_efficiency(judged),
        speedup=speedup,
        slope_spp=_slope(plan.samples, measured, against_time=False),
        slope_time=_slope(plan.samples, measured, against_time=True),
        expected_slope=spec.expected_slope,
        bias=test,
        microseconds_per_sample=Estimate(*(v * per_sample for v in seconds)),
        compile_seconds=plan.arm.compile_seconds,
        load_seconds=plan.arm.load_seconds,
        invalid=measured.invalid,
        own_reference=reference.info if plan.own_reference else None,
        images=_images(plan, moments[plan.shown], store),
    )


def _point(at: AtTime, clock: np.ndarray, parts: Mapping[int, Parts]) -> Point:
    """The errors in a time, whose interval comes from the times of some replicates."""
    errors = {name: _error(at, name) for name in METRICS if METRICS[name].IN_STUDIES}
    mse = errors[JUDGED] or UNKNOWN
    # The mean of a picture does not depend on the number of samples, nor does its bias: steps
    # whose pictures were not added up have that of the deepest one.
    bias2 = parts[at.spp if at.spp in parts else max(parts)].bias2
    variance = mse.value - bias2.value
    low, high = mse.value - mse.low, mse.high - mse.value
    width = bias2.high - bias2.value
    return Point(
        spp=at.spp,
        seconds=positive_interval(clock),
        errors=errors,
        bias2=bias2,
        variance=Estimate(
            variance, variance - math.hypot(low, width), variance + math.hypot(high, width)
        ),
    )


def _error(at: AtTime, name: str) -> Estimate | None:
    """By one metric; None if fewer than two replicates have it."""
    if METRICS[name].weight is not None:
        return _positive(at, name)
    values = at.linear(name)
    seen = values[np.isfinite(values)]
    return mean_interval(seen) if len(seen) >= 2 else None


def _positive(at: AtTime, name: str) -> Estimate:
    """A figure with an interval that is positive if the data allow it."""
    try:
        return exponential(at.statistic(name).interval())
    except ValueError:
        return mean_interval(at.linear(name))


def _efficiency(at: AtTime) -> Estimate:
    cost = product(at.powers).interval()
    # The powers hold T to the power of -s.
    shift = (1.0 + at.slope) * math.log(at.seconds)
    return exponential(Estimate(*(-(v + shift) for v in (cost.value, cost.high, cost.low))))


def _slope(ladder: Sequence[int], measured: Measured, against_time: bool) -> Estimate:
    """Of log(RMSE): half of that of log(MSE)."""
    errors = np.stack([measured.figures[spp][JUDGED] for spp in ladder])
    if against_time:
        x = np.stack([measured.figures[spp]["seconds"] for spp in ladder])
    else:
        x = np.repeat(np.array(ladder, np.float64)[:, None], errors.shape[1], axis=1)
    slope = log_slope(x, errors)
    return UNKNOWN if math.isnan(slope.value) else Estimate(*(v / 2.0 for v in slope))


def _images(plan: Plan, moments: Moments, store: Store) -> ArmImages:
    example = store.example(plan.key)
    assert example is not None
    mean = moments.mean.astype(np.float32)
    return ArmImages(
        example.picture, mean, moments.variance.astype(np.float32),
        mean - plan.reference.image,
        np.full(mean.shape[:2], plan.shown, np.float32), example.spp, example.seconds,
    )  # fmt: skip
