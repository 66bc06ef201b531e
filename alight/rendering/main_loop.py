"""The main loop: passes over tiles on a pool of threads, into one film."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

import alight
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.errors import OptionError, unknown_name
from alight.core.machine import fingerprint
from alight.films import CELL_SIZE, Film
from alight.integrators.aov import LAYERS
from alight.integrators.walk import make_settings
from alight.rendering.tile import Scratch, make_kernels, render_tile
from alight.rendering.tiles import tiles_of
from alight.scene import Scene, content_hash, flatten, load

#: A pass is long enough for its overhead not to show, short enough for progress to be seen.
PASS_SECONDS = 1.0

#: Further layers and their channels.
AOVS = {"direct": ("R", "G", "B"), "indirect": ("R", "G", "B"), **LAYERS}


@dataclass(frozen=True)
class Progress:
    """How far a render is.

    Attributes
    ----------
    phase : {"compile", "render"}
    done_samples, total_samples : int
        Samples of all pixels; the total is 0 where a time limit decides.
    seconds : float
        Since rendering began.
    film : Film or None
        May be read at any time.
    """

    phase: str
    done_samples: int
    total_samples: int
    seconds: float
    film: Film | None


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
    _check(spp, time_limit, seed, threads, replicates, spp_per_pass, first_sample, aovs)
    flat = flatten(scene)
    clock.lap("load")
    threads = threads or usable_processors()
    compiled = compile_scene(flat, content_hash(flat), aovs=_layers(aovs), threads=threads)
    clock.lap("bvh")
    replicates = replicates or flat.film.replicates
    job = Job(compiled, seed, threads, replicates, first_sample)
    job.start(progress)
    clock.lap("compile")
    spp = spp or (None if time_limit else scene.source.remarks.spp or 64)
    job.run(spp, time_limit, spp_per_pass, progress, cancel)
    clock.lap("render")
    job.film.stats = job.statistics(clock.laps)
    return job.film


class Job:
    """One render: a compiled scene, its kernel, the film, and what has been rendered so far."""

    def __init__(
        self, scene: CompiledScene, seed: int, threads: int, replicates: int, first_sample: int
    ) -> None:
        self.scene, self.threads = scene, threads
        self.settings = make_settings(scene.integrator, seed=seed, replicates=replicates)
        self.next_sample = first_sample
        self.rays = self.samples = 0
        self.film = Film(
            *scene.size,
            crop=scene.crop,
            replicates=replicates,
            aovs={name: AOVS[name] for name in scene.program.aovs},
            scene_hash=scene.content_hash,
            seed=seed,
            options=dict(scene.integrator),
            fingerprint=fingerprint(),
            version=alight.__version__,
        )
        self.tiles = tiles_of(self.film.crop)
        # The pool keeps its threads from pass to pass, and they their memory.
        self.local = threading.local()

    def start(self, progress: Callable | None) -> None:
        """Compile the kernel (or read it from the cache) by rendering no sample of one tile."""
        if progress:
            progress(Progress("compile", 0, 0, 0.0, None))
        self.kernels = make_kernels(self.scene)
        tile = self.tiles[0]
        render_tile(self.kernels, self.scene, self.settings, tile, _ranges(tile, 0, 0))

    def run(
        self,
        spp: int | None,
        time_limit: float | None,
        spp_per_pass: int | None,
        progress: Callable | None,
        cancel: threading.Event | None,
    ) -> None:
        """Passes over all tiles until spp, the time or a cancellation ends them."""
        begin = time.perf_counter()
        cancel = cancel or threading.Event()
        pixels = self.film.crop[2] * self.film.crop[3]
        total = (spp or 0) * pixels
        done = 0
        step = spp_per_pass or 1

        def report() -> None:
            if progress:
                seconds = time.perf_counter() - begin
                progress(Progress("render", self.samples, total, seconds, self.film))

        with ThreadPoolExecutor(self.threads) as pool:
            while not cancel.is_set() and (spp is None or done < spp):
                count = step if spp is None else min(step, spp - done)
                started = time.perf_counter()
                self._run_pass(pool, count, cancel, report)
                if cancel.is_set():
                    break
                self.next_sample += count
                done += count
                now = time.perf_counter()
                if spp_per_pass is None:
                    step = _next_step(step, now - started)
                if time_limit is not None:
                    left = time_limit - (now - begin)
                    if left <= 0:
                        break
                    if spp_per_pass is None:
                        step = max(1, min(step, int(left / (now - started) * count)))
        report()

    def _run_pass(
        self, pool: ThreadPoolExecutor, count: int, cancel: threading.Event, report: Callable
    ) -> None:
        def work(tile) -> None:
            if cancel.is_set():
                return
            ranges = _ranges(tile, self.next_sample, count)
            if not hasattr(local, "scratch"):
                local.scratch = Scratch()
            partial, rays = render_tile(
                self.kernels, self.scene, self.settings, tile, ranges, local.scratch
            )
            self.film.add_tile(partial)
            with lock:
                self.rays += rays
                self.samples += count * (tile.x1 - tile.x0) * (tile.y1 - tile.y0)

        lock, local = threading.Lock(), self.local
        futures = [pool.submit(work, tile) for tile in self.tiles]
        try:
            last = time.perf_counter()
            for future in futures:
                future.result()
                if time.perf_counter() - last > 0.1:
                    last = time.perf_counter()
                    report()
        except BaseException:
            # Tiles that run are finished and added; those that wait are dropped.
            cancel.set()
            pool.shutdown(wait=True, cancel_futures=True)
            report()
            raise

    def statistics(self, seconds: dict[str, float]) -> dict[str, Any]:
        """Times, rates and memory of this render."""
        rate = self.samples / seconds["render"] / 1e6 if seconds["render"] > 0 else 0.0
        pixels = self.film.crop[2] * self.film.crop[3]
        return {
            "seconds": {name: round(value, 6) for name, value in seconds.items()},
            "spp": self.samples / pixels,
            "samples": self.samples,
            "msamples_per_s": rate,
            "rays": self.rays,
            "threads": self.threads,
            "peak_rss_mb": peak_memory_mb(),
            "program": self.scene.program._asdict(),
            "accelerator": self.scene.stats,
        }


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


def _next_step(step: int, seconds: float) -> int:
    """Samples per pixel of the next pass: grows until a pass takes `PASS_SECONDS`."""
    return max(1, min(4 * step, int(step * PASS_SECONDS / max(seconds, 1e-9))))


def _ranges(tile, first: int, count: int) -> np.ndarray:
    """The same (first, count) for every cell that a tile touches."""
    rows = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
    columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
    return np.tile(np.array([first, count], np.int64), (rows, columns, 1))


def _check(spp, time_limit, seed, threads, replicates, spp_per_pass, first_sample, aovs) -> None:
    _whole("spp", spp, 1, 2**31 - 1)
    _whole("seed", seed, 0, 2**32 - 1)
    _whole("threads", threads, 1, 1024)
    _whole("replicates", replicates, 1, 1024)
    _whole("spp_per_pass", spp_per_pass, 1, 2**31 - 1)
    _whole("first_sample", first_sample, 0, 2**31 - 1)
    if time_limit is not None and not time_limit > 0:
        raise OptionError(f"time_limit: must be > 0 seconds, got {time_limit}")
    for name in aovs:
        if name not in AOVS:
            raise OptionError("aovs: " + unknown_name("layer", name, list(AOVS)))


def _layers(names: Sequence[str]) -> tuple[str, ...]:
    """Layers in our order, each once; direct and indirect light come together."""
    wanted = set(names)
    if wanted & {"direct", "indirect"}:
        wanted |= {"direct", "indirect"}
    return tuple(name for name in AOVS if name in wanted)


def _whole(name: str, value: Any, least: int, most: int) -> None:
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise OptionError(f"{name}: must be a whole number in [{least}, {most}], got {value!r}")


def usable_processors() -> int:
    """Processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def peak_memory_mb() -> float:
    """Largest resident size of this process so far, in units of 10^6 bytes; 0 where unknown."""
    try:
        import resource
    except ImportError:
        return 0.0
    import sys

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6
