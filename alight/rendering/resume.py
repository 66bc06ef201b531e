"""Resuming a render from its checkpoint, to the same bits as if it had never stopped."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace

from alight.core.errors import FilmError, SceneError
from alight.films import Film
from alight.formats import load
from alight.rendering.checkpoint import Checkpoint, Origin, read_checkpoint
from alight.rendering.checkpoint_writer import CheckpointWriter
from alight.rendering.job import Progress
from alight.rendering.main_loop import EVERY, Clock, make_job, run
from alight.rendering.options import check_options
from alight.rendering.passes import Pace
from alight.rendering.schedule import Schedule
from alight.rendering.schedules import restored_schedule
from alight.rendering.steering import towards
from alight.rendering.stopping import Promise
from alight.scene import Scene, content_hash, flatten
from alight.scene.content import describe_content, differences
from lanewise.machine import describe_machine, fingerprint

#: So many changes are named; more are counted.
_MOST_NAMED = 8


def resume(
    path: str | os.PathLike[str] | Checkpoint,
    *,
    scene: Scene | str | os.PathLike[str] | None = None,
    spp: int | None = None,
    time_limit: float | None = None,
    promise: Promise | None = None,
    schedule: Schedule | None = None,
    root: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    spp_per_pass: int | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    every: float = EVERY,
    progress: Callable[[Progress], None] | None = None,
    cancel: threading.Event | None = None,
) -> Film:
    """Go on with a render, to the same bits as if it had never stopped.

    Parameters
    ----------
    path : path or Checkpoint
        What ``render(..., checkpoint=path)`` wrote. It is written on, too.
    scene : Scene or path, optional
        The same scene, where it was made in Python or has been moved.
    spp : int, optional
        Samples per pixel in all, to render more (or fewer) than was asked for first; with
        `promise` the largest number of them.
    time_limit : float, seconds, optional
        For this part of the render; what is left of the first time limit by default.
    promise : Promise, optional
        Go on until it is kept.
    schedule : Schedule, optional
        Another rule instead of the one in the checkpoint.
    root : path, optional
        As for `alight.load`, where the scene and its files have been moved; as the render began
        by default.
    checkpoint : path, optional
        Write checkpoints to this file, not to `path`.
    threads, spp_per_pass, every, progress, cancel
        As for `alight.render`.

    Returns
    -------
    Film

    Raises
    ------
    AlightError
        If the checkpoint cannot be read, the scene is another one, or this machine or this
        version of alight would give other bits: the message names what differs.
    """
    check_options(
        spp=spp, time_limit=time_limit, threads=threads, spp_per_pass=spp_per_pass, every=every
    )
    saved = path if isinstance(path, Checkpoint) else read_checkpoint(path)
    clock = Clock()
    _check_machine(saved)
    scene = _load_scene(saved, scene, root)
    state, film = saved.state, saved.state.rounds[0]
    own = restored_schedule(state.schedule, state.schedule_state)
    goes_on = spp is None and promise is None and schedule is None
    if schedule is None:
        if promise is not None:
            schedule = towards(own, promise, film, spp)
        else:
            schedule = own if spp is None else own.extended(spp)
    job = make_job(
        scene, schedule, clock, seed=film.seed, threads=threads, replicates=film.replicates,
        aovs=tuple(film.aov_channels),
    )  # fmt: skip
    job.restore(state, state.goal if goes_on else None)
    if time_limit is not None:
        job.time_limit = state.seconds + time_limit
    elif goes_on:
        job.time_limit = state.time_limit
    origin = Origin.of(scene, saved.origin.notes)
    if origin.recipe is None:
        origin = replace(origin, recipe=saved.origin.recipe)
    writer = CheckpointWriter(checkpoint or saved.path, every, origin)
    return run(job, clock, Pace(spp_per_pass), writer=writer, progress=progress, cancel=cancel)


def _check_machine(saved: Checkpoint) -> None:
    """Refuse where the samples to come would not be those of the film."""
    if saved.state.rounds[0].fingerprint == fingerprint():
        return
    changed = differences(saved.origin.machine, describe_machine())
    raise FilmError(
        f"cannot resume {saved.path}: here the same samples would have other bits\n"
        + listed(changed or ["kernel fingerprint: is another one"])
        + f"\nits picture is whole: alight merge {saved.path} -o picture.exr"
    )


def _load_scene(
    saved: Checkpoint,
    scene: Scene | str | os.PathLike[str] | None,
    root: str | os.PathLike[str] | None,
) -> Scene:
    """Load the scene and refuse another one."""
    recipe = saved.origin.recipe
    if scene is None and recipe is None:
        raise FilmError(
            f"cannot resume {saved.path}: its scene was made in Python; give it as well: "
            "alight.resume(path, scene=scene)"
        )
    if not isinstance(scene, Scene):
        try:
            scene = _loaded(recipe, scene, root)
        except SceneError as error:
            raise FilmError(
                f"cannot resume {saved.path}: its scene cannot be loaded\n{error}\n"
                "a scene that was moved is found again with --scene, and --root where it has one"
            ) from error
    if content_hash(flatten(scene)) != saved.state.rounds[0].scene_hash:
        raise FilmError(changed_scene(saved.path, saved.origin.content, scene))
    return scene


def _loaded(recipe, moved, root) -> Scene:
    if recipe is None:
        return load(moved, root=root)
    return load(
        moved or recipe.path,
        recipe.changes,
        definitions=recipe.definitions,
        lenient=recipe.lenient,
        root=recipe.root if root is None else root,
    )


def changed_scene(path: str, before: Mapping[str, str], scene: Scene) -> str:
    """Say that a scene is not that of a checkpoint, and why."""
    changed = differences(before, describe_content(scene))
    named = listed(changed or ["its content"])
    return f"cannot resume {path}: the scene has changed since\n{named}"


def listed(lines: list[str]) -> str:
    """Write the first few lines under a message, and how many more there are."""
    more = len(lines) - _MOST_NAMED
    shown = [f"  {line}" for line in lines[:_MOST_NAMED]]
    return "\n".join(shown + ([f"  and {more} more"] if more > 0 else []))
