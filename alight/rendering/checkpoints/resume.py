"""Resuming a render from its checkpoint, to the same bits as if it had never stopped."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from alight.cluster.fork_server import RENDERS, start_fork_server
from alight.core.errors import FilmError, OptionError, SceneError
from alight.films import Film
from alight.films.coverage import check_same_names
from alight.formats import load
from alight.formats.loading import load_again
from alight.options.device import CPU, GPU
from alight.options.entry import takes
from alight.options.kinds import Files
from alight.options.plugins import load_plugins
from alight.options.resume import ResumeOptions
from alight.rendering.checkpoints.checkpoint import Checkpoint, Origin, read_checkpoint
from alight.rendering.checkpoints.checkpoint_writer import CheckpointWriter
from alight.rendering.executors.blocks import Executor
from alight.rendering.executors.selection import executor_of
from alight.rendering.job import TABLES, Job
from alight.rendering.main_loop import Clock, make_job, run
from alight.rendering.schedules.schedule import Schedule
from alight.rendering.schedules.selection import promise_of, restored_schedule
from alight.rendering.schedules.steering import Steered, towards
from alight.rendering.schedules.stopping import Promise
from alight.rendering.writing import Targets, finish
from alight.scene import Scene, content_hash, flatten
from alight.scene.content import describe_content, differences
from lanewise.machine import NATIVE, PTX, choose_target, fingerprint_of

#: So many changes are named; more are counted.
_MOST_NAMED = 8


@dataclass(frozen=True)
class PreparedResume:
    """A render that can go on.

    Attributes
    ----------
    saved : Checkpoint
    options : ResumeOptions
    targets : Targets
        As noted in the checkpoint, where the options say nothing else.
    """

    saved: Checkpoint
    options: ResumeOptions
    targets: Targets

    def warnings(self, spell: Callable[[str], str] = str) -> list[str]:
        """What is legal but suspicious."""
        useless = self.options.useless()
        found = [OptionError(text, names=names).spelled(spell) for text, names in useless]
        return found + self._warnings_of_samples(spell)

    def _warnings_of_samples(self, spell: Callable[[str], str]) -> list[str]:
        held, spp = self.saved.state.rounds[0].spp, self.options.spp
        if spp is None or self.options.promise:
            return []
        if spp <= held:
            return [f"there are {held:g} samples per pixel already; {spell('spp')} {spp} adds none"]
        least = _least_spp(self.saved)
        if spp >= least:
            return []
        text = f"some pixels hold samples beyond {spell('spp')} {spp}, which stay: "
        return [f"{text}{least} or more gives all pixels the same"]

    def render(self, **seen: object) -> Film:
        """Render; `seen` may replace `progress` and `cancel`."""
        return _go_on(self.saved, self.options.changed(**seen))


def prepare_resume(
    path: str | os.PathLike[str] | Checkpoint, options: ResumeOptions
) -> PreparedResume:
    """Check options and targets, and read the checkpoint.

    Raises
    ------
    AlightError
        For an option that is wrong, or a checkpoint that cannot be read.
    """
    start_fork_server(options.cluster, RENDERS)
    saved = path if isinstance(path, Checkpoint) else read_checkpoint(path)
    notes = saved.origin.notes
    # Not those of the notes: a file of data names no code that is run (decision 32).
    plugins = Files().check(options.plugins)
    load_plugins(plugins)
    noted = Targets.noted(notes)
    targets = replace(
        noted, outputs=options.output or noted.outputs, stats=options.stats,
        checkpoint=Path(options.checkpoint or saved.path), plugins=plugins or noted.plugins,
    )  # fmt: skip
    return PreparedResume(saved, options, targets)


@takes(ResumeOptions)
def resume(path: str | os.PathLike[str] | Checkpoint, options: ResumeOptions) -> Film:
    """Go on with a render, to the same bits as if it had never stopped.

    Parameters
    ----------
    path : path or Checkpoint
        What ``render(..., checkpoint=path)`` wrote. Later checkpoints overwrite it.
    {options}

    Returns
    -------
    Film

    Raises
    ------
    AlightError
        If the checkpoint cannot be read, the scene is another one, or this machine or this
        version of alight would give other bits: the message names what differs.
    """
    begin = time.perf_counter()
    prepared = prepare_resume(path, options)
    targets = prepared.targets
    if not options.output:
        # What the command line noted is not Python's to overwrite.
        targets = replace(targets, outputs=())
    targets.check()
    film = prepared.render()
    if options.cancel is None or not options.cancel.is_set():
        finish(film, targets, begin, prepared.warnings())
    return film


def _go_on(saved: Checkpoint, options: ResumeOptions) -> Film:
    """Render what is left."""
    clock = Clock()
    with executor_of(options, _device_of(saved)) as executor:
        return _go_on_with(executor, saved, options, clock)


def _go_on_with(
    executor: Executor, saved: Checkpoint, options: ResumeOptions, clock: Clock
) -> Film:
    _take_target(saved)
    _check_machine(saved, executor.machine)
    scene = _load_scene(saved, options.scene, options.root)
    state, film = saved.state, saved.state.rounds[0]
    own = restored_schedule(state.schedule, state.schedule_state)
    promise, schedule = options.promise or promise_of(options), options.schedule
    spp = options.spp
    if options.max_spp is not None:
        promise, spp = promise or _promised(own), options.max_spp
    goes_on = spp is None and promise is None and schedule is None
    if schedule is None:
        if promise is not None:
            schedule = towards(own, promise, film, spp)
        else:
            schedule = own if spp is None else own.extended(spp)
    job = make_job(
        scene, schedule, clock, seed=film.seed, threads=options.threads,
        replicates=film.replicates, aovs=tuple(film.aov_channels), again=film.options,
        machine=executor.machine,
    )  # fmt: skip
    check_same_names(film.coverage, job.rounds[0].coverage, f"cannot resume {saved.path}")
    _check_tables(saved, job)
    job.restore(state, state.goal if goes_on else None)
    if options.time_limit is not None:
        job.time_limit = state.seconds + float(options.time_limit)
    elif goes_on:
        job.time_limit = state.time_limit
    origin = Origin.of(scene, saved.origin.notes, executor.machine)
    if origin.recipe is None:
        origin = replace(origin, recipe=saved.origin.recipe)
    writer = CheckpointWriter(options.checkpoint or saved.path, options.every, origin)
    return run(
        job, clock, executor, options.spp_per_pass, writer=writer, progress=options.progress,
        cancel=options.cancel,
    )  # fmt: skip


def _promised(schedule: Schedule) -> Promise:
    """What a render has promised whose limit is raised.

    Raises
    ------
    OptionError
        If it is nothing.
    """
    if isinstance(schedule, Steered) and schedule.promise is not None:
        return schedule.promise
    text = "{max_spp} limits {error}, which the checkpoint was not asked for; give {spp}"
    raise OptionError(text, names=("max_spp", "error", "spp"))


def _least_spp(saved: Checkpoint) -> int:
    """The fewest samples per pixel among which are all that the first film holds.

    Not the most that a pixel holds: workers of a cluster answer in any order, so a render that was
    stopped may hold the end of a pass and not its beginning.
    """
    ends = (end for cell in saved.state.rounds[0].cells.flat for _, end in cell)
    return max(ends, default=0) - int(saved.state.schedule_state.get("first", 0))


def _target_of(saved: Checkpoint) -> str:
    """The target for which the film was rendered."""
    return saved.origin.machine.get("target", NATIVE)


def _device_of(saved: Checkpoint) -> str:
    """A film that was begun on a GPU goes on there: what else renders has other bits."""
    return GPU if _target_of(saved) == PTX else CPU


def _take_target(saved: Checkpoint) -> None:
    """Compile for the target for which the film was rendered."""
    if _target_of(saved) == PTX:
        return
    try:
        choose_target(_target_of(saved))
    except ValueError as error:
        raise FilmError(f"cannot resume {saved.path} here: {error}") from None


def _check_machine(saved: Checkpoint, machine: Mapping[str, str]) -> None:
    """Refuse where the samples to come would not be those of the film."""
    if saved.state.rounds[0].fingerprint == fingerprint_of(machine):
        return
    changed = differences(saved.origin.machine, machine)
    raise FilmError(
        f"cannot resume {saved.path}: here the same samples would have other bits\n"
        + listed(changed or ["kernel fingerprint: is another one"])
        + _whole(saved)
    )


def _whole(saved: Checkpoint) -> str:
    """How to have the picture of a checkpoint that cannot go on."""
    path = saved.path
    return (
        f"\nits picture is whole: alight merge {shlex.quote(path)} -o picture.exr, in Python "
        f'alight.merge({path!r}).save("picture.exr")'
    )


def _check_tables(saved: Checkpoint, job: Job) -> None:
    """Refuse a scene or a guide that comes out with other bits, though its text is the same."""
    if job.film.options.get(TABLES) != saved.state.rounds[0].options.get(TABLES):
        raise FilmError(
            f"cannot resume {saved.path}: NumPy gives the tables of its scene other bits here"
            + _whole(saved)
        )
    if job.film.options.get("guide") != saved.state.rounds[0].options.get("guide"):
        raise FilmError(f"cannot resume {saved.path}: its guide comes out otherwise here")


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
                "a scene that was moved is found again with --scene, and --root where it has one; "
                "in Python: scene=..., root=..." + _scripts(saved)
            ) from error
    if content_hash(flatten(scene)) != saved.state.rounds[0].scene_hash:
        raise FilmError(changed_scene(saved.path, saved.origin.content, scene))
    return scene


def _scripts(saved: Checkpoint) -> str:
    """Ask for the scripts that a checkpoint names."""
    plugins = Targets.noted(saved.origin.notes).plugins
    asked = " ".join(f"--plugin {shlex.quote(str(path))}" for path in plugins)
    named = f"{asked}, in Python plugins={[str(path) for path in plugins]}"
    return f"\na checkpoint runs no scripts; it was rendered with {named}" if plugins else ""


def _loaded(recipe, moved, root) -> Scene:
    if recipe is None:
        return load(moved, root=root)
    path, root = moved or recipe.path, recipe.root if root is None else root
    return load_again(replace(recipe, path=path, root=root))


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
