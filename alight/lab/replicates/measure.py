"""Rendering one replicate of an arm: pictures along its ladder, and what each costs.

Time is CPU time of the threads that render samples and add them to the film: it does not grow
because something else runs on the machine, or in other threads of this program (libraries leave
theirs spinning for a while), and loading, compiling and statistics are not in it. Training a
guide is.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.films import CELL_SIZE, Film
from alight.integrators.walk import Settings, make_settings
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import Kernels, Scratch, make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.training.guide_training import is_to_be_guided, length_of, trained, untrained


class Rung(NamedTuple):
    """A picture at one step of the ladder.

    Attributes
    ----------
    spp : int
    seconds : float
        CPU time since the first sample.
    picture : ndarray of float32, shape (h, w, 3)
        Mean of all samples so far.
    invalid : int
        Samples so far that were NaN or infinite.
    """

    spp: int
    seconds: float
    picture: np.ndarray
    invalid: int


def compiled_kernels(scene: CompiledScene) -> Kernels:
    """The kernels of a scene, run once without a sample so that machine code is there.

    Of a scene that wants a guide, those that follow it.
    """
    scene = untrained(scene) if is_to_be_guided(scene) else scene
    kernels = make_kernels(scene)
    tile = tiles_of(film_for(scene, 0, 1).crop)[0]
    settings = make_settings(scene.integrator, seed=0, replicates=1, guide=scene.guide)
    render_tile(kernels, scene, settings, tile, ranges_of(tile, 0, 0))
    return kernels


def render_ladder(
    scene: CompiledScene,
    kernels: Kernels,
    replicates: int,
    seed: int,
    ladder: Sequence[int],
    threads: int,
) -> Iterator[Rung]:
    """Render with one seed up to the last step, stopping for a look at each.

    Parameters
    ----------
    scene : CompiledScene
    kernels : Kernels
    replicates : int
        R of the film.
    seed : int
    ladder : sequence of int
        Rising numbers of samples per pixel.
    threads : int
        0 renders on the caller's own.
    """
    scene, kernels, seconds = made_ready(scene, kernels, seed, threads, ladder[-1])
    film = film_for(scene, seed, replicates)
    settings = make_settings(scene.integrator, seed=seed, replicates=replicates, guide=scene.guide)
    tiles = tiles_of(film.crop)
    done = 0

    for spp in ladder:
        begin = time.thread_time()
        parts = [(tile, ranges_of(tile, done, spp - done)) for tile in tiles]
        seconds += add_tiles(threads, kernels, scene, settings, film, parts)
        seconds += time.thread_time() - begin
        done = spp
        yield Rung(spp, seconds, film.mean[..., :3].astype(np.float32), film.invalid)


def made_ready(
    scene: CompiledScene, kernels: Kernels, seed: int, threads: int, spp: int
) -> tuple[CompiledScene, Kernels, float]:
    """A scene with its guide, if it wants one, its kernels, and the CPU seconds of training.

    A scene whose guide would not pay for so many samples a pixel has other kernels than the given
    ones.
    """
    if not is_to_be_guided(scene):
        return scene, kernels, 0.0
    length = length_of(scene, spp)
    scene, training = trained(scene, seed=seed, threads=max(threads, 1), length=length)
    return scene, kernels if training.used else compiled_kernels(scene), training.cpu_seconds


def add_tiles(
    threads: int,
    kernels: Kernels,
    scene: CompiledScene,
    settings: Settings,
    film: Film,
    parts: Sequence[tuple[Tile, np.ndarray]],
) -> float:
    """Render samples on all threads and add them to a film.

    Parameters
    ----------
    threads : int
        0 renders on the caller's own.
    kernels : Kernels
    scene : CompiledScene
    settings : Settings
    film : Film
    parts : sequence of (Tile, ndarray of int64, shape (cells_y, cells_x, 2))
        (first, count) of the samples of each cell of a tile.

    Returns
    -------
    float
        CPU seconds of these threads; the caller's own are not in it.
    """

    def work(tile: Tile, ranges: np.ndarray) -> float:
        begin = time.thread_time()
        partial, _ = render_tile(kernels, scene, settings, tile, ranges, _scratch())
        film.add_tile(partial)
        return time.thread_time() - begin

    if threads == 0:
        for part in parts:
            work(*part)
        return 0.0
    futures = [_pool(threads).submit(work, *part) for part in parts]
    try:
        return sum(future.result() for future in futures)
    except BaseException:
        # Ctrl-C: what has not begun need not begin.
        for future in futures:
            future.cancel()
        raise


def film_for(scene: CompiledScene, seed: int, replicates: int) -> Film:
    """An empty film of a scene's size."""
    return Film(*scene.size, crop=scene.crop, replicates=replicates, seed=seed)


def ranges_of(tile: Tile, first: int, count: int) -> np.ndarray:
    """The same (first, count) for every 8x8 cell that a tile touches."""
    rows = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
    columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
    return np.tile(np.array([first, count], np.int64), (rows, columns, 1))


@lru_cache(maxsize=1)
def _pool(threads: int) -> ThreadPoolExecutor:
    """The threads of all replicates: they keep their memory from one to the next."""
    return ThreadPoolExecutor(threads)


_LOCAL = threading.local()


def _scratch() -> Scratch:
    """The memory of this thread."""
    if not hasattr(_LOCAL, "scratch"):
        _LOCAL.scratch = Scratch()
    return _LOCAL.scratch
