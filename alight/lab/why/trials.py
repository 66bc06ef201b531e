"""Would another option lower the noise? Alternatives are rendered and measured, not guessed.

Every choice that the scene's integrator and its environment have is tried by itself, with the
scene's own sampler: the variance of a picture at equal samples, the processor time of its samples,
and the efficiency, 1 / (variance x time), over that of the scene as it is. Batches of replicates
are independent, so the jackknife over them gives an interval of the ratio
(`alight.lab.statistics.intervals`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.noise_only import noise_only_fields
from alight.core.spec import Spec
from alight.integrators.caustics.chain_types import has_chains
from alight.integrators.contributions import BY_LIGHT
from alight.lab.statistics.intervals import Ratio, Statistic, holm_adjusted, log_mean, log_ratio
from alight.lab.why.shares import TECHNIQUES, Part, relative_weights
from alight.laws.scene.pictures import Sums, small
from alight.lights.sampling import has_delta_lights
from alight.metrics.estimate import Estimate
from alight.scene import Scene, flatten

#: Independent batches, replicates in each, samples a pixel of each replicate.
BATCHES, REPLICATES, SPP = 8, 8, 8
#: Samples a pixel of the pilot that weighs the pixels; pixels of the longer side.
PILOT, SIZE = 32, 64
#: Largest corrected p-value of what is called a help.
LEVEL = 0.05


@dataclass(frozen=True)
class Trial:
    """One alternative, against the scene as it is.

    Attributes
    ----------
    change : str
        As for ``--set``.
    variance, time : Estimate
        Of the scene as it is over those with the change: above 1 is better. Value, and 95 %
        interval.
    efficiency : Estimate
        Their product.
    p_value : float
        Of "the efficiency is the same", corrected for all trials (Holm).
    """

    change: str
    variance: Estimate
    time: Estimate
    efficiency: Estimate
    p_value: float

    @property
    def helps(self) -> bool:
        """Whether it was measured to be better."""
        return self.efficiency.value > 1.0 and self.p_value < LEVEL


#: The choice that is one of the others, by itself.
AUTO = "auto"


def alternatives(scene: Scene, cause: Part | None = None) -> dict[str, Scene]:
    """Every other choice of the integrator and the environment, by what to ``--set``.

    Parameters
    ----------
    scene : Scene
    cause : Part, optional
        What makes most of the noise: choices that concern it come first.
    """
    found: dict[str, Scene] = {}
    for path, spec in (("integrator", scene.integrator), ("environment", scene.environment)):
        if spec is None:
            continue
        for name, value in _other_choices(spec):
            try:
                changed = scene.replaced(**{path: spec.replaced(**{name: value})})
            except ValueError:
                # Such as no roulette without a longest path.
                continue
            if changed.integrator.wants_guide and not scene.integrator.wants_guide:
                # Whether training pays depends on how long the render is: no small trial tells.
                continue
            shown = str(value).lower() if isinstance(value, bool) else value
            found[f"{path}.{name}={shown}"] = changed.from_source(scene.source)
    first = {"light_choice", "sampling"} if _is_by_light(cause) else {"light_sampling", "heuristic"}
    program = compile_scene(flatten(small(scene))).program
    if scene.integrator.choice_of_lights == AUTO:
        # What it takes by itself is no other choice.
        found.pop(f"integrator.light_choice={'tree' if program.light_tree else 'power'}", None)
    if program.single_light:
        # Nothing to choose from.
        found = {key: other for key, other in found.items() if ".light_choice=" not in key}
    if not has_chains(program) or has_delta_lights(program):
        # Nothing to look through, or light that no path finds: another picture, which is no advice.
        found.pop("integrator.caustics=manifold", None)
    order = sorted(found, key=lambda key: key.split(".")[1].split("=")[0] not in first)
    return {key: found[key] for key in order}


def _is_by_light(cause: Part | None) -> bool:
    return cause is not None and cause.technique == TECHNIQUES[BY_LIGHT]


def _other_choices(spec: Spec) -> Iterator[tuple[str, Any]]:
    """Fields with a few choices that leave the picture as it is, and the choices not taken."""
    for name in noise_only_fields(spec):
        field, value = type(spec).model_fields[name], getattr(spec, name)
        if get_origin(field.annotation) is Literal:
            choices = get_args(field.annotation)
            yield from ((name, choice) for choice in choices if choice not in (value, AUTO))
        elif isinstance(value, bool):
            yield name, not value


def try_alternatives(
    scene: Scene,
    *,
    cause: Part | None = None,
    seed: int = 0,
    limit: float = 60.0,
    progress: Callable[[str], None] = lambda text: None,
) -> tuple[tuple[Trial, ...], tuple[str, ...]]:
    """Measure what each alternative does to the noise.

    Parameters
    ----------
    scene : Scene
    cause : Part, optional
        What makes most of the noise.
    seed : int
    limit : float, seconds, default 60
        No alternative is begun after so long.
    progress : callable, optional
        Called with a description of what runs next.

    Returns
    -------
    tuple of Trial
        The most efficient first.
    tuple of str
        Changes that there was no time for.
    """
    begin = time.perf_counter()
    progress("the scene as it is")
    seeds = iter(np.random.SeedSequence((seed, 5)).generate_state(1000).tolist())
    own = Sums(_arm(scene))
    weights = relative_weights(own.of(next(seeds), PILOT, 1)[:, :, 0] / PILOT)
    found: list[tuple[str, Ratio, Ratio, Ratio]] = []
    left = []
    for change, other in alternatives(scene, cause).items():
        if time.perf_counter() - begin > limit:
            left.append(change)
            continue
        progress(change)
        here, there = _measured((own, Sums(_arm(other))), weights, seeds)
        variance = log_ratio(here[0], there[0])
        # Times of one batch are taken back to back, so that they share the machine's load.
        seconds = log_ratio(here[1], there[1], paired=True)
        both = log_ratio(here[0] + here[1], there[0] + there[1], paired=True)
        found.append((change, variance, seconds, both))
    p_values = holm_adjusted([both.p_value for _, _, _, both in found])
    trials = [
        Trial(change, variance.estimate, seconds.estimate, both.estimate, p)
        for (change, variance, seconds, both), p in zip(found, p_values, strict=True)
    ]
    return tuple(sorted(trials, key=lambda trial: -trial.efficiency.value)), tuple(left)


def _arm(scene: Scene) -> CompiledScene:
    """The scene as a small picture, with its own sampler."""
    made = small(scene, size=SIZE).replaced(sampler=scene.sampler)
    return compile_scene(flatten(made.from_source(scene.source)))


def _measured(
    arms: tuple[Sums, ...], weights: np.ndarray, seeds: Iterator[int]
) -> list[tuple[Statistic, Statistic]]:
    """Logarithms of the variance of a replicate and of its processor time, for each arm."""
    for arm in arms:
        # Compiles, so that the times are of rendering alone.
        arm.of(next(seeds), 1, 1)
    variances, times = np.zeros((2, len(arms), BATCHES))
    for batch in range(BATCHES):
        for k, arm in enumerate(arms):
            begin = time.process_time()
            sums = arm.of(next(seeds), SPP * REPLICATES, REPLICATES)
            times[k, batch] = time.process_time() - begin
            variances[k, batch] = np.sum((sums / SPP).var(axis=2, ddof=1) * weights)
    return [(log_mean(v), log_mean(t)) for v, t in zip(variances, times, strict=True)]
