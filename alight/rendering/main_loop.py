"""The main loop: passes over tiles, until the schedule says that it is enough.

::

    while the schedule has a goal:                      schedule.py
        cut a pass off what the films lack of it        passes.py
        render its tiles on all threads, or a cluster   executors.py
        now and then: report, write a checkpoint        checkpoint_writer.py
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from alight.compiled.recompile import compiled_of
from alight.compiled.scene import CompiledScene
from alight.films import Film
from alight.options.render import RenderOptions
from alight.rendering.checkpoints.checkpoint import Origin
from alight.rendering.checkpoints.checkpoint_writer import CheckpointWriter
from alight.rendering.executors.blocks import Executor
from alight.rendering.executors.selection import executor_of
from alight.rendering.job import Job, Progress
from alight.rendering.layers import layers_of
from alight.rendering.rare_light import RareLight
from alight.rendering.resources import usable_processors
from alight.rendering.schedules.passes import Pace
from alight.rendering.schedules.sample_bound import largest_sample
from alight.rendering.schedules.schedule import Schedule
from alight.rendering.schedules.selection import planned_spp, schedule_of, time_limit_of
from alight.rendering.sight import Sight
from alight.rendering.tiles.light_paths import LEAST_REPLICATES
from alight.rendering.training.guide_training import is_to_be_guided, length_of, trained
from alight.scene import FlatScene, Scene

#: Seconds between two reports of progress.
REPORT_EVERY = 0.1


def render_film(scene: Scene, options: RenderOptions, executor: Executor | None = None) -> Film:
    """Render a scene until its schedule, a time limit or a cancellation ends it.

    Parameters
    ----------
    scene : Scene
        With the options' changes in it.
    options : RenderOptions
        Those that decide samples, time, layers and checkpoints.
    executor : Executor, optional
        By default that which the options ask for.
    """
    clock = Clock()
    with executor or executor_of(options, options.device) as opened:
        return _render_with(opened, scene, options, clock)


def _render_with(executor: Executor, scene: Scene, options: RenderOptions, clock: Clock) -> Film:
    job = make_job(
        scene, schedule_of(options, scene.source.remarks.spp), clock,
        seed=options.seed, threads=options.threads, replicates=options.replicates,
        aovs=options.aovs, planned=planned_spp(options, scene.source.remarks.spp),
        machine=executor.machine,
    )  # fmt: skip
    job.time_limit = time_limit_of(options)
    if executor.is_shared:
        job.share_threads()
    writer = None
    if options.checkpoint is not None:
        origin = Origin.of(scene, options.notes, executor.machine)
        writer = CheckpointWriter(options.checkpoint, options.every, origin)
    return run(
        job, clock, executor, options.spp_per_pass, writer=writer, progress=options.progress,
        cancel=options.cancel,
    )  # fmt: skip


def make_job(
    scene: Scene,
    schedule: Schedule,
    clock: Clock,
    *,
    seed: int,
    threads: int | None,
    replicates: int | None,
    aovs: Sequence[str],
    planned: tuple[int | None, bool] = (None, False),
    again: Mapping[str, Any] | None = None,
    machine: Mapping[str, str] | None = None,
) -> Job:
    """Compile a scene for a job; for the rest see `job_of`."""
    threads = threads or usable_processors()
    made = compiled_of(scene, layers_of(aovs), threads, clock.lap)
    return job_of(
        made.flat, made.compiled, schedule, clock, seed=seed, threads=threads,
        replicates=replicates, planned=planned, again=again, machine=machine,
    )  # fmt: skip


def job_of(
    flat: FlatScene,
    compiled: CompiledScene,
    schedule: Schedule,
    clock: Clock,
    *,
    seed: int,
    threads: int,
    replicates: int | None,
    planned: tuple[int | None, bool] = (None, False),
    again: Mapping[str, Any] | None = None,
    machine: Mapping[str, str] | None = None,
) -> Job:
    """Make the job of a scene that is compiled already, and train its guide if it has one.

    Parameters
    ----------
    flat, compiled, schedule, clock, seed, threads, replicates
        As of `Job`.
    planned : (int or None, bool)
        Samples per pixel of the whole render, if anybody knows, and whether that is a limit.
    again : mapping, optional
        Options of the film that goes on.
    machine : mapping, optional
        As of `Job`.
    """
    if compiled.integrator.splats:
        replicates = replicates or max(flat.film.replicates, LEAST_REPLICATES)
    training = None
    if is_to_be_guided(compiled):
        compiled, training = trained(
            compiled, seed=seed, threads=threads, again=again,
            length=length_of(compiled, *planned),
        )  # fmt: skip
        clock.lap("training")
    replicates = replicates or flat.film.replicates
    return Job(
        compiled, schedule, seed=seed, threads=threads, replicates=replicates,
        largest_sample=largest_sample(flat, compiled.program.light_tree),
        training=training,
        rare_light=RareLight(Sight(flat, compiled)),
        machine=machine,
    )  # fmt: skip


def run(
    job: Job,
    clock: Clock,
    executor: Executor,
    spp_per_pass: int | None = None,
    *,
    writer: CheckpointWriter | None = None,
    progress: Callable[[Progress], None] | None = None,
    cancel: threading.Event | None = None,
) -> Film:
    """Compile the kernels, render until the end, and give the picture."""
    executor.check(job)
    if writer:
        # Before the first second is spent: a file that cannot be written is found out now.
        writer.write(job.state(copy=False))
    job.start(progress)
    executor.begin(job)
    clock.lap("compile")
    if progress:
        progress(job.progress())
    job.start_clock()

    reported = job.seconds

    def report() -> None:
        nonlocal reported
        if writer:
            writer.tick(job)
        if progress and job.seconds - reported > REPORT_EVERY:
            progress(job.progress(executor.note))
            reported = job.seconds

    try:
        pace = Pace(spp_per_pass, executor.pass_seconds)
        render_passes(job, executor, pace, cancel or threading.Event(), report)
        job.stop_clock()
        clock.lap("render")
        # Of a cancelled render, too: the ledger's pilot takes less time than writing the picture.
        job.record_biases()
        clock.lap("biases")
    finally:
        job.stop_clock()
        # The checkpoint first: whatever `progress` does, the samples are safe.
        if writer:
            writer.finish(job)
        if progress:
            progress(job.progress(executor.note))
    film = job.film
    film.stats = job.statistics(clock.laps) | executor.statistics()
    if writer:
        film.stats["checkpoint"] = writer.statistics()
    return film


def render_passes(
    job: Job, executor: Executor, pace: Pace, cancel: threading.Event, report: Callable[[], None]
) -> None:
    """Passes until the schedule's verdict, the end of the time or a cancellation."""
    work = job.next_work()
    while work is not None:
        left = job.seconds_left
        if cancel.is_set():
            return job.end("cancelled")
        # A time limit leaves time for one pass at least, or there would be no picture.
        if job.samples and left is not None and left <= 0:
            return job.end("time")
        count, started = pace.count(work.left), time.perf_counter()
        job.run_pass(executor, work.take(count), cancel, report)
        if not cancel.is_set():
            pace.adapt(count, time.perf_counter() - started, job.seconds_left)
            if not work.left:
                work = job.next_work()
    return None


class Clock:
    """Seconds of the phases of a render, measured one after the other."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """End the phase `name`."""
        now = time.perf_counter()
        self.laps[name] = now - self._last
        self._last = now
