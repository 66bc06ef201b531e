"""A job: a compiled scene, its kernels, the films, and a schedule that says what comes next."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from alight.compiled.digest import digest_of_tables
from alight.compiled.scene import CompiledScene
from alight.core.version import VERSION
from alight.films import Film, PartialFilm, merging
from alight.integrators.walk import make_settings
from alight.rendering import depth_cap
from alight.rendering.executors.blocks import Block, Executor
from alight.rendering.layers import AOVS
from alight.rendering.rare_light import RareLight
from alight.rendering.resources import peak_memory_mb
from alight.rendering.schedules.passes import Work, ranges_of
from alight.rendering.schedules.schedule import Goal, Schedule, Verdict
from alight.rendering.seeds import PILOT, seed_of_round
from alight.rendering.tiles.division import tile_size, tiles_of
from alight.rendering.tiles.light_paths import check_light_paths, parts_of
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.training.guide_training import Training
from alight.rendering.unfound_light import unfound_light
from lanewise.application import variable
from lanewise.kept_files import lost
from lanewise.machine import PORTABLE, cache_folder, fingerprint, fingerprint_of, target

_LOG = logging.getLogger("alight")

#: A part of the identity of films that machines of several kinds may go on with.
TABLES = "tables"


@dataclass(frozen=True)
class Progress:
    """How far a render is.

    Attributes
    ----------
    phase : {"compile", "render"}
    done_samples, total_samples : int
        Samples of all pixels; the total is 0 where a time limit or a rule decides.
    seconds : float
        Of rendering, those before a resumed checkpoint too.
    film : Film
        May be read at any time; while kernels are compiled it has no samples, but its warnings.
    note : str
        About who renders, where it is not this process.
    """

    phase: str
    done_samples: int
    total_samples: int
    seconds: float
    film: Film
    note: str = ""


class JobState(NamedTuple):
    """One moment of a job: all that resuming it needs, besides the scene.

    Attributes
    ----------
    rounds : list of Film
        Copies. Their cells say which samples they hold, so the moment may lie within a pass.
    schedule : str
        Name of its class.
    schedule_state : dict
        What the class makes it from again.
    goal : Goal or None
        What the schedule asked for last.
    rays, samples : int
    seconds : float
        Of rendering.
    time_limit : float or None
        Of the whole render, in the same seconds.
    """

    rounds: list[Film]
    schedule: str
    schedule_state: dict[str, Any]
    goal: Goal | None
    rays: int
    samples: int
    seconds: float
    time_limit: float | None


class Job:
    """One render: what it works with and what has been rendered so far.

    Parameters
    ----------
    scene : CompiledScene
    schedule : Schedule
    seed, threads, replicates : int
    largest_sample : float, optional
        Bound of a sample's value, for its films.
    training : Training, optional
        Of the scene's guide.
    rare_light : RareLight, optional
        Of the scene; otherwise it has none.
    machine : mapping of str to str, optional
        Who renders (`Executor.machine`); by default this process.

    Raises
    ------
    OptionError
        If paths start at lights, and cannot make this picture
        (`alight.rendering.tiles.light_paths`).

    Attributes
    ----------
    time_limit : float or None
        Start no pass after this many `seconds`.
    """

    def __init__(
        self,
        scene: CompiledScene,
        schedule: Schedule,
        *,
        seed: int,
        threads: int,
        replicates: int,
        largest_sample: float | None = None,
        training: Training | None = None,
        rare_light: RareLight | None = None,
        machine: Mapping[str, str] | None = None,
    ) -> None:
        self._fingerprint = fingerprint() if machine is None else fingerprint_of(machine)
        self.training = training
        self.rare_light = rare_light or RareLight()
        self.scene, self.schedule, self.threads = scene, schedule, threads
        self.seed, self.replicates, self.largest_sample = seed, replicates, largest_sample
        self.settings = make_settings(
            scene.integrator, seed=seed, replicates=replicates, guide=scene.guide
        )
        self.rounds = [self._new_film()]
        self.goal: Goal | None = None
        self.verdict: Verdict | None = None
        self.time_limit: float | None = None
        self.rays = self.samples = 0
        self._earlier = self._restored = 0.0
        self._begin: float | None = None
        window = self.rounds[0].crop
        self.splats = scene.integrator.splats
        if self.splats:
            check_light_paths(scene, schedule)
        self.tiles = parts_of(window, threads) if self.splats else tiles_of(window)
        self._lock = threading.Lock()

    def _new_film(self, round: int = 0) -> Film:
        scene = self.scene
        film = Film(
            *scene.size,
            crop=scene.crop,
            replicates=self.replicates,
            aovs={name: AOVS[name] for name in scene.program.aovs},
            surfaces=scene.surfaces.names if scene.surfaces else None,
            scene_hash=scene.content_hash,
            seed=seed_of_round(self.seed, round),
            options=dict(scene.integrator) | self._guide() | self._tables(),
            fingerprint=self._fingerprint,
            version=VERSION,
        )
        film.recorded = depth_cap.unmeasured(scene.integrator) + unfound_light(scene)
        film.scene_warnings, film.largest_sample = tuple(scene.warnings), self.largest_sample
        film.by_chance = self.scene.integrator.finds_light_by_chance
        # Only a promise asks its film.
        film.rare_light = self.rare_light.everywhere if self.schedule.promises else None
        film.shares_paths = scene.integrator.splats
        return film

    def _guide(self) -> dict[str, Any]:
        """The guide as a part of a film's identity."""
        return self.training.identity if self.training else {}

    def _tables(self) -> dict[str, str]:
        """What kernels read, as a part of the identity of a film that any machine may go on with.

        Tables are NumPy's work, whose functions may round otherwise on another processor.
        """
        read = (self.scene.tables, self.scene.ground) if self.scene.ground else self.scene.tables
        return {TABLES: digest_of_tables(read)} if target() == PORTABLE else {}

    # ------------------------------------------------------------------------ saved and restored

    def state(self, copy: bool = True) -> JobState:
        """Give this moment, from the thread that runs the job.

        Tiles may be rendered meanwhile; without a copy, none while the state is in use.
        """
        rounds = [film.snapshot() for film in self.rounds] if copy else list(self.rounds)
        with self._lock:
            rays, samples = self.rays, self.samples
        schedule = self.schedule
        return JobState(
            rounds=rounds,
            schedule=schedule.name,
            schedule_state=schedule.state(),
            goal=self.goal,
            rays=rays,
            samples=samples,
            seconds=self.seconds,
            time_limit=self.time_limit,
        )

    def restore(self, state: JobState, goal: Goal | None) -> None:
        """Go on from a state: with its goal, or with None, to ask this job's own schedule."""
        self.rounds, self.goal = list(state.rounds), goal
        for film in self.rounds:
            film.scene_warnings = tuple(self.scene.warnings)
            # It may have been begun without a promise, for which nobody looked.
            if self.schedule.promises:
                film.rare_light = self.rare_light.everywhere
        self.rays, self.samples = state.rays, state.samples
        self._earlier = self._restored = state.seconds

    # ------------------------------------------------------------------------ progress

    def start_clock(self) -> None:
        """Rendering begins now."""
        self._begin = time.perf_counter()

    def stop_clock(self) -> None:
        """Rendering has ended."""
        self._earlier, self._begin = self.seconds, None

    @property
    def seconds(self) -> float:
        """Of rendering so far, those before a restored state too."""
        running = 0.0 if self._begin is None else time.perf_counter() - self._begin
        return self._earlier + running

    @property
    def film(self) -> Film:
        """The picture so far."""
        return self.schedule.picture(self.rounds)

    def progress(self, note: str = "") -> Progress:
        """How far the job is."""
        _, _, width, height = self.rounds[0].crop
        total = round((self.schedule.total_spp or 0) * width * height)
        return Progress("render", self.samples, total, self.seconds, self.film, note)

    @property
    def seconds_left(self) -> float | None:
        """Until the time limit, if there is one."""
        return None if self.time_limit is None else self.time_limit - self.seconds

    # ------------------------------------------------------------------------ rendering

    def share_threads(self) -> None:
        """Cut larger tiles, which cost less: another job fills the threads when these run out."""
        if not self.splats:
            window = self.rounds[0].crop
            self.tiles = tiles_of(window, tile_size(window, self.threads))

    def start(self, progress: Callable | None) -> None:
        """Compile the kernel (or read it from the cache) by rendering no sample of one tile."""
        if progress:
            progress(Progress("compile", 0, 0, 0.0, self.film))
        self.kernels = make_kernels(self.scene)
        tile = self.tiles[0]
        nothing = np.zeros((*self.rounds[0].cells.shape, 2), np.int64)
        render_tile(self.kernels, self.scene, self.settings, tile, ranges_of(tile, nothing))
        if problem := lost():
            _LOG.warning(
                "the compiled kernels cannot be kept in %s (%s): the next render compiles them "
                "again; set %s to a folder that can be written",
                cache_folder().parent, problem.strerror or problem, variable("CACHE"),
            )  # fmt: skip

    def next_work(self) -> Work | None:
        """What to render now; None when the schedule has given its verdict."""
        while True:
            if self.goal is not None:
                work = Work(self.goal, self.rounds[self.goal.round])
                if work.left:
                    return work
            answer = self.schedule.next(self.rounds)
            if isinstance(answer, Verdict):
                self.verdict = answer
                return None
            self.goal = answer
            if answer.round == len(self.rounds):
                self.rounds.append(self._new_film(answer.round))

    def record_biases(self) -> None:
        """Enter into the picture's ledger what is biased, and measure what can be measured."""
        film = self.film
        # The pilot looks at single pixels; light paths belong to none.
        if self.samples and not self.splats:
            seed = seed_of_round(self.seed, PILOT)
            film.recorded = depth_cap.measured(self, seed) + unfound_light(self.scene)
            film.recorded += self.schedule.biases(self.rounds)

    def end(self, word: str) -> None:
        """Something else than the schedule ends the render: "time" or "cancelled"."""
        self.verdict = self.schedule.cut_short(self.rounds, word)

    def run_pass(
        self,
        executor: Executor,
        ranges: np.ndarray,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render (first, count) samples of each cell, shape (cells_y, cells_x, 2).

        `report` is called after every tile.

        Raises
        ------
        BaseException
            Whatever a thread or `report` raised, once the tiles that ran are in the film.
        """
        assert self.goal is not None
        film = self.rounds[self.goal.round]
        settings = self.settings._replace(seed=film.seed)
        # Each light path may add to any pixel: a picture of some of a pass would lack the others.
        apart = self.splats and not executor.adds_whole_samples
        target = film.empty_like() if apart else film

        def add(partial: PartialFilm, rays: int) -> None:
            samples = int(partial.counts.sum())
            target.add_tile(partial, self.kernels.add_rows)
            with self._lock:
                self.rays += rays
                self.samples += samples

        blocks = [Block(tile, ranges_of(tile, ranges)) for tile in self.tiles]
        wanted = [block for block in blocks if block.ranges[..., 1].any()]
        executor.render(settings, wanted, add, cancel, report)
        if apart and not cancel.is_set():
            merging.add(film, target)

    def statistics(self, seconds: dict[str, float]) -> dict[str, Any]:
        """Times, rates and memory of this render, of its parts before a checkpoint too."""
        seconds = {**seconds, "render": self.seconds}
        if self._restored:
            seconds["resumed_at"] = self._restored
        rate = self.samples / seconds["render"] / 1e6 if seconds["render"] > 0 else 0.0
        _, _, width, height = self.rounds[0].crop
        verdict = self.verdict or Verdict("cancelled")
        return {
            "seconds": {name: round(value, 6) for name, value in seconds.items()},
            "spp": self.samples / (width * height),
            "samples": self.samples,
            "msamples_per_s": rate,
            "rays": self.rays,
            "threads": self.threads,
            "peak_rss_mb": peak_memory_mb(),
            "program": self.scene.program._asdict(),
            "accelerator": self.scene.stats,
            **({"guide": self.training.state()} if self.training else {}),
            "biases": [bias.state() for bias in self.film.biases],
            "verdict": {"word": verdict.word, "line": verdict.line, **verdict.figures},
        }
