"""Every single contribution to a picture: the length of its path, and how its light was found."""

from __future__ import annotations

from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from alight.compiled.program import Program
from alight.compiled.scene import CompiledScene, SceneTables
from alight.films import CELL_SIZE
from alight.films.fixed_point import carry, to_float
from alight.integrators.contributions import FIELDS, HALF, PASS, RECORDED, Log
from alight.integrators.strategies import StrategyLog
from alight.integrators.walk import Settings, make_settings
from alight.rendering.tiles.division import tiles_of
from alight.rendering.tiles.tile import Scratch
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.tiles.tile_loop import render_tile_kernel
from lanewise.jit import instantiate
from lanewise.view import View

#: `SceneTables`, and the log that the kernels of contributions write.
RecordedTables = namedtuple("RecordedTables", (*SceneTables._fields, "log"))

#: The same of a scene in which something moves.
RecordedMotion = namedtuple("RecordedMotion", (*SceneTables._fields, "motions", "log"))


def recorded_tables(
    scene: CompiledScene, log: Log | StrategyLog
) -> RecordedTables | RecordedMotion:
    """A scene's tables with a log."""
    kind = RecordedMotion if scene.program.motion else RecordedTables
    return kind(*scene.tables, log)


#: Contributions per sample that a log has room for at first; a tile that needs more runs again.
_ROOM = 6


class Contributions(NamedTuple):
    """Contributions, one after the other.

    Attributes
    ----------
    pixel : (n,) int64
        y * width + x.
    replicate : (n,) int64
        Of the sample.
    depth : (n,) int64
        Edges of the path: 1 is light that is seen directly.
    how : (n,) int64
        `SEEN`, `BY_BSDF`, `BY_DELTA` or `BY_LIGHT` of `alight.integrators.contributions`.
    light : (n,) int64
        Row of the light in `CompiledScene.tables.lights`.
    bsdf : (n,) int64
        Material that the camera's ray met first; -1 where it met none, or the light itself.
    value : (n, 3) float32
        Radiance times everything but 1 / samples.
    """

    pixel: np.ndarray
    replicate: np.ndarray
    depth: np.ndarray
    how: np.ndarray
    light: np.ndarray
    bsdf: np.ndarray
    value: np.ndarray


def recording_program(program: Program) -> Program:
    """The program that logs the contributions of another one."""
    options = (*program.options, (RECORDED, program.integrator))
    return program._replace(integrator=PASS, options=options, aovs=())


class Recorder:
    """Renders a scene and keeps every contribution.

    Parameters
    ----------
    scene : CompiledScene
        Its integrator must pass `alight.integrators.contributions.can_record`; at most 65 535
        pixels wide and high.
    threads : int
    """

    def __init__(self, scene: CompiledScene, threads: int = 1) -> None:
        self.scene, self.threads = scene, threads
        self.kernel = instantiate(render_tile_kernel, recording_program(scene.program))
        self.tiles = tiles_of(scene.crop or (0, 0, *scene.size))

    def run(
        self, spp: int, seed: int, replicates: int = 1, **settings: int
    ) -> tuple[Contributions, np.ndarray]:
        """Render samples 0 to spp - 1 of every pixel.

        Parameters
        ----------
        spp, seed, replicates : int
            Sample i belongs to replicate i mod `replicates`.
        **settings : int
            In place of the integrator's ``max_depth`` or ``rr_depth``.

        Returns
        -------
        Contributions
        picture : (height, width, replicates, 3) float64
            Sums of the samples, as the film has them.
        """
        made = make_settings(self.scene.integrator, seed=seed, replicates=replicates)
        made = made._replace(**settings)
        width, height = self.scene.size
        picture = np.zeros((height, width, replicates, 3))
        with ThreadPoolExecutor(self.threads) as pool:
            parts = list(pool.map(lambda tile: self._tile(tile, spp, made), self.tiles))
        for tile, (_, _, sums) in zip(self.tiles, parts, strict=True):
            picture[tile.y0 : tile.y1, tile.x0 : tile.x1] = sums
        words = np.concatenate([part[0] for part in parts])
        values = np.concatenate([part[1] for part in parts])
        return _unpacked(words, values, width), picture

    def _tile(
        self, tile: Tile, spp: int, settings: Settings
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        width, height = tile.x1 - tile.x0, tile.y1 - tile.y0
        cells = -(-tile.y1 // CELL_SIZE) - tile.y0 // CELL_SIZE
        columns = -(-tile.x1 // CELL_SIZE) - tile.x0 // CELL_SIZE
        ranges = View(np.tile(np.array([0, spp], np.int64), (cells, columns, 1)))
        room = _ROOM * spp * width * height
        while True:
            log = Log(
                View(np.zeros((room, FIELDS), np.uint32)),
                View(np.zeros((room, 3), np.float32)),
                View(np.zeros(1, np.int64)),
                View(np.zeros(spp * width * height, np.uint32)),
                View(np.array([tile.x0, tile.y0, width, spp, settings.replicates], np.uint32)),
            )
            film = Scratch().film(settings, tile, False)
            self.kernel(recorded_tables(self.scene, log), settings, tile, ranges, film)
            count = int(log.count.array[0])
            if count <= room:
                break
            room = count
        carry(film.sums.shaped)
        return log.words.shaped[:count], log.values.shaped[:count], to_float(film.sums.shaped)


def _unpacked(words: np.ndarray, values: np.ndarray, width: int) -> Contributions:
    """Fields of the log; contributions that are not finite add nothing, as in the film."""
    finite = np.isfinite(values).all(axis=1)
    place, sample, light, what = words[finite].T.astype(np.int64)
    low = (1 << HALF) - 1
    return Contributions(
        pixel=(place >> HALF) * width + (place & low),
        replicate=sample >> HALF,
        depth=sample & low,
        how=what >> HALF,
        light=light - 1,
        bsdf=(what & low) - 1,
        value=values[finite],
    )
