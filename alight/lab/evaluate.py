"""From stored replicates to what is claimed: points, speed-ups, slopes, tests of bias."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from alight.lab.arms import Arm, seed_of
from alight.lab.blocks import BlockMoments, RawTest, compare_with_reference, judge
from alight.lab.decomposition import Moments, Parts, decompose, reference_spread
from alight.lab.references import Reference, demand_quiet
from alight.lab.results import UNKNOWN, ArmImages, ArmResult, BiasTest, Point, Speedup
from alight.lab.statistics import (
    Statistic,
    bootstrap_ratio,
    exponential,
    holm_adjusted,
    log_mean,
    log_ratio,
    log_slope,
    mean_interval,
    positive_interval,
)
from alight.lab.store import Replicate, Store
from alight.lab.study import Study, StudyError
from alight.metrics.relmse import Estimate


@dataclass(frozen=True)
class Plan:
    """What one arm renders in one scene.

    Attributes
    ----------
    arm : Arm
    key : str
        Of its replicates in the store.
    samples, times : tuple of int
        Samples per pixel of both ladders.
    reference : Reference
    own_reference : bool
    """

    arm: Arm
    key: str
    samples: tuple[int, ...]
    times: tuple[int, ...]
    reference: Reference
    own_reference: bool

    @property
    def ladder(self) -> tuple[int, ...]:
        """All steps, rising."""
        return tuple(sorted({*self.samples, *self.times}))

    @property
    def tops(self) -> tuple[int, ...]:
        """The last steps of both ladders: whose pictures are added up."""
        return tuple(sorted({self.samples[-1], (self.times or self.samples)[-1]}))

    @property
    def judged(self) -> int:
        """The step at which arms are compared: the last one of equal time, if there is one."""
        return (self.times or self.samples)[-1]


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

    def cost(self, spp: int) -> Statistic:
        """Logarithm of MSE times seconds; ValueError where the MSE is not positive."""
        at = self.figures[spp]
        return log_mean(at["mse"]) + log_mean(at["seconds"])


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def evaluate_arms(
    study: Study, scene_path: str, baseline: str, plans: Sequence[Plan], store: Store, count: int
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
    tests = _bias_tests(plans, measured)
    return [
        _arm_result(plan, measured[plan.arm.spec.name], moments[plan.arm.spec.name],
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
        if float(moments[name][plan.judged].variance.max()) == 0.0:
            raise no_noise(study, name)
    for reference in {id(plan.reference): plan.reference for plan in plans}.values():
        errors = {}
        for plan in plans:
            if plan.reference is reference:
                name = plan.arm.spec.name
                errors[name] = float(measured[name].figures[plan.judged]["mse"].mean())
        name = min(errors, key=lambda name: errors[name])
        demand_quiet(study, f"{scene_path}.reference", reference, name, errors[name])
    for plan in plans:
        name = plan.arm.spec.name
        try:
            measured[name].cost(plan.judged)
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
    base_at = measured[baseline].figures[base.judged]
    ratios, intervals = [], []
    for plan in others:
        mine = measured[plan.arm.spec.name]
        at = mine.figures[plan.judged]
        ratios.append(
            log_ratio(
                measured[baseline].cost(base.judged), mine.cost(plan.judged),
                paired=study.paired, extra_variance=_shared_noise(base, base_at, plan, at),
            )
        )  # fmt: skip
        intervals.append(
            bootstrap_ratio(
                [base_at["mse"], base_at["seconds"]], [at["mse"], at["seconds"]],
                seed_of("bootstrap", plan.key), paired=study.paired,
            )
        )  # fmt: skip
    adjusted = holm_adjusted([ratio.p_value for ratio in ratios])
    return {
        plan.arm.spec.name: Speedup(ratio.estimate, ratio.p_value, p, interval)
        for plan, ratio, p, interval in zip(others, ratios, adjusted, intervals, strict=True)
    }


def _shared_noise(
    a: Plan, at_a: Mapping[str, np.ndarray], b: Plan, at_b: Mapping[str, np.ndarray]
) -> float:
    """Variance of the log ratio from the noise of the references."""
    inverse_a, inverse_b = 1.0 / float(at_a["mse"].mean()), 1.0 / float(at_b["mse"].mean())
    spread_a = reference_spread(a.reference.variance, a.reference.seeds)
    if a.reference is b.reference:
        # The same error on both sides cancels where the arms are equally noisy.
        return spread_a * (inverse_a - inverse_b) ** 2
    spread_b = reference_spread(b.reference.variance, b.reference.seeds)
    return spread_a * inverse_a**2 + spread_b * inverse_b**2


def _bias_tests(plans: Sequence[Plan], measured: Mapping[str, Measured]) -> list[BiasTest]:
    raw: list[RawTest] = []
    for plan in plans:
        statistics = measured[plan.arm.spec.name].blocks.statistics
        raw.append(compare_with_reference(statistics, plan.reference.statistics))
    return judge(raw, [plan.arm.spec.declares_different for plan in plans])


def _arm_result(
    plan: Plan,
    measured: Measured,
    moments: Mapping[int, Moments],
    speedup: Speedup | None,
    test: BiasTest,
    baseline: str,
    store: Store,
) -> ArmResult:
    spec, reference = plan.arm.spec, plan.reference
    parts = {
        spp: decompose(one, reference.image, reference.variance) for spp, one in moments.items()
    }
    cost = measured.cost(plan.judged).interval()
    per_sample = 1e6 / (plan.judged * plan.arm.size[0] * plan.arm.size[1])
    seconds = positive_interval(measured.figures[plan.judged]["seconds"])
    return ArmResult(
        name=spec.name,
        label=spec.label or spec.name,
        options=dict(spec.options),
        is_baseline=spec.name == baseline,
        declares_different=spec.declares_different,
        replicates=len(measured.seeds),
        seeds=measured.seeds,
        samples=[_point(spp, measured.figures[spp], parts) for spp in plan.samples],
        times=[_point(spp, measured.figures[spp], parts) for spp in plan.times],
        efficiency=exponential(Estimate(-cost.value, -cost.high, -cost.low)),
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
        images=_images(plan, moments[plan.judged], store),
    )


def _point(spp: int, figures: Mapping[str, np.ndarray], parts: Mapping[int, Parts]) -> Point:
    mse = positive_interval(figures["mse"])
    # The mean of a picture does not depend on the number of samples, nor does its bias: steps
    # whose pictures were not added up have that of the deepest one.
    bias2 = parts[spp if spp in parts else max(parts)].bias2
    variance = mse.value - bias2.value
    low, high = mse.value - mse.low, mse.high - mse.value
    width = bias2.high - bias2.value
    seen = figures["flip"][np.isfinite(figures["flip"])]
    return Point(
        spp=spp,
        seconds=positive_interval(figures["seconds"]),
        mse=mse,
        relmse=positive_interval(figures["relmse"]),
        relmse_literature=positive_interval(figures["relmse_literature"]),
        smape=mean_interval(figures["smape"]),
        flip=mean_interval(seen) if len(seen) >= 2 else None,
        bias2=bias2,
        variance=Estimate(
            variance, variance - math.hypot(low, width), variance + math.hypot(high, width)
        ),
    )


def _slope(ladder: Sequence[int], measured: Measured, against_time: bool) -> Estimate:
    """Of log(RMSE): half of that of log(MSE)."""
    errors = np.stack([measured.figures[spp]["mse"] for spp in ladder])
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
        np.full(mean.shape[:2], plan.judged, np.float32), example.spp, example.seconds,
    )  # fmt: skip
