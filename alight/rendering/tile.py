"""`render_tile`: the one entry that everything which renders goes through."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.core.jit import instantiate
from alight.core.view import View
from alight.films import PartialFilm
from alight.integrators.walk import Settings
from alight.rendering.tile_kernel import INVALID, RAYS, SATURATED, Tile, render_tile_kernel

#: What the kernel writes: flat int64 tables of one tile.
TileFilm = namedtuple("TileFilm", "sums counts direct tally")


def tile_kernel(scene: CompiledScene, *, compiled: bool = True) -> Callable:
    """The main loop specialised on a scene's program; compiled False gives the NumPy twin."""
    return instantiate(render_tile_kernel, scene.program, compiled=compiled)


def render_tile(
    kernel: Callable, scene: CompiledScene, settings: Settings, tile: Tile, ranges: np.ndarray
) -> tuple[PartialFilm, int]:
    """Render some samples of one tile.

    Parameters
    ----------
    kernel : callable
        From `tile_kernel`.
    scene : CompiledScene
    settings : Settings
        Seed, replicates, depths.
    tile : Tile
    ranges : ndarray of int64, shape (cells_y, cells_x, 2)
        (first, count) of the sample indices of each 8x8 cell that the tile touches.

    Returns
    -------
    PartialFilm
        Sums of exactly these samples; the same bits whatever else is rendered, when and where.
    int
        Rays traced.
    """
    height, width = tile.y1 - tile.y0, tile.x1 - tile.x0
    sums = np.zeros((height, width, settings.replicates, 3, 2), np.int64)
    counts = np.zeros((height, width, settings.replicates), np.int64)
    split = "direct" in scene.program.aovs
    direct = np.zeros((height, width, 3, 2) if split else (1,), np.int64)
    tally = np.zeros(4, np.int64)
    film = TileFilm(View(sums), View(counts), View(direct), View(tally))
    kernel(scene.tables, settings, tile, View(np.ascontiguousarray(ranges, np.int64)), film)
    aovs = None
    if split:
        # Exact whole numbers: direct + indirect is the picture to the last bit.
        aovs = {"direct": direct, "indirect": sums.sum(axis=2) - direct}
    partial = PartialFilm(
        tile.x0, tile.y0, sums, counts, int(tally[INVALID]), int(tally[SATURATED]), ranges, aovs
    )
    return partial, int(tally[RAYS])
