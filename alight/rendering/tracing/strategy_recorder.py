"""What each technique (s, t) of paths from both ends adds to a picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from alight.compiled.scene import CompiledScene
from alight.films import CELL_SIZE
from alight.films.fixed_point import carry, to_float
from alight.integrators.contributions import RECORDED
from alight.integrators.strategies import PASS, ROWS, StrategyLog
from alight.integrators.walk import make_settings
from alight.rendering.tiles.both_ends_tile import splatting_tile_kernel
from alight.rendering.tiles.tile import Scratch
from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.tracing.contribution_recorder import recorded_tables
from lanewise.jit import instantiate
from lanewise.view import View


class Told(NamedTuple):
    """Means over the samples of a pixel.

    Attributes
    ----------
    weighted, unweighted : (rows, height, width, 3) float64
        Radiance that each technique adds, rows as in `alight.integrators.strategies`.
    picture : (height, width, 3) float64
        As the film has it.
    """

    weighted: np.ndarray
    unweighted: np.ndarray
    picture: np.ndarray


class StrategyRecorder:
    """Renders a scene and keeps what each technique adds.

    Parameters
    ----------
    scene : CompiledScene
        Of the bidirectional integrator, and without a crop window.
    """

    def __init__(self, scene: CompiledScene) -> None:
        self.scene = scene
        program = scene.program
        options = (*program.options, (RECORDED, program.integrator))
        program = program._replace(integrator=PASS, options=options, aovs=())
        self.kernel = instantiate(splatting_tile_kernel, program)

    def run(self, spp: int, seed: int) -> Told:
        """Render samples 0 to spp - 1 of every pixel."""
        width, height = self.scene.size
        window = Tile(0, 0, width, height)
        settings = make_settings(self.scene.integrator, seed=seed, replicates=1)
        cells = (-(-height // CELL_SIZE), -(-width // CELL_SIZE), 1)
        ranges = View(np.tile(np.array([0, spp], np.int64), cells))
        log = StrategyLog(
            View(np.zeros((ROWS, height, width, 2, 3))),
            View(np.array([0, 0, width, height], np.float32)),
        )
        film = Scratch().film(settings, window, False)
        tables = recorded_tables(self.scene, log)
        self.kernel(tables, settings, (window, window), ranges, film)
        carry(film.sums.shaped)
        parts = np.moveaxis(log.sums.shaped, 3, 0) / spp
        return Told(parts[0], parts[1], to_float(film.sums.shaped)[:, :, 0] / spp)
