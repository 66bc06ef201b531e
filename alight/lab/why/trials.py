"""Would another option lower the noise? Alternatives are rendered and measured, not guessed.

Every choice that the scene's integrator and its environment have is tried by itself, with the
scene's own sampler, and so are paths from both ends where light comes by detours: the variance of a
picture at equal samples, the processor time of its samples, and the efficiency, 1 / (variance x
time), over that of the scene as it is. Batches of replicates are independent, so the jackknife over
them gives an interval of the ratio (`alight.lab.statistics.intervals`). Where few bright samples
leave it open, paths from the lamps may tell (`alight.lab.why.rare_trials`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args, get_origin

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.errors import AlightError
from alight.core.noise_only import noise_only_fields
from alight.core.registry import default_of, specs_of
from alight.core.spec import Integrator, Spec
from alight.integrators.caustics.chain_types import has_chains
from alight.integrators.contributions import BY_LIGHT, SEEN
from alight.integrators.model import INTEGRATORS
from alight.integrators.walk import make_settings
from alight.lab.replicates.measure import add_tiles, film_for, ranges_of
from alight.lab.statistics.intervals import Ratio, Statistic, holm_adjusted, log_mean, log_ratio
from alight.lab.why.bright_samples import Squares, decided, squares_of
from alight.lab.why.rare_trials import CLEAR, rare_noises
from alight.lab.why.shares import TECHNIQUES, Part, relative_weights
from alight.laws.scene.pictures import Sums, small
from alight.lights.sampling import has_delta_lights
from alight.metrics.estimate import Estimate
from alight.rendering.resources import usable_processors
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import make_kernels
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
    bright : int
        Samples that carry the noise of both, where they are too few to tell; else 0. The intervals
        do not know of those that were not met.
    at_least : float
        Efficiency by what paths from the lamps know, where samples have met too little of their
        light; NaN elsewhere.
    """

    change: str
    variance: Estimate
    time: Estimate
    efficiency: Estimate
    p_value: float
    bright: int = 0
    at_least: float = math.nan

    @property
    def told_by_lamps(self) -> bool:
        """Whether paths from the lamps tell that it is better."""
        return self.at_least >= CLEAR

    @property
    def helps(self) -> bool:
        """Whether it was measured to be better, or paths from the lamps tell."""
        return (self.efficiency.value > 1.0 and self.p_value < LEVEL) or self.told_by_lamps

    @property
    def worth(self) -> float:
        """The efficiency that is known best."""
        return self.at_least if self.told_by_lamps else self.efficiency.value


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
    if not _is_direct(cause):
        found |= _from_both_ends(scene)
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
    if has_chains(program) and has_delta_lights(program):
        # Some of that light is found from both ends.
        found = {key: other for key, other in found.items() if not other.integrator.splats}
    names = {key: key.split(".")[1].split("=")[0] for key in found}
    order = sorted(found, key=lambda key: (names[key] not in first, names[key] != "type"))
    return {key: found[key] for key in order}


def _is_by_light(cause: Part | None) -> bool:
    return cause is not None and cause.technique == TECHNIQUES[BY_LIGHT]


def _is_direct(cause: Part | None) -> bool:
    """Whether it is light that paths from the camera find as well as any."""
    ways = TECHNIQUES[SEEN], TECHNIQUES[BY_LIGHT]
    return cause is not None and (cause.depth or 0) <= 2 and cause.technique in ways


def _from_both_ends(scene: Scene) -> dict[str, Scene]:
    """The same picture by paths from both ends, if there is one."""
    own, found = scene.integrator, {}
    # Others have shorter paths, and lights that the camera does not see are seen from both ends.
    if type(own) is not type(default_of(Integrator)) or getattr(own, "hide_emitters", False):
        return {}
    for name, kind in specs_of(Integrator).items():
        if INTEGRATORS[name].both_ends is None:
            continue
        fields = {key: value for key, value in own if key in kind.model_fields and key != "type"}
        changed = scene.replaced(integrator=kind(**fields)).from_source(scene.source)
        try:
            compile_scene(flatten(small(changed)))
        except AlightError:
            # Light paths do not pass some materials.
            continue
        found[f"integrator.type={name}"] = changed
    return found


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
    own = _sums_of(scene)
    weights = relative_weights(own.of(next(seeds), PILOT, 1)[:, :, 0] / PILOT)
    found: list[tuple[str, Ratio, Ratio, Ratio, list[Squares]]] = []
    left = []
    met: list[Squares] = []
    noises: list[tuple[float, float]] = []
    others = alternatives(scene, cause)
    for change, other in others.items():
        if time.perf_counter() - begin > limit:
            left.append(change)
            continue
        progress(change)
        (here, there), (of_own, of_other) = _measured((own, _sums_of(other)), weights, seeds)
        met += of_own
        noises.append((SPP * math.exp(here[0].value), SPP * math.exp(there[0].value)))
        variance = log_ratio(here[0], there[0])
        # Times of one batch are taken back to back, so that they share the machine's load.
        seconds = log_ratio(here[1], there[1], paired=True)
        both = log_ratio(here[0] + here[1], there[0] + there[1], paired=True)
        found.append((change, variance, seconds, both, of_other))
    # What the scene as it is has met in any trial counts in all of them.
    doubts = [decided(met, squares) for *_, squares in found]
    p_values = holm_adjusted(
        [max(both.p_value, few.p_value) for (*_, both, _), few in zip(found, doubts, strict=True)]
    )
    trials = [
        Trial(
            change, variance.estimate, seconds.estimate, both.estimate, p,
            few.samples if p >= LEVEL and few.p_value > both.p_value else 0,
        )
        for (change, variance, seconds, both, _), few, p in zip(
            found, doubts, p_values, strict=True
        )
    ]  # fmt: skip
    progress("light that few samples have met")
    known = [others[trial.change].integrator for trial in trials]
    rare = rare_noises(_small(scene), own.scene, known, weights)
    trials = [_told(*one, rare[0]) for one in zip(trials, noises, rare[1:], strict=True)]
    return tuple(sorted(trials, key=lambda trial: -trial.worth)), tuple(left)


def _told(trial: Trial, noises: tuple[float, float], left: float, rare: float) -> Trial:
    """A trial by what paths from the lamps know, where samples have met too little of their light.

    Parameters
    ----------
    trial : Trial
    noises : tuple of float
        Variance of a sample of the scene as it is and of the alternative, as the trial shows it.
    left, rare : float
        By light that the alternative, and the scene as it is, leave to chance.
    """
    own, other = noises
    if other + left <= 0.0 or not (trial.bright or rare > own):
        return trial
    return replace(trial, at_least=rare / (other + left) * trial.time.value)


class FilmSums:
    """As `Sums`, of pictures to which light paths add."""

    def __init__(self, scene: CompiledScene) -> None:
        self.scene, self.kernels = scene, make_kernels(scene)

    def of(self, seed: int, spp: int, replicates: int) -> np.ndarray:
        """Sums (h, w, replicates, 3) of samples 0 to spp - 1, of which replicates have the same."""
        scene, film = self.scene, film_for(self.scene, seed, replicates)
        settings = make_settings(scene.integrator, seed=seed, replicates=replicates)
        parts = [(tile, ranges_of(tile, 0, spp)) for tile in tiles_of(film.crop)]
        add_tiles(usable_processors(), self.kernels, scene, settings, film, parts)
        means, _ = film.replicate_means()
        return means.astype(np.float64) * (spp / replicates)


def _sums_of(scene: Scene) -> Sums | FilmSums:
    arm = _arm(scene)
    return FilmSums(arm) if scene.integrator.splats else Sums(arm)


def _small(scene: Scene) -> Scene:
    """The scene as a small picture, with its own sampler."""
    made = small(scene, size=SIZE).replaced(sampler=scene.sampler)
    return made.from_source(scene.source)


def _arm(scene: Scene) -> CompiledScene:
    return compile_scene(flatten(_small(scene)))


def _measured(
    arms: tuple[Sums | FilmSums, ...],
    weights: np.ndarray,
    seeds: Iterator[int],
) -> tuple[list[tuple[Statistic, Statistic]], list[list[Squares]]]:
    """Logarithms of the variance of a replicate and of its processor time, for each of two arms.

    And the squares of their batches.
    """
    for arm in arms:
        # Compiles, so that the times are of rendering alone.
        arm.of(next(seeds), 1, 1)
    variances, times = np.zeros((2, len(arms), BATCHES))
    squares: list[list[Squares]] = [[] for _ in arms]
    for batch in range(BATCHES):
        for k, arm in enumerate(arms):
            begin = time.process_time()
            sums = arm.of(next(seeds), SPP * REPLICATES, REPLICATES)
            times[k, batch] = time.process_time() - begin
            variances[k, batch] = np.sum((sums / SPP).var(axis=2, ddof=1) * weights)
            squares[k].append(squares_of(sums, weights))
    return [(log_mean(v), log_mean(t)) for v, t in zip(variances, times, strict=True)], squares
