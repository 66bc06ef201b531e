"""The light that arrives at a point from all directions, as six pictures of a cube around it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from alight.cameras.rays import project
from alight.compiled.cameras import compile_camera
from alight.compiled.scene import CompiledScene
from alight.core.registry import default_of
from alight.core.spec import Camera
from alight.films import CELL_SIZE
from alight.films.fixed_point import carry, to_float
from alight.integrators.walk import Settings, make_settings
from alight.rendering.tiles.division import SMALL, tiles_of
from alight.rendering.tiles.tile import Kernels, Scratch, make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile

#: Pixels of a side of the cube.
FACE = 64

#: Independent estimates of the light: the square of its mean is their product.
HALVES = 2

#: Rotations of a camera that looks along -z: to the six sides.
_SIDES = tuple(
    np.array(rows, float)
    for rows in (
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
        ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
        ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    )
)  # fmt: skip

_CAMERA = default_of(Camera).replaced(fov=90.0)


def arriving_light(
    scene: CompiledScene, origin: np.ndarray, w: np.ndarray, *, spp: int, seed: int, threads: int
) -> np.ndarray:
    """Radiance that arrives at a point.

    Parameters
    ----------
    scene : CompiledScene
        Its camera is not asked.
    origin : (3,) float
        World, metres.
    w : (3, n) float
        Unit directions in the world.
    spp : int
        Samples for each of the cube's pixels, an even number.
    seed, threads : int

    Returns
    -------
    (2, n, 3) float64
        Means of the cube's pixels: linear RGB, by each of two independent halves of the samples.
    """
    motion = tuple(name for name in scene.program.motion if name != "camera")
    program = scene.program._replace(camera=_CAMERA.type_name(), motion=motion, aovs=())
    scene = replace(scene, program=program, size=(FACE, FACE), crop=None)
    kernels = make_kernels(scene)
    radiance = np.zeros((HALVES, w.shape[1], 3))
    points = (origin[:, None] + w).T
    with ThreadPoolExecutor(threads) as pool:
        for number, side in enumerate(_SIDES):
            to_world = np.eye(4)
            to_world[:3, :3], to_world[:3, 3] = side, origin
            at = project(_CAMERA, to_world, (FACE, FACE), points)
            # Ties of neighbouring faces go to the later one.
            here = (at[:, 2] > 0.0) & np.all((at[:, :2] >= 0.0) & (at[:, :2] <= FACE), axis=1)
            if not here.any():
                continue
            view = compile_camera(_CAMERA, to_world, (FACE, FACE))
            seen = replace(scene, tables=scene.tables._replace(camera=view))
            picture = _render(pool, kernels, seen, spp, seed + number)
            column, row = np.minimum(at[here, :2].astype(int), FACE - 1).T
            radiance[:, here] = picture[row, column].swapaxes(0, 1)
    return radiance


def _render(
    pool: ThreadPoolExecutor, kernels: Kernels, scene: CompiledScene, spp: int, seed: int
) -> np.ndarray:
    settings = make_settings(scene.integrator, seed=seed, replicates=HALVES, guide=scene.guide)
    picture = np.zeros((FACE, FACE, HALVES, 3))
    tiles = tiles_of((0, 0, FACE, FACE), SMALL)
    render = partial(_tile, kernels, scene, settings, spp)
    for tile, mean in zip(tiles, pool.map(render, tiles), strict=True):
        picture[tile.y0 : tile.y1, tile.x0 : tile.x1] = mean
    return picture


def _tile(
    kernels: Kernels, scene: CompiledScene, settings: Settings, spp: int, tile: Tile
) -> np.ndarray:
    cells = (tile.y1 - tile.y0) // CELL_SIZE, (tile.x1 - tile.x0) // CELL_SIZE, 1
    ranges = np.tile(np.array([0, spp], np.int64), cells)
    film, _ = render_tile(kernels, scene, settings, tile, ranges, Scratch())
    carry(film.sums)
    return to_float(film.sums) / (spp // HALVES)
