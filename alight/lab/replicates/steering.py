"""Arms that differ in where samples go: the renderer's schedules, under a study's clock.

::

    arms:
      even: {}
      adaptive: {schedule: adaptive}
      cycles: {schedule: {type: cycles, threshold: 0.01}}

A step of the ladder is a render of its own, to that number of samples per pixel on average (Cycles'
rule: at most), with its pilot and its decisions: all that is in the time.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.errors import show_value, unknown_name
from alight.films import Film
from alight.integrators.walk import Settings, make_settings
from alight.lab.replicates.measure import Rung, add_tiles, film_for, made_ready
from alight.rendering.schedules.cycles import THRESHOLD, Cycles
from alight.rendering.schedules.passes import Work, ranges_of
from alight.rendering.schedules.schedule import Schedule, Verdict
from alight.rendering.schedules.steering import Steered
from alight.rendering.seeds import seed_of_round
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import Kernels

#: What `schedule` may be; "uniform" is the same number of samples everywhere.
SCHEDULES = ("uniform", "adaptive", "cycles")


def problem_of(option: Any) -> str | None:
    """What is wrong with the option `schedule` of an arm, None if nothing is."""
    fields = option if isinstance(option, Mapping) else {"type": option}
    kind, known = fields.get("type"), {"type", "threshold"}
    if kind not in SCHEDULES:
        return unknown_name("schedule", str(kind), SCHEDULES)
    for name in fields:
        if name not in known:
            return unknown_name("key", str(name), known)
    threshold = fields.get("threshold", THRESHOLD)
    if "threshold" in fields and kind != "cycles":
        return "only cycles has a threshold"
    number = isinstance(threshold, int | float) and not isinstance(threshold, bool)
    if not number or not 0.0 < threshold <= 1.0:
        return f"threshold must be a number in (0, 1], got {show_value(threshold)}"
    return None


def is_steered(option: Any) -> bool:
    """Whether an arm's option `schedule` asks for anything else than even samples."""
    return (option.get("type") if isinstance(option, Mapping) else option) not in (None, "uniform")


def is_biased(option: Any) -> bool:
    """Whether an arm decides by the samples that it keeps, and so can be no reference."""
    return (option.get("type") if isinstance(option, Mapping) else option) == "cycles"


def schedule_of(option: Any, spp: int) -> Schedule:
    """The schedule of one picture of `spp` samples per pixel."""
    if is_biased(option):
        fields = option if isinstance(option, Mapping) else {}
        return Cycles(0, spp, float(fields.get("threshold", THRESHOLD)))
    return Steered(0, spp, None, adaptive=True)


def steered_ladder(
    scene: CompiledScene,
    kernels: Kernels,
    replicates: int,
    seed: int,
    ladder: Sequence[int],
    threads: int,
    option: Any,
) -> Iterator[Rung]:
    """As `alight.lab.replicates.measure.render_ladder`, by the schedule that an option names.

    Parameters
    ----------
    scene, kernels, replicates, seed, ladder, threads
        As there.
    option : str or mapping
        See `problem_of`.
    """
    scene, kernels, training = made_ready(scene, kernels, seed, threads, ladder[-1])
    for spp in ladder:
        begin = time.thread_time()
        settings = make_settings(
            scene.integrator, seed=seed, replicates=replicates, guide=scene.guide
        )
        film, seconds = _picture(scene, kernels, settings, schedule_of(option, spp), threads)
        seconds += time.thread_time() - begin + training
        yield Rung(spp, seconds, film.mean[..., :3].astype(np.float32), film.invalid)


def _picture(
    scene: CompiledScene,
    kernels: Kernels,
    settings: Settings,
    schedule: Schedule,
    threads: int,
) -> tuple[Film, float]:
    """Render until the schedule ends it; the film, and CPU seconds of the threads."""
    seconds = 0.0
    rounds = [film_for(scene, settings.seed, settings.replicates)]
    tiles = tiles_of(rounds[0].crop)
    while True:
        goal = schedule.next(rounds)
        if isinstance(goal, Verdict):
            return schedule.picture(rounds), seconds
        if goal.round == len(rounds):
            seed = seed_of_round(settings.seed, goal.round)
            rounds.append(film_for(scene, seed, settings.replicates))
        film = rounds[goal.round]
        work = Work(goal, film)
        samples = work.take(work.left)
        own = settings._replace(seed=film.seed)
        parts = [(tile, ranges_of(tile, samples)) for tile in tiles]
        seconds += add_tiles(threads, kernels, scene, own, film, parts)
