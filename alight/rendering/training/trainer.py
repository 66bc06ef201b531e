"""The rounds of training a guide, each with twice the samples of the one before.

Paths come from both ends. Those of the camera tell what directions gained; those of the lights tell
where there is light that camera paths do not find.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from alight.compiled.scene import CompiledScene
from alight.films import CELL_SIZE
from alight.guiding.gain import Moments
from alight.guiding.light_records import add_arrivals
from alight.guiding.records import Totals, add_records
from alight.guiding.tables import LIGHT_RECORD, RECORD, Frame, Guide, LightLog, Log
from alight.guiding.tree import Tree
from alight.integrators.walk import GuidedSettings, Settings, make_settings
from alight.lights.tables import EmittingLights
from alight.rendering.seeds import LIGHT_TRAINING, TRAINING, seed_of_round
from alight.rendering.tiles.division import SMALL, tiles_of
from alight.rendering.tiles.tile import Scratch
from alight.rendering.tiles.tile_kernel import RAYS, Tile
from alight.rendering.tiles.tile_loop import render_tile_kernel
from alight.rendering.training.light_training import record_light_paths
from alight.rendering.training.training_plan import Signs, Step, TrainingPlan
from lanewise.jit import instantiate
from lanewise.view import View

#: After these rounds leaves learn how far their light comes from: first at all, then from where
#: most of it comes, which they know by then.
FOCUS_ROUND, REFOCUS_ROUND = 1, 3

#: Samples a pixel that a tile renders before its vertices are added; vertices a path, at first,
#: that there is room for.
AT_ONCE, DEPTH = 8, 24

#: Side of the blocks of pixels that share a mean; no block is darker than this part of the median.
BLOCK, DARKEST = 4, 0.01

#: Of the extent of all vertices, left free around them.
MARGIN = 1e-4

#: Most nodes of all quadtrees: 8 bytes each in the guide, and 64 a thread while it is trained.
MOST_NODES = 1 << 19


#: What a kernel logs.
L = TypeVar("L", Log, LightLog)

#: `Guide.box` of a guide with a single leaf.
EVERYWHERE = np.array([0, 0, 0, 1, 1, 1], np.float32)


@dataclass
class _Round:
    """What a round has found so far; `rays` is the number of its camera paths' rays."""

    totals: Totals
    moments: Moments
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    rays: int = 0


class Trainer:
    """The rounds of one training.

    Parameters
    ----------
    scene : CompiledScene
        With an untrained guide.
    threads : int

    Attributes
    ----------
    gain : float
        Noise of paths without a guide over that of guided ones, in relMSE(0.01), times the rays of
        the former over those of the latter; from the last round that was judged.
    pays : bool
        Whether the guide is to be used.
    rounds : int
        That were run.
    """

    def __init__(self, scene: CompiledScene, threads: int) -> None:
        assert scene.small_view is not None
        self.scene, self.threads, self.size = scene, threads, scene.small_view.size
        self.tables = scene.tables._replace(camera=scene.small_view.camera)
        self.tiles = tiles_of((0, 0, *self.size), SMALL)
        program = scene.program._replace(aovs=())
        self.kernel = instantiate(render_tile_kernel, program)
        self.add = instantiate(add_records)
        self.local = threading.local()
        self.unit = self.light_unit = 0.0
        self.emits = isinstance(scene.tables.lights, EmittingLights)
        if self.emits:
            self.light_kernel = instantiate(record_light_paths, program)
            self.add_light = instantiate(add_arrivals)
        # Threads append, which loses nothing.
        self.seconds: list[float] = []
        self.paths = self.vertices = self.arrivals = 0
        self.gain, self.pays, self.rounds = 1.0, True, 0

    def train(self, seed: int, plan: TrainingPlan) -> Guide:
        """Run the rounds of a plan, or as many as it takes to find that the guide does not pay."""
        tree = Tree.new()
        frame = framed(EVERYWHERE, np.ones((1, 1), np.float32), self.size)
        self._compile(tree, tree.guide(frame))
        rays_alone, signs = 0, Signs(self.gain, 0.0)
        began = time.thread_time()
        with ThreadPoolExecutor(self.threads) as pool:
            for number in range(plan.most_rounds):
                settings = make_settings(
                    self.scene.integrator,
                    seed=seed_of_round(seed, TRAINING + number),
                    replicates=1,
                    guide=tree.guide(frame),
                )
                assert isinstance(settings, GuidedSettings)
                found = self._round(pool, tree, settings, 2**number)
                if not number:
                    rays_alone = found.rays
                # The bounds stay: later rounds divide what the first has bounded.
                box = frame.box if number else _box(found)
                picture = _blocks(found.moments.squares / 2**number)
                frame = framed(box, picture, self.size)
                if plan.is_judged(number):
                    means = _around(found.moments.sums / 2**number)
                    fewer_rays = rays_alone * 2**number / found.rays
                    self.gain = found.moments.fewer_samples(means) * fewer_rays
                    signs = Signs(self.gain, found.moments.noise_without(means))
                self.rounds, step = number + 1, plan.step(number, signs)
                self.pays = step is not Step.GIVE_UP
                if not self.pays:
                    break
                if self.emits:
                    self._light_round(pool, tree.guide(frame), found.totals, seed, number)
                tree.learn(found.totals, self.unit, asked=number > 0)
                if number == FOCUS_ROUND:
                    tree = tree.focused(found.totals, box)
                elif number == REFOCUS_ROUND:
                    tree = tree.refocused(found.totals, box)
                if step is Step.USE:
                    break
                tree = tree.grown(found.totals.leaves.shaped[:, 0], MOST_NODES)
        self.seconds.append(time.thread_time() - began)
        return tree.guide(frame)

    def _compile(self, tree: Tree, guide: Guide) -> None:
        """Run all kernels without a sample: what they take from now on is training."""
        settings = make_settings(self.scene.integrator, seed=0, replicates=1, guide=guide)
        assert isinstance(settings, GuidedSettings)
        self._tile(settings, self.tiles[0], 0, 0)
        self.add(guide, tree.densities(), settings.log, tree.empty_totals(), np.float32(1.0))
        if self.emits:
            # Light paths follow no guide: their settings are of another type.
            alone = make_settings(self.scene.integrator, seed=0, replicates=1)
            log = self._light_tile(alone, self.tiles[0], 0, 0)
            self.add_light(guide, log, tree.empty_totals(), np.float32(1.0))
        self.seconds.clear()

    def _round(
        self, pool: ThreadPoolExecutor, tree: Tree, settings: GuidedSettings, samples: int
    ) -> _Round:
        found = _Round(
            tree.empty_totals(),
            Moments(*np.zeros((3, *self.size[::-1])), count=samples),
            np.full(3, np.inf, np.float32),
            np.full(3, -np.inf, np.float32),
        )
        densities = tree.densities()
        for first in range(0, samples, AT_ONCE):
            count = min(AT_ONCE, samples - first)
            render = partial(self._tile, settings, first=first, count=count)
            logs, rays = zip(*pool.map(render, self.tiles), strict=True)
            found.rays += sum(rays)
            if self.unit == 0.0:
                self.unit = _typical_gain(logs)
            shares = [logs[i :: self.threads] for i in range(self.threads)]
            for totals in pool.map(
                lambda part: self._sums(settings.guide, densities, tree, part), shares
            ):
                found.totals.cells.array[:] += totals.cells.array
                found.totals.leaves.array[:] += totals.leaves.array
                found.totals.middles.array[:] += totals.middles.array
            for tile, log in zip(self.tiles, logs, strict=True):
                _look(found, tile, log)
                self.paths += log.ends.size
                self.vertices += int(log.count.array[0])
        return found

    def _tile(
        self, settings: GuidedSettings, tile: Tile, first: int, count: int
    ) -> tuple[Log, int]:
        """Render samples of a tile: what their paths met, and their rays."""
        began = time.thread_time()
        samples = _pixels(tile) * count
        window = [tile.x0, tile.y0, tile.x1 - tile.x0, first, count, settings.replicates]
        if not hasattr(self.local, "scratch"):
            self.local.scratch = Scratch()

        def run(rows: View, counted: View) -> Log:
            ends, without = (View(np.zeros(samples, np.float32)) for _ in range(2))
            log = Log(rows, counted, ends, without, View(np.array(window, np.uint32)))
            film = self.local.scratch.film(settings, tile, False)
            ranges = _ranges(tile, first, count)
            self.kernel(self.tables, settings._replace(log=log), tile, ranges, film)
            rays[0] = int(film.tally.array[RAYS])
            return log

        rays = [0]
        log = _logged(run, samples, RECORD)
        self.seconds.append(time.thread_time() - began)
        return log, rays[0]

    def _light_round(
        self, pool: ThreadPoolExecutor, guide: Guide, totals: Totals, seed: int, number: int
    ) -> None:
        """Trace light paths, as many as the round has camera paths, and add where they arrive."""
        settings = make_settings(
            self.scene.integrator, seed=seed_of_round(seed, LIGHT_TRAINING + number), replicates=1
        )
        for first in range(0, 2**number, AT_ONCE):
            count = min(AT_ONCE, 2**number - first)
            trace = partial(self._light_tile, settings, first=first, count=count)
            logs = list(pool.map(trace, self.tiles))
            if self.light_unit == 0.0:
                self.light_unit = _typical([log.rows.shaped[:, 6] for log in logs])
            shares = [logs[i :: self.threads] for i in range(self.threads)]
            for part in pool.map(lambda part: self._light_sums(guide, totals, part), shares):
                totals.lit.array[:] += part.lit.array
                totals.near.array[:] += part.near.array
            self.arrivals += sum(int(log.count.array[0]) for log in logs)

    def _light_tile(self, settings: Settings, tile: Tile, first: int, count: int) -> LightLog:
        began = time.thread_time()

        def run(rows: View, counted: View) -> LightLog:
            log = LightLog(rows, counted)
            self.light_kernel(self.tables, settings, tile, _ranges(tile, first, count), log)
            return log

        log = _logged(run, _pixels(tile) * count, LIGHT_RECORD)
        self.seconds.append(time.thread_time() - began)
        return log

    def _light_sums(self, guide: Guide, totals: Totals, logs: Sequence[LightLog]) -> Totals:
        began = time.thread_time()
        mine = totals._replace(lit=_zeros_like(totals.lit), near=_zeros_like(totals.near))
        for log in logs:
            if log.rows.size:
                self.add_light(guide, log, mine, np.float32(self.light_unit))
        self.seconds.append(time.thread_time() - began)
        return mine

    def _sums(self, guide: Guide, densities: View, tree: Tree, logs: Sequence[Log]) -> Totals:
        began = time.thread_time()
        totals = tree.empty_totals()
        for log in logs:
            if log.rows.size:
                self.add(guide, densities, log, totals, np.float32(self.unit or 1.0))
        self.seconds.append(time.thread_time() - began)
        return totals


def _look(found: _Round, tile: Tile, log: Log) -> None:
    """Add a tile's pixels to the moments, and its vertices to the bounds."""
    shape = tile.y1 - tile.y0, tile.x1 - tile.x0, -1
    ends = log.ends.array.reshape(shape).astype(np.float64)
    # As in the film: what is no number is black.
    ends = np.where(np.isfinite(ends), ends, 0.0)
    window = slice(tile.y0, tile.y1), slice(tile.x0, tile.x1)
    found.moments.sums[window] += ends.sum(2)
    found.moments.squares[window] += (ends**2).sum(2)
    without = log.without.array.reshape(shape).astype(np.float64)
    # Too rare to be a number: at least as noisy as it is with the guide.
    without = np.where(np.isfinite(without), without, ends**2)
    found.moments.without[window] += without.sum(2)
    p = log.rows.shaped[:, :3]
    if len(p):
        found.low, found.high = np.minimum(found.low, p.min(0)), np.maximum(found.high, p.max(0))


def _box(found: _Round) -> NDArray[np.float32]:
    """`Guide.box` around all vertices of a round."""
    if not (found.low <= found.high).all():
        return EVERYWHERE
    extent = found.high - found.low
    # Light paths meet the same surfaces, at points that are rounded otherwise.
    margin = max(float(extent.max()) * MARGIN, 1e-30)
    return np.concatenate([found.low - margin, 1.0 / (extent + 2.0 * margin)]).astype(np.float32)


def _blocks(squares: NDArray[np.float64]) -> NDArray[np.float32]:
    """Root mean square of blocks of pixels, none of them dark."""
    means = _means_of_blocks(squares)
    # Never 0: then no path is worth following, and none is ended.
    least = max(DARKEST * float(np.median(means)), DARKEST**2 * float(means.max()), 1e-30)
    return np.sqrt(np.maximum(means, least)).astype(np.float32)


def _means_of_blocks(pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    height, width = pixels.shape
    rows, columns = -(-height // BLOCK), -(-width // BLOCK)
    padded = np.pad(pixels, ((0, rows * BLOCK - height), (0, columns * BLOCK - width)), "edge")
    return padded.reshape(rows, BLOCK, columns, BLOCK).mean((1, 3))


def _around(pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each pixel's block's mean."""
    height, width = pixels.shape
    means = np.repeat(np.repeat(_means_of_blocks(pixels), BLOCK, axis=0), BLOCK, axis=1)
    return means[:height, :width]


def framed(box: NDArray, picture: NDArray, size: tuple[int, int]) -> Frame:
    """A frame for films of this size."""
    rows, columns = picture.shape
    scale = np.array([columns / size[0], rows / size[1]], np.float32)
    return Frame(box, picture, np.array([columns, *scale.view(np.uint32)], np.uint32))


def _typical_gain(logs: Sequence[Log]) -> float:
    """As `_typical`, of what vertices gain."""
    gains: list[Any] = []
    for log in logs:
        rows = log.rows.shaped
        end = log.ends.array[rows[:, 11].copy().view(np.uint32)]
        with np.errstate(all="ignore"):
            gains.append(rows[:, 8] * (end - rows[:, 10]) / rows[:, 9])
    return _typical(gains)


def _typical(parts: Sequence[NDArray[np.float32]]) -> float:
    """A power of two near the median of all positive values; 0 if there are none."""
    values = np.concatenate(parts)
    values = values[np.isfinite(values) & (values > 0.0)]
    return float(2.0 ** np.floor(np.log2(np.median(values)))) if len(values) else 0.0


def _zeros_like(table: View) -> View:
    return View(np.zeros_like(table.shaped))


def _pixels(tile: Tile) -> int:
    return (tile.x1 - tile.x0) * (tile.y1 - tile.y0)


def _ranges(tile: Tile, first: int, count: int) -> View:
    """The same samples of all pixels of a tile, as `render_tile_kernel` takes them."""
    rows = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
    columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
    return View(np.tile(np.array([first, count], np.int64), (rows, columns, 1)))


def _logged(run: Callable[[View, View], L], paths: int, size: int) -> L:
    """What a kernel logs of so many paths; again, with more room, if it did not fit.

    A log without room would depend on which paths came first, and so on the packets' width.
    """
    room = paths * DEPTH
    while True:
        log = run(View(np.zeros((room, size), np.float32)), View(np.zeros(2, np.int64)))
        found, lost = log.count.array
        if not lost:
            return log._replace(rows=View(log.rows.shaped[:found].copy()))
        room = int(found + lost)
