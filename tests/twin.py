"""Small pictures by the NumPy twin: the compiled renderer's text, with nothing to compile.

Compiling takes seconds a scene, and a test that asks for a few thousand samples needs none of it:
`tests/rendering` and `tests/laws` prove that machine code computes what its text says.
"""

import numpy as np

from alight.compiled.scene import CompiledScene, compile_scene
from alight.films import fixed_point
from alight.films.tiles import PartialFilm
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile, count_cells
from alight.scene import Scene, flatten


def film_of(
    scene: CompiledScene, spp: int, seed=0, replicates=4, tile: Tile | None = None, **settings
) -> PartialFilm:
    """What the samples of a tile add up to, which is the whole film unless it is given."""
    tile = tile or Tile(0, 0, *scene.size)
    values = make_settings(scene.integrator, seed=seed, replicates=replicates)._replace(**settings)
    columns, cells = count_cells(tile)
    ranges = np.tile(np.array([0, spp], np.int64), (cells // columns, columns, 1))
    film, _ = render_tile(make_kernels(scene, compiled=False), scene, values, tile, ranges)
    fixed_point.carry(film.sums)
    return film


def picture_of(scene: Scene, spp: int, seed=0, **settings) -> np.ndarray:
    """Mean radiance (height, width, 3)."""
    film = film_of(compile_scene(flatten(scene), structure="list"), spp, seed, 1, **settings)
    assert film.invalid == 0
    return fixed_point.to_float(film.sums)[:, :, 0, :3] / spp
