"""The main loop of a tile for one pixel: what a thread of a GPU renders."""

from __future__ import annotations

from collections import namedtuple

from alight.rendering.tiles.tile_kernel import Tile
from alight.rendering.tiles.tile_loop import render_tile_kernel
from lanewise.jit import kernel
from lanewise.view import part_of

#: What the kernel writes, as of a `TileFilm`: for each place one after the other.
PixelFilms = namedtuple("PixelFilms", "sums counts direct tally")

#: Numbers of an item of work: pixel x and y, first sample, how many, and the place of their sums.
ITEM = 5

#: Numbers of a place, in `PixelFilms.sums` and ``counts`` for each replicate.
SUMS, COUNTS, DIRECT, TALLY = 6, 1, 6, 4


@kernel
def render_pixel(scene, settings, work, films, item):
    """Render samples of one pixel.

    Parameters
    ----------
    scene, settings
        As of `render_tile_kernel`.
    work : View of int64
        `ITEM` numbers for each item.
    films : PixelFilms
    item : int
        Which to render.
    """
    at, n = ITEM * item, settings.replicates
    x, y, place = work[at], work[at + 1], work[at + 4]
    film = PixelFilms(
        part_of(films.sums, SUMS * n * place, SUMS * n),
        part_of(films.counts, COUNTS * n * place, COUNTS * n),
        part_of(films.direct, DIRECT * place, DIRECT),
        part_of(films.tally, TALLY * place, TALLY),
    )
    samples = part_of(work, at + 2, 2)
    render_tile_kernel(scene, settings, Tile(x, y, x + 1, y + 1), samples, film)
