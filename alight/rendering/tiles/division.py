"""How a film is cut into tiles."""

from __future__ import annotations

from alight.films import CELL_SIZE
from alight.rendering.tiles.tile_kernel import Tile

#: Sides of tiles in pixels, multiples of the cell's. Small ones keep all threads busy in a small
#: picture; in a large one, large ones spread the cost of starting a tile over more samples. Their
#: sums (786 kB with 4 replicates) still fit a core's second-level cache.
SMALL, LARGE = 32, 64

#: So many large tiles are enough for any number of threads to share evenly, and so many for each
#: thread where another picture keeps it busy when this one runs out of tiles.
ENOUGH, ENOUGH_EACH = 64, 4


def tile_size(window: tuple[int, int, int, int], shared_by: int | None = None) -> int:
    """Side of the tiles of a window; it never changes the picture.

    Parameters
    ----------
    window : (x, y, width, height) in pixels of the full film
    shared_by : int, optional
        Threads that render another picture as well; by default they have this one alone.
    """
    _, _, width, height = window
    enough = ENOUGH if shared_by is None else min(ENOUGH, ENOUGH_EACH * shared_by)
    return LARGE if width * height >= enough * LARGE**2 else SMALL


def tiles_of(window: tuple[int, int, int, int], size: int | None = None) -> list[Tile]:
    """Tiles that cover a window, aligned to the grid of the full film so that cells stay whole.

    Parameters
    ----------
    window : (x, y, width, height) in pixels of the full film
    size : int, optional
        Side of a tile in pixels; a multiple of 8; `tile_size` chooses by default.
    """
    size = size or tile_size(window)
    if size % CELL_SIZE:
        raise ValueError(f"tile size must be a multiple of {CELL_SIZE}, got {size}")
    x, y, width, height = window
    return [
        Tile(max(x, x0), max(y, y0), min(x + width, x0 + size), min(y + height, y0 + size))
        for y0 in range(y // size * size, y + height, size)
        for x0 in range(x // size * size, x + width, size)
    ]
