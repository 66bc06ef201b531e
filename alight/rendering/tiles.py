"""How a film is cut into tiles."""

from __future__ import annotations

from alight.films import CELL_SIZE
from alight.rendering.tile_kernel import Tile

#: Side of a tile in pixels, a multiple of the cell's. Sums of 32 x 32 x 4 replicates take 196 kB:
#: they stay in a core's second-level cache.
TILE_SIZE = 32


def tiles_of(window: tuple[int, int, int, int], size: int = TILE_SIZE) -> list[Tile]:
    """Tiles that cover a window, aligned to the grid of the full film so that cells stay whole.

    Parameters
    ----------
    window : (x, y, width, height) in pixels of the full film
    size : int
        Side of a tile in pixels; a multiple of 8.
    """
    if size % CELL_SIZE:
        raise ValueError(f"tile size must be a multiple of {CELL_SIZE}, got {size}")
    x, y, width, height = window
    return [
        Tile(max(x, x0), max(y, y0), min(x + width, x0 + size), min(y + height, y0 + size))
        for y0 in range(y // size * size, y + height, size)
        for x0 in range(x // size * size, x + width, size)
    ]
