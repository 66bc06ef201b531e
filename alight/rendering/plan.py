"""The cost of a promise, predicted from a pilot.

The pilot's relMSE is measured at three numbers of samples, each twice the last. Its slope in
logarithms (-1 for independent samples, steeper for better ones) is extrapolated to the requested
error; the interval holds the doubt about the slope, the distance between two looks of the stop
rule, and that of the time per sample. The time is that of a start, of the samples, and of the looks
of the rule, which in small pictures is most of it.

Rare light that paths find by chance comes from the pilot that has looked for it
(`alight.rendering.schedules.rare_noise`) until enough samples have met it, and its noise is that of
independent samples. Only the rest has the slope.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import Any, ClassVar, Self

from alight.core.errors import OptionError
from alight.films import Film
from alight.metrics.error_estimate import Figure
from alight.metrics.estimate import Estimate
from alight.metrics.own_error import estimate_relmse
from alight.options.entry import takes
from alight.options.laboratory import PlanOptions
from alight.options.loading import scene_of
from alight.options.render import RenderOptions
from alight.outputs import html
from alight.rendering.main_loop import render_film
from alight.rendering.resources import usable_processors
from alight.rendering.schedules.rare_noise import RareNoise, rare_noise, without_samples
from alight.rendering.schedules.schedule import Goal, Schedule, Verdict
from alight.rendering.schedules.selection import promise_of
from alight.rendering.schedules.steering import check_replicates
from alight.rendering.schedules.stopping import (
    GROWTH,
    Promise,
    first_look,
    judge_means,
    next_look,
)
from alight.scene import Scene

#: Samples per pixel of the pilot, in whole rounds of replicates.
PILOT = (16, 32, 64)

#: The slope is no flatter than that of independent samples, less what noise makes of it, and no
#: steeper than that of the best samplers.
_FLATTEST, _STEEPEST = 0.9, 2.0

#: Doubt about the slope beside its noise (it flattens out where edges are left), and relative
#: half-widths: of the time, beside what the pilot's passes differ by; of the stop rule's own noise.
_SLOPE_DOUBT, _TIME_DOUBT, _RULE_DOUBT = 0.08, 0.25, 0.06

#: What the rule asks for beyond the error, relative, once rare light has been met often: room for
#: doubt, and for pixels that are darker than their surroundings.
_RULE_MARGIN = 1.2

#: A part of the noise from which on rare light counts as one.
_LITTLE = 0.1

#: Why no upper limit is known, and what helps.
_FEW = {
    "doubt": "few bright samples carry the pilot's noise, so its error has no useful bound",
    "remedy": "an integrator that finds their light more often (bidirectional, caustics: manifold,"
    " guiding), larger lamps, a larger error; alight why tells which light it is",
}
_BY_CHANCE = {
    "doubt": "only chance finds light here, and what it has missed so far has no bound",
    "remedy": "light sampling (integrator: path, light_sampling: mis)",
}


@dataclass
class PilotSchedule(Schedule):
    """Looks at doubling numbers of samples, and at the processor's clock.

    Attributes
    ----------
    seen : list of (spp, relRMSE that is not exceeded at 84 % minus estimate in logarithms, relMSE)
        Without rare light that paths find by chance.
    passes, looks : list of float
        Processor seconds of the samples between two looks, and of the looks.
    need : float
        Times the samples of the last look that the promise needs, without that light; infinite
        where there is no telling.
    rare : RareNoise
        Noise of that light at the last look.
    met : float
        relMSE of that light as the samples tell it.
    by_chance : bool
        Whether nothing is known of what chance may still find.
    """

    promise: Promise
    seen: list[tuple[int, float, float]] = field(default_factory=list)
    passes: list[float] = field(default_factory=list)
    looks: list[float] = field(default_factory=list)
    need: float = math.inf
    begin: float | None = None
    rare: RareNoise = field(default_factory=RareNoise)
    met: float = 0.0
    by_chance: bool = False
    name: ClassVar[str] = "pilot"

    def next(self, rounds: Sequence[Film]) -> Goal | Verdict:
        """The next number of samples, until all have been looked at."""
        now, film = time.process_time(), rounds[0]
        check_replicates(film)
        if self.begin is not None:
            self.passes.append(now - self.begin)
            figure = self._look(film)
            spread = math.log(math.sqrt(figure.quantile(0.841) / figure.value)) if (
                figure.value > 0.0
            ) else 0.0  # fmt: skip
            self.seen.append((round(film.spp), 2.0 * spread, figure.value))
        if len(self.seen) == len(PILOT):
            return Verdict("done")
        spp = film.replicates * math.ceil(PILOT[len(self.seen)] / film.replicates)
        self.begin = time.process_time()
        return Goal.uniform(film, 0, spp)

    @property
    def promises(self) -> bool:
        """It looks for what a promise depends on."""
        return True

    def _look(self, film: Film) -> Figure:
        """Look at a film, and give the error that other light than rare light brings."""
        figure = film.relmse_estimate(literature=False).figure
        # Timed is what the rule does at each of its looks.
        begin = time.process_time()
        means, counts = film.replicate_means()
        self.rare, whole = rare_noise(means, counts, film.rare_light), figure.value
        if _LITTLE * whole < self.rare.noise:
            means = without_samples(means, counts, self.rare.size)
            figure = estimate_relmse(means, counts).figure
        self.met = max(whole - figure.value, 0.0)
        known = film.largest_sample, film.by_chance
        judgement = judge_means(means, counts, self.promise, *known)
        self.need, self.by_chance = judgement.factor, math.isinf(judgement.unseen)
        self.looks.append(time.process_time() - begin)
        return figure

    def state(self) -> dict[str, Any]:
        """Nothing: a pilot is too short to be saved."""
        return {}

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """Refuse: a pilot is too short to be saved."""
        raise OptionError("a pilot cannot be resumed; start it again")


@dataclass(frozen=True)
class Plan:
    """The predicted cost of a promise.

    Attributes
    ----------
    spp, seconds : Estimate
        Samples per pixel, and processor seconds of rendering (divide by the number of busy
        threads for the time on the clock), each with a 95 % interval. Where no upper limit is
        known, the value is NaN and the upper end infinite.
    slope : Estimate
        Of log(relMSE) against log(samples), negative.
    pilot_error : float
        relRMSE of the pilot.
    pilot_spp : int
    threads : int, default 1
        That the picture will be rendered with.
    doubt : str, default ""
        Why no upper limit is known, if so.
    remedy : str, default ""
        What helps then.
    """

    spp: Estimate
    seconds: Estimate
    slope: Estimate
    pilot_error: float
    pilot_spp: int
    threads: int = 1
    doubt: str = field(default="", kw_only=True)
    remedy: str = field(default="", kw_only=True)

    def __str__(self) -> str:
        """What ``alight plan`` prints."""
        return "\n".join(f"{name}: {text}" for name, text in self._lines())

    def _repr_html_(self) -> str:
        """Show the figures as a table in a notebook."""
        return html.table(self._lines())

    def to_dict(self) -> dict[str, Any]:
        """All fields, for JSON: what is not finite is None."""
        return {
            name: value.to_dict() if isinstance(value, Estimate) else value
            for name, value in vars(self).items()
        }

    def _lines(self) -> list[tuple[str, str]]:
        spp, seconds, threads = self.spp, self.seconds, self.threads
        if self.doubt:
            return [
                ("pilot", f"{self.pilot_spp} spp, relRMSE {self.pilot_error:.2%}"),
                ("samples", f"at least {spp.low:.0f} per pixel; no upper limit is known"),
                ("processor time", f"at least {seconds.low:.3g} s"),
                ("why", self.doubt),
                ("what helps", self.remedy),
            ]
        samples = f"{spp.value:.0f} per pixel (95 %: {spp.low:.0f} to {spp.high:.0f})"
        interval = f"(95 %: {seconds.low:.3g} to {seconds.high:.3g} s)"
        wall = f"on {threads} threads about {seconds.value / threads:.3g} s"
        return [
            ("pilot", f"{self.pilot_spp} spp, relRMSE {self.pilot_error:.2%}"),
            ("samples", samples),
            ("processor time", f"{seconds.value:.3g} s {interval}, {wall}"),
        ]


@takes(PlanOptions)
def plan(scene: Scene | str | os.PathLike[str], options: PlanOptions) -> Plan:
    """Predict what a picture of a given error will cost.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    {options}

    Returns
    -------
    Plan

    Raises
    ------
    OptionError
        If the pilot has seen no light, so that nothing can be predicted.

    Examples
    --------
    >>> print(alight.plan("cornell-box", error="1%"))  # doctest: +SKIP
    """
    promise = promise_of(options)
    assert promise is not None
    threads = options.threads or usable_processors()
    description = scene_of(scene, options)
    return make_plan(description, promise, seed=options.seed, threads=threads)


def make_plan(scene: Scene | str, promise: Promise, **options: Any) -> Plan:
    """Predict what `promise` will cost.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    promise : Promise
    **options
        `seed`, `threads`, `replicates` and `cancel` of `alight.render`.

    Raises
    ------
    OptionError
        If the pilot has seen no light, so that nothing can be predicted.
    """
    pilot = PilotSchedule(promise)
    asked = RenderOptions(schedule=pilot, **options)
    film = render_film(scene_of(scene, asked), asked)
    if not pilot.seen or not math.isfinite(pilot.seen[-1][2]):
        raise OptionError("the pilot has seen no light; nothing can be predicted", "error")
    return replace(plan_of(pilot, film.replicates), threads=film.stats["threads"])


def plan_of(pilot: PilotSchedule, replicates: int) -> Plan:
    """Work out the cost from what a pilot has seen."""
    spp, _, relmse = pilot.seen[-1]
    if relmse + pilot.rare.noise == 0.0 and math.isfinite(pilot.need):
        first = float(first_look(replicates))
        seconds = _seconds(pilot, Estimate(first, first, first), replicates)
        return Plan(Estimate(first, first, first), seconds, Estimate(0.0, 0.0, 0.0), 0.0, spp)
    slope = _slope(pilot.seen)
    sigma = 1.96 * pilot.rare.doubt
    needs = [
        spp * _times(pilot, s, math.exp(shift))
        for s, shift in zip(slope, (0.0, sigma, -sigma), strict=True)
    ]
    shown, reached = Estimate(-slope.value, -slope.high, -slope.low), math.sqrt(relmse + pilot.met)
    middle = needs[0] * math.sqrt(GROWTH)
    # On the way back, where the promise is kept already, a steeper slope leads to more samples.
    low = _look_after(min(needs) * (1.0 - _RULE_DOUBT), replicates)
    if math.isinf(pilot.need):
        least = Estimate(math.nan, float(low), math.inf)
        why = _BY_CHANCE if pilot.by_chance else _FEW
        return Plan(least, _seconds(pilot, least, replicates), shown, reached, spp, **why)
    high = next_look(_look_after(max(needs) * (1.0 + _RULE_DOUBT), replicates), replicates)
    estimate = Estimate(min(max(middle, low), high), float(low), float(high))
    seconds = _seconds(pilot, estimate, replicates)
    return Plan(estimate, seconds, shown, reached, spp)


def _seconds(pilot: PilotSchedule, spp: Estimate, replicates: int) -> Estimate:
    """Processor time of the given samples per pixel and of the looks on the way there."""
    at = [0, *(seen[0] for seen in pilot.seen)]
    rates = [t / (b - a) for t, a, b in zip(pilot.passes, at, at[1:], strict=False)]
    # The first pass touches all memory for the first time; threads begin, clock rates rise.
    rate = sum(pilot.passes[1:]) / (at[-1] - at[1])
    start = max(pilot.passes[0] - rate * at[1], 0.0)
    look = sorted(pilot.looks)[len(pilot.looks) // 2]

    def until(samples: float) -> float:
        count, spp = 1, first_look(replicates)
        while spp < samples and count < 200:
            count, spp = count + 1, next_look(spp, replicates)
        return start + rate * samples + look * count

    # Passes of one pilot differ by what else the machine does.
    spread = math.log(max(rates[1:]) / min(rates[1:]))
    doubt = math.exp(math.hypot(_TIME_DOUBT, spread))
    return Estimate(until(spp.value), until(spp.low) / doubt, until(spp.high) * doubt)


def _times(pilot: PilotSchedule, slope: float, rare: float = 1.0) -> float:
    """Times the pilot's samples that the promise needs, with `rare` times the noise of rare light.

    The rule demands of rare light what it demands of light met often; of all other noise, what it
    demands of the pilot. Where that is unknown, it is what the pilot's estimate needs at least.
    """
    other = pilot.need if 1.0 < pilot.need < math.inf else _gap(pilot)
    rare *= _rare(pilot) * _margin(pilot.promise) / pilot.promise.error**2
    # Where the larger of the two is all that is allowed, both are too much. Their sum falls, and is
    # convex in the logarithm of the samples, so Newton's steps from there stay on that side.
    log = max(math.log(max(rare, 1e-300)), math.log(other) / slope)
    for _ in range(50):
        first, second = rare * math.exp(-log), other * math.exp(-slope * log)
        log += (first + second - 1.0) / (first + slope * second)
    return math.exp(log)


def _rare(pilot: PilotSchedule) -> float:
    """relMSE of rare light: what was expected, and the more has met it, what the samples tell."""
    noise = pilot.rare.noise
    if noise == 0.0:
        return 0.0
    known = pilot.rare.piloted / noise
    return noise**known * max(pilot.met, 0.1 * noise) ** (1.0 - known)


def _gap(pilot: PilotSchedule) -> float:
    """The pilot's relMSE over the one that is asked for."""
    return max(pilot.seen[-1][2] / pilot.promise.error**2, 1e-6)


def _margin(promise: Promise) -> float:
    """Squared error that is allowed, over the relMSE at which the rule ends."""
    if promise.metric == "relrmse":
        return _RULE_MARGIN**2
    return NormalDist().inv_cdf(0.5 + 0.5 * min(promise.share, 0.9999)) ** 2


def _slope(seen: Sequence[tuple[int, float, float]]) -> Estimate:
    """Slope with its interval, from the first and the last point."""
    (n0, spread0, e0), (n1, spread1, e1) = seen[0], seen[-1]
    steps = math.log(n1 / n0)
    slope = math.log(e0 / e1) / steps if e0 > 0.0 and e1 > 0.0 else 1.0
    doubt = 1.96 * math.hypot(math.hypot(spread0, spread1) / steps, _SLOPE_DOUBT)
    value = min(max(slope, _FLATTEST), _STEEPEST)
    low, high = max(slope - doubt, _FLATTEST), min(slope + doubt, _STEEPEST)
    return Estimate(value, min(low, value), max(high, value))


def _look_after(spp: float, replicates: int) -> int:
    """Find the first look of the stop rule at or after `spp`."""
    look = first_look(replicates)
    while look < spp and look < 2**40:
        look = next_look(look, replicates)
    return look
