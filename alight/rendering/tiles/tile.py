"""`render_tile`: the single entry point of everything that renders."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from alight.compiled.program import Program
from alight.compiled.scene import CompiledScene
from alight.films import PartialFilm
from alight.films.coverage import SurfaceSums
from alight.films.fixed_point import add_rows
from alight.films.sample_ranges import cells_of
from alight.guiding.tables import GUIDED
from alight.integrators.aov import (
    ASKS_GUIDE,
    COVERAGE,
    LAYERS,
    THROUGH,
    THROUGH_LAYERS,
    layer_bits,
)
from alight.integrators.coverage import ROW_BITS, WeightTable
from alight.integrators.shadow_catcher import CHANNELS
from alight.integrators.walk import Settings
from alight.lights.ground import SHADOW
from alight.rendering.tiles.both_ends_tile import splatting_tile_kernel
from alight.rendering.tiles.tile_kernel import (
    INVALID,
    RAYS,
    SATURATED,
    Tile,
    render_coverage,
    render_layers,
    render_shadows,
)
from alight.rendering.tiles.tile_loop import render_step_by_step, render_tile_kernel
from lanewise.jit import StockKernel, instantiate
from lanewise.machine_code import MachineCode
from lanewise.simd import WIDEST
from lanewise.view import View

#: What the kernel writes: flat int64 tables of one tile.
TileFilm = namedtuple("TileFilm", "sums counts direct tally")


class Kernels(NamedTuple):
    """Machine code for one scene; once they have run, they can be pickled.

    Attributes
    ----------
    beauty : callable
        The main loop.
    layers : callable or None
        The pass for the scene's AOVs, if it has any.
    add_rows : callable or None
        For `Film.add_tile`; None in the NumPy twin.
    coverage : callable or None
        The pass that weighs surfaces, if mattes are wanted.
    shadows : callable or None
        The pass for shadows on the ground, if these are wanted.
    """

    beauty: Callable
    layers: Callable | None
    add_rows: Callable | None
    coverage: Callable | None = None
    shadows: Callable | None = None


def make_kernels(
    scene: CompiledScene,
    *,
    compiled: bool = True,
    observe: Callable | None = None,
    lanes: int | None = None,
) -> Kernels:
    """The main loop specialised on a scene's program; compiled False gives the NumPy twin.

    `observe` and `lanes` are for the twin, see `lanewise.jit.instantiate`; what is observed are
    whole steps. Packets are as wide as pays off, unless they search a tree or are observed.
    """
    if lanes is None:
        lanes = WIDEST if compiled or observe or "tree" in scene.program.accel else TWINS_LANES
    picture = render_step_by_step if observe else render_tile_kernel
    if scene.integrator.splats:
        picture = splatting_tile_kernel

    def make(root: Callable, program: Program) -> Callable:
        kernel = instantiate(root, program, compiled=compiled, observe=observe, lanes=lanes)
        # Dead lanes compute with what they have; NumPy would warn of each division by their zeros.
        if isinstance(kernel, MachineCode | StockKernel):
            return kernel.fixed()
        return np.errstate(all="ignore")(kernel)

    wanted = set(LAYERS) & set(scene.program.aovs)
    # What light does plays no part in these layers: no integrator is compiled for them.
    aovs = ("uv", THROUGH) if wanted & THROUGH_LAYERS else ("uv",)
    # The camera sees through the same lights as in the picture.
    hides = tuple(one for one in scene.program.options if one[0] == "hide_emitters")
    options: tuple = ()
    if COVERAGE in wanted:
        aovs += (COVERAGE,)
        options = hides
    if ASKS_GUIDE in wanted:
        options += tuple(one for one in scene.program.options if one[0] == GUIDED)
    looking = scene.program._replace(integrator="", options=options, aovs=aovs)
    beauty = scene.program._replace(aovs=tuple({"direct"} & set(scene.program.aovs)))
    covered = scene.program._replace(integrator="", options=hides, aovs=())
    return Kernels(
        make(picture, beauty),
        make(render_layers, looking) if wanted else None,
        compiled_add_rows() if compiled else None,
        make(render_coverage, covered) if scene.surfaces else None,
        make(render_shadows, covered) if scene.ground else None,
    )


#: Lanes of the NumPy twin: more than these are seldom all active.
TWINS_LANES = 256


@lru_cache(maxsize=1)
def compiled_add_rows() -> Callable:
    """`add_rows` as machine code, ready to run: it is the same for all scenes."""
    kernel, nothing = instantiate(add_rows), View(np.zeros(2, np.int64))
    assert isinstance(kernel, MachineCode | StockKernel)
    call = kernel.fixed()
    call(nothing, 0, 0, nothing, 0, 0)
    return call


class Scratch:
    """Memory of one thread's tiles, used again: the system takes long to give and clear pages."""

    def __init__(self) -> None:
        self._films: dict[tuple, TileFilm] = {}

    def film(self, settings: Settings, tile: Tile, split: bool) -> TileFilm:
        """Zeros for a tile; the last tile of the same size is lost."""
        key = (tile.x1 - tile.x0, tile.y1 - tile.y0, settings.replicates, split)
        if key not in self._films:
            self._films[key] = _empty_film(settings, tile, split)
        else:
            for table in self._films[key]:
                table.array.fill(0)
        return self._films[key]


def render_tile(
    kernels: Kernels,
    scene: CompiledScene,
    settings: Settings,
    tile: Tile,
    ranges: np.ndarray,
    scratch: Scratch | None = None,
) -> tuple[PartialFilm, int]:
    """Render some samples of one tile.

    Parameters
    ----------
    kernels : Kernels
        From `make_kernels`.
    scene : CompiledScene
    settings : Settings
        Seed, replicates, depths.
    tile : Tile
    ranges : ndarray of int64, shape (cells_y, cells_x, 2)
        (first, count) of the sample indices of each 8x8 cell that the tile touches.
    scratch : Scratch, optional
        Memory for the result, which is then valid until the next tile with the same scratch.

    Returns
    -------
    PartialFilm
        Sums of exactly these samples; the same bits whatever else is rendered, when and where.
    int
        Rays traced for the picture.
    """
    if scene.integrator.splats:
        return _render_light_paths(kernels, scene, settings, tile, ranges, scratch or Scratch())
    split = "direct" in scene.program.aovs
    film = (scratch or Scratch()).film(settings, tile, split)
    samples = View(np.ascontiguousarray(ranges, np.int64))
    kernels.beauty(scene.tables, settings, tile, samples, film)
    sums, direct, tally = film.sums.shaped, film.direct.shaped, film.tally.array
    aovs: dict[str, np.ndarray] = {}
    if split:
        # Exact whole numbers: direct + indirect is the picture to the last bit.
        aovs = {"direct": direct, "indirect": sums.sum(axis=2) - direct}
    wanted = tuple(name for name in LAYERS if name in scene.program.aovs)
    if wanted:
        assert kernels.layers is not None
        height, width = tile.y1 - tile.y0, tile.x1 - tile.x0
        layers = View(np.zeros((len(wanted), height, width, 3, 2), np.int64))
        kernels.layers(scene.tables, settings, tile, samples, layer_bits(wanted), layers)
        for name, layer in zip(wanted, layers.shaped, strict=True):
            aovs[name] = layer[:, :, : len(LAYERS[name])]
    if scene.ground:
        assert kernels.shadows is not None
        shadows = View(np.zeros((tile.y1 - tile.y0, tile.x1 - tile.x0, 3, 2), np.int64))
        kernels.shadows(scene.tables, settings, tile, samples, scene.ground, shadows)
        aovs[SHADOW] = shadows.shaped[:, :, : len(CHANNELS)]
    partial = PartialFilm(
        x0=tile.x0,
        y0=tile.y0,
        sums=sums,
        counts=film.counts.shaped,
        invalid=int(tally[INVALID]),
        saturated=int(tally[SATURATED]),
        ranges=ranges,
        aovs=aovs,
        coverage=_weigh(kernels, scene, settings, tile, samples),
    )
    return partial, int(tally[RAYS])


def _weigh(
    kernels: Kernels, scene: CompiledScene, settings: Settings, tile: Tile, samples: View
) -> SurfaceSums | None:
    """Weigh the surfaces of one tile, if mattes are wanted."""
    if scene.surfaces is None:
        return None
    assert kernels.coverage is not None
    pixels = (tile.x1 - tile.x0) * (tile.y1 - tile.y0)
    # More than its samples, or than there are rows, no pixel can have. Memory that the system
    # gives as zeros takes none until it is used.
    most = min(int(samples.shaped[..., 1].max(initial=0)), len(scene.surfaces.of_row))
    last, used = np.zeros(pixels, np.int64), np.zeros(1, np.int64)
    keys, before, sums = (np.zeros(n * most * pixels + 1, np.int64) for n in (1, 1, 2))
    table = WeightTable(tile, *map(View, (last, keys, before, sums, used)))
    kernels.coverage(scene.tables, settings, tile, samples, table)
    n = int(used[0])
    rows = scene.surfaces.of_row[keys[:n] & ((1 << ROW_BITS) - 1)]
    return SurfaceSums.gathered(keys[:n] >> ROW_BITS, rows, sums[: 2 * n].reshape(-1, 2))


def _render_light_paths(
    kernels: Kernels,
    scene: CompiledScene,
    settings: Settings,
    tile: Tile,
    ranges: np.ndarray,
    scratch: Scratch,
) -> tuple[PartialFilm, int]:
    """`render_tile` of an integrator that splats: the sums are those of the whole window."""
    x, y, width, height = scene.crop or (0, 0, *scene.size)
    window = Tile(x, y, x + width, y + height)
    film = scratch.film(settings, window, False)
    samples = View(np.ascontiguousarray(ranges, np.int64))
    kernels.beauty(scene.tables, settings, (tile, window), samples, film)
    rows, columns = cells_of(x, y, width, height)
    its_rows, its_columns = cells_of(tile.x0, tile.y0, tile.x1 - tile.x0, tile.y1 - tile.y0)
    held = np.zeros((rows.stop - rows.start, columns.stop - columns.start, 2), np.int64)
    held[
        its_rows.start - rows.start : its_rows.stop - rows.start,
        its_columns.start - columns.start : its_columns.stop - columns.start,
    ] = ranges
    tally = film.tally.array
    partial = PartialFilm(
        x0=x,
        y0=y,
        sums=film.sums.shaped,
        counts=film.counts.shaped,
        invalid=int(tally[INVALID]),
        saturated=int(tally[SATURATED]),
        ranges=held,
        aovs={},
    )
    return partial, int(tally[RAYS])


def _empty_film(settings: Settings, tile: Tile, split: bool) -> TileFilm:
    """Zeros for the sums of one tile."""
    height, width = tile.y1 - tile.y0, tile.x1 - tile.x0
    return TileFilm(
        View(np.zeros((height, width, settings.replicates, 3, 2), np.int64)),
        View(np.zeros((height, width, settings.replicates), np.int64)),
        View(np.zeros((height, width, 3, 2) if split else (1,), np.int64)),
        View(np.zeros(4, np.int64)),
    )
