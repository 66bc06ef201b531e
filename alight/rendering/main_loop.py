"""The main loop: passes over tiles on a pool of threads, until the schedule says that it is enough.

::

    while the schedule has a goal:                      schedule.py
        cut a pass off what the films lack of it        passes.py
        render its tiles on all threads                 job.py
        now and then: report, write a checkpoint        checkpoint_writer.py
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from alight.compiled.scene import compile_scene
from alight.films import Film
from alight.formats import load
from alight.rendering.checkpoint import Origin
from alight.rendering.checkpoint_writer import CheckpointWriter
from alight.rendering.job import Job, Progress
from alight.rendering.largest_sample import largest_sample
from alight.rendering.options import check_options, layers_of
from alight.rendering.passes import Pace
from alight.rendering.resources import usable_processors
from alight.rendering.schedule import Schedule, Uniform
from alight.scene import Scene, content_hash, flatten

#: Seconds between two checkpoints, and between two reports of progress.
EVERY, REPORT_EVERY = 60.0, 0.1


def render(
    scene: Scene | str | os.PathLike,
    *,
    spp: int | None = None,
    time_limit: float | None = None,
    seed: int = 0,
    threads: int | None = None,
    replicates: int | None = None,
    spp_per_pass: int | None = None,
    first_sample: int = 0,
    aovs: Sequence[str] = (),
    schedule: Schedule | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    every: float = EVERY,
    notes: Mapping[str, Any] | None = None,
    progress: Callable[[Progress], None] | None = None,
    cancel: threading.Event | None = None,
) -> Film:
    """Render a scene.

    Parameters
    ----------
    scene : Scene, path or name of a built-in scene
    spp : int, optional
        Samples per pixel; what the scene's file asks for, or 64, if no time limit is given either.
    time_limit : float, seconds, optional
        Start no pass after this time.
    seed : int in [0, 2^32)
        Another seed, other random numbers.
    threads : int, optional
        All processors that this process may use by default. Does not change the picture.
    replicates : int, optional
        R of the film, the scene's ``film.replicates`` (4) by default: independent scrambles whose
        spread gives the error bars.
    spp_per_pass : int, optional
        Samples per pixel between two reports of progress. Does not change the picture.
    first_sample : int, default 0
        Index of the first sample, to extend an earlier film (`Film.merge`).
    aovs : sequence of str
        Further layers: "direct" (depth <= 2) and "indirect", whose sum is the picture, and those
        of `alight.integrators.aov.LAYERS`.
    schedule : Schedule, optional
        Decides which samples are rendered, in place of `spp`.
    checkpoint : path, optional
        File to write the state of the render to, at the start, from time to time and at the end,
        also when it is cancelled or fails: `alight.resume` continues from there.
    every : float, seconds, default 60
        Time between two checkpoints.
    notes : mapping of str to plain JSON, optional
        Kept in checkpoints, for whoever resumes.
    progress : callable, optional
        Called with a `Progress` from time to time, in the calling thread.
    cancel : threading.Event, optional
        Ends the render early when set; the film holds what was finished.

    Returns
    -------
    Film
        With the times in ``film.stats``.

    Raises
    ------
    AlightError
        For a scene or an option that is wrong.
    KeyboardInterrupt
        After the running tiles are in the film, which `progress` has been given.
    """
    clock = Clock()
    if not isinstance(scene, Scene):
        scene = load(scene)
    check_options(
        spp=spp, time_limit=time_limit, seed=seed, threads=threads, replicates=replicates,
        spp_per_pass=spp_per_pass, first_sample=first_sample, aovs=aovs, every=every,
    )  # fmt: skip
    if schedule is None:
        spp = spp or (None if time_limit else scene.source.remarks.spp or 64)
        schedule = Uniform(first_sample, spp)
    job = make_job(
        scene, schedule, clock, seed=seed, threads=threads, replicates=replicates, aovs=aovs
    )
    job.time_limit = time_limit
    writer = None
    if checkpoint is not None:
        writer = CheckpointWriter(checkpoint, every, Origin.of(scene, notes or {}))
    return run(job, clock, Pace(spp_per_pass), writer=writer, progress=progress, cancel=cancel)


def make_job(
    scene: Scene,
    schedule: Schedule,
    clock: Clock,
    *,
    seed: int,
    threads: int | None,
    replicates: int | None,
    aovs: Sequence[str],
) -> Job:
    """Compile a scene for a job."""
    flat = flatten(scene)
    clock.lap("load")
    threads = threads or usable_processors()
    compiled = compile_scene(flat, content_hash(flat), aovs=layers_of(aovs), threads=threads)
    clock.lap("bvh")
    replicates = replicates or flat.film.replicates
    return Job(
        compiled, schedule, seed=seed, threads=threads, replicates=replicates,
        largest_sample=largest_sample(flat), notes=flat.notes,
    )  # fmt: skip


def run(
    job: Job,
    clock: Clock,
    pace: Pace,
    *,
    writer: CheckpointWriter | None = None,
    progress: Callable[[Progress], None] | None = None,
    cancel: threading.Event | None = None,
) -> Film:
    """Compile the kernels, render until the end, and give the picture."""
    if writer:
        # Before the first second is spent: a file that cannot be written is found out now.
        writer.write(job.state(copy=False))
    job.start(progress)
    clock.lap("compile")
    job.start_clock()

    reported = job.seconds

    def report() -> None:
        nonlocal reported
        if writer:
            writer.tick(job)
        if progress and job.seconds - reported > REPORT_EVERY:
            progress(job.progress())
            reported = job.seconds

    try:
        _passes(job, pace, cancel or threading.Event(), report)
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
            progress(job.progress())
    film = job.film
    film.stats = job.statistics(clock.laps)
    if writer:
        film.stats["checkpoint"] = writer.statistics()
    return film


def _passes(job: Job, pace: Pace, cancel: threading.Event, report: Callable[[], None]) -> None:
    """Passes until the schedule's verdict, the end of the time or a cancellation."""
    with ThreadPoolExecutor(job.threads) as pool:
        work = job.next_work()
        while work is not None:
            left = job.seconds_left
            if cancel.is_set():
                return job.end("cancelled")
            # A time limit leaves time for one pass at least, or there would be no picture.
            if job.samples and left is not None and left <= 0:
                return job.end("time")
            count, started = pace.count(work.left), time.perf_counter()
            job.run_pass(pool, work.take(count), cancel, report)
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
