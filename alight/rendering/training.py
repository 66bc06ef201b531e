"""Training a guide: rounds of paths, each with twice the samples of the one before.

Paths start at a small picture of the same view, whatever the film's size, so that the guide does
not depend on how much is rendered. Their samples are thrown away: the picture is unbiased, given
the guide, and each of its samples independent of all others, given the guide. A guide is a function
of scene and seed alone; a resumed render makes its own again.
"""

from __future__ import annotations

import hashlib
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.compiled.scene import CompiledScene
from alight.films import CELL_SIZE
from alight.guiding.records import Totals, add_records
from alight.guiding.tables import GUIDED, RECORD, Frame, Guide, Log
from alight.guiding.tree import Tree
from alight.integrators.walk import GuidedSettings, make_settings
from alight.rendering.seeds import TRAINING, seed_of_round
from alight.rendering.tile import Scratch
from alight.rendering.tile_kernel import Tile, render_tile_kernel
from alight.rendering.tiles import SMALL, tiles_of
from lanewise.jit import instantiate
from lanewise.view import View

#: Rounds of training: 1, 2, 4 ... samples a pixel.
ROUNDS = 7

#: Samples a pixel that a tile renders before its vertices are added; vertices of a path that are.
AT_ONCE, DEPTH = 8, 24

#: Side of the blocks of pixels that share a mean; no block is darker than this part of the median.
BLOCK, DARKEST = 4, 0.01

#: Most nodes of all quadtrees: 8 bytes each in the guide, and 32 a thread while it is trained.
MOST_NODES = 1 << 19


#: `Guide.box` of a guide with a single leaf.
_EVERYWHERE = np.array([0, 0, 0, 1, 1, 1], np.float32)


class Training(NamedTuple):
    """What training a guide took.

    Attributes
    ----------
    cpu_seconds : float
        Of all threads.
    paths, vertices : int
        That the rounds followed and learnt from.
    leaves, nodes, bytes : int
        Of the guide.
    hash : str
        Names the guide.
    """

    cpu_seconds: float
    paths: int
    vertices: int
    leaves: int
    nodes: int
    bytes: int
    hash: str


def is_to_be_guided(scene: CompiledScene) -> bool:
    """Whether a scene asks for a guide."""
    return scene.small_view is not None


def with_guide(scene: CompiledScene, guide: Guide) -> CompiledScene:
    """A scene whose paths follow a guide."""
    options = tuple(option for option in scene.program.options if option[0] != GUIDED)
    program = scene.program._replace(options=(*options, (GUIDED, True)))
    return replace(scene, program=program, guide=guide)


def untrained(scene: CompiledScene) -> CompiledScene:
    """A scene with a guide that is never asked: it has the kernels of a trained one."""
    frame = _framed(_EVERYWHERE, np.ones((1, 1), np.float32), scene.size)
    return with_guide(scene, Tree.new().guide(frame))


def trained(
    scene: CompiledScene, *, seed: int, threads: int, rounds: int = ROUNDS
) -> tuple[CompiledScene, Training]:
    """Train a guide for a scene that asks for one.

    Parameters
    ----------
    scene : CompiledScene
    seed : int
        Of the render; training has random numbers of its own.
    threads : int
        They do not change the guide.
    rounds : int

    Returns
    -------
    CompiledScene
        With the guide.
    Training
    """
    trainer = _Trainer(scene, threads)
    guide = trainer.train(seed, rounds)
    arrays = [table.array for table in guide]
    digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()
    # Trained in another picture: the film has other pixels.
    film = _framed(guide.box.array, guide.picture.shaped, scene.size)
    guide = guide._replace(blocks=View(film.blocks))
    took = Training(
        cpu_seconds=sum(trainer.seconds),
        paths=trainer.paths,
        vertices=trainer.vertices,
        leaves=guide.roots.size,
        nodes=len(guide.nodes.shaped),
        bytes=sum(array.nbytes for array in arrays),
        hash=digest[:16],
    )
    return with_guide(scene, guide), took


@dataclass
class _Round:
    """What a round has found so far; `squares` are sums of squared luminances of pixels."""

    totals: Totals
    squares: NDArray[np.float64]
    low: NDArray[np.float32]
    high: NDArray[np.float32]


class _Trainer:
    """The rounds of one training."""

    def __init__(self, scene: CompiledScene, threads: int) -> None:
        assert scene.small_view is not None
        self.scene, self.threads, self.size = scene, threads, scene.small_view.size
        self.tables = scene.tables._replace(camera=scene.small_view.camera)
        self.tiles = tiles_of((0, 0, *self.size), SMALL)
        self.kernel = instantiate(render_tile_kernel, untrained(scene).program._replace(aovs=()))
        self.add = instantiate(add_records)
        self.local = threading.local()
        self.unit = 0.0
        # Threads append, which loses nothing.
        self.seconds: list[float] = []
        self.paths = self.vertices = 0

    def train(self, seed: int, rounds: int) -> Guide:
        """Run all rounds."""
        began = time.thread_time()
        tree = Tree.new()
        frame = _framed(_EVERYWHERE, np.ones((1, 1), np.float32), self.size)
        with ThreadPoolExecutor(self.threads) as pool:
            for number in range(rounds):
                settings = make_settings(
                    self.scene.integrator,
                    seed=seed_of_round(seed, TRAINING + number),
                    replicates=1,
                    guide=tree.guide(frame),
                )
                assert isinstance(settings, GuidedSettings)
                found = self._round(pool, tree, settings, 2**number)
                # The bounds stay: later rounds divide what the first has bounded.
                box = frame.box if number else _box(found)
                picture = _blocks(found.squares / 2**number)
                frame = _framed(box, picture, self.size)
                tree.learn(found.totals, self.unit, asked=number > 0)
                if number + 1 < rounds:
                    tree = tree.grown(found.totals.leaves.shaped[:, 0], MOST_NODES)
        self.seconds.append(time.thread_time() - began)
        return tree.guide(frame)

    def _round(
        self, pool: ThreadPoolExecutor, tree: Tree, settings: GuidedSettings, samples: int
    ) -> _Round:
        found = _Round(
            tree.empty_totals(),
            np.zeros(self.size[::-1]),
            np.full(3, np.inf, np.float32),
            np.full(3, -np.inf, np.float32),
        )
        for first in range(0, samples, AT_ONCE):
            count = min(AT_ONCE, samples - first)
            logs = list(
                pool.map(lambda tile: self._tile(settings, tile, first, count), self.tiles)  # noqa: B023
            )
            if self.unit == 0.0:
                self.unit = _typical_gain(logs)
            shares = [logs[i :: self.threads] for i in range(self.threads)]
            for totals in pool.map(lambda part: self._sums(settings.guide, tree, part), shares):
                found.totals.cells.array[:] += totals.cells.array
                found.totals.leaves.array[:] += totals.leaves.array
            for tile, log in zip(self.tiles, logs, strict=True):
                _look(found, tile, log)
                self.paths += log.ends.size
                self.vertices += int(log.count.array[0])
        return found

    def _tile(self, settings: GuidedSettings, tile: Tile, first: int, count: int) -> Log:
        """Render samples of a tile, and keep what their paths met."""
        began = time.thread_time()
        width, height = tile.x1 - tile.x0, tile.y1 - tile.y0
        samples = width * height * count
        window = [tile.x0, tile.y0, width, first, count, settings.replicates]
        log = Log(
            View(np.zeros((samples * DEPTH, RECORD), np.float32)),
            View(np.zeros(2, np.int64)),
            View(np.zeros(samples, np.float32)),
            View(np.array(window, np.uint32)),
        )
        cells = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
        columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
        ranges = View(np.tile(np.array([first, count], np.int64), (cells, columns, 1)))
        if not hasattr(self.local, "scratch"):
            self.local.scratch = Scratch()
        film = self.local.scratch.film(settings, tile, False)
        self.kernel(self.tables, settings._replace(log=log), tile, ranges, film)
        self.seconds.append(time.thread_time() - began)
        return log._replace(rows=View(log.rows.shaped[: int(log.count.array[0])].copy()))

    def _sums(self, guide: Guide, tree: Tree, logs: Sequence[Log]) -> Totals:
        began = time.thread_time()
        totals = tree.empty_totals()
        for log in logs:
            if log.rows.size:
                self.add(guide, log, totals, np.float32(self.unit))
        self.seconds.append(time.thread_time() - began)
        return totals


def _look(found: _Round, tile: Tile, log: Log) -> None:
    """Add a tile's pixels to the squares, and its vertices to the bounds."""
    ends = log.ends.array.reshape(tile.y1 - tile.y0, tile.x1 - tile.x0, -1).astype(np.float64)
    found.squares[tile.y0 : tile.y1, tile.x0 : tile.x1] += (ends**2).sum(2)
    p = log.rows.shaped[:, :3]
    if len(p):
        found.low, found.high = np.minimum(found.low, p.min(0)), np.maximum(found.high, p.max(0))


def _box(found: _Round) -> NDArray[np.float32]:
    """`Guide.box` around all vertices of a round."""
    if not (found.low <= found.high).all():
        return _EVERYWHERE
    extent = found.high - found.low
    extent = np.maximum(extent, max(float(extent.max()) * 1e-6, 1e-30))
    return np.concatenate([found.low, 1.0 / extent]).astype(np.float32)


def _blocks(squares: NDArray[np.float64]) -> NDArray[np.float32]:
    """Root mean square of blocks of pixels, none of them dark."""
    height, width = squares.shape
    rows, columns = -(-height // BLOCK), -(-width // BLOCK)
    padded = np.pad(squares, ((0, rows * BLOCK - height), (0, columns * BLOCK - width)), "edge")
    means = padded.reshape(rows, BLOCK, columns, BLOCK).mean((1, 3))
    # Never 0: then no path is worth following, and none is ended.
    least = max(DARKEST * float(np.median(means)), DARKEST**2 * float(means.max()), 1e-30)
    return np.sqrt(np.maximum(means, least)).astype(np.float32)


def _framed(box: NDArray, picture: NDArray, size: tuple[int, int]) -> Frame:
    """A frame for films of this size."""
    rows, columns = picture.shape
    scale = np.array([columns / size[0], rows / size[1]], np.float32)
    return Frame(box, picture, np.array([columns, *scale.view(np.uint32)], np.uint32))


def _typical_gain(logs: Sequence[Log]) -> float:
    """A power of two near the median of what vertices gain, where they gain; 0 if none does."""
    gains: list[Any] = []
    for log in logs:
        rows = log.rows.shaped
        end = log.ends.array[rows[:, 12].copy().view(np.uint32)]
        with np.errstate(all="ignore"):
            gains.append(rows[:, 9] * (end - rows[:, 11]) / rows[:, 10])
    found = np.concatenate(gains)
    found = found[np.isfinite(found) & (found > 0.0)]
    return float(2.0 ** np.floor(np.log2(np.median(found)))) if len(found) else 0.0
