r"""Brightness around a pixel, over a window as large as its noise requires.

A window of n pixels, each with the relative variance v, knows its brightness to :math:`\sqrt{v/n}`.
Small windows follow edges, large ones hold enough samples: each pixel takes the smallest of 3x3
pixels, its 8x8 cell, and 3x3 cells that knows its brightness to half. The noise is that of the 3x3
cells around: in a dark window it would be judged by samples that found nothing.
"""

from __future__ import annotations

import numpy as np

#: Side of a cell.
CELL = 8

#: Rows that are worked on at a time, whole cells.
_ROWS = 32

#: Relative error of the brightness that a window may have.
_ENOUGH = 0.5


def around(mean: np.ndarray, variance: np.ndarray, epsilon: float) -> np.ndarray:
    """Estimate each pixel's brightness from the pixels around it, its own left out.

    Parameters
    ----------
    mean, variance : ndarray of float32, shape (3, h, w)
        The picture, negative values black, and its squared standard error.
    epsilon : float
        Brightness squared below which precision does not matter.

    Returns
    -------
    ndarray of float32, shape (3, h, w)
    """
    h, w = mean.shape[1:]
    pixels = pixels_of_cells(h, w)
    own = by_cells(mean)
    wide_pixels, wide = neighbours(pixels), neighbours(own)
    brightness = wide / wide_pixels
    noise = neighbours(by_cells(variance)) / wide_pixels
    # Pixels that a window needs, the channel that needs most.
    enough = _ENOUGH**2 * (brightness * brightness + epsilon)
    needed = (noise / np.maximum(enough, np.float32(1e-30))).max(axis=0)
    few, some = needed <= 8.0, needed <= pixels[0]
    result = np.empty_like(mean)
    lines, columns = (neighbours(np.ones((1, n), np.float32), 1) for n in (h, w))
    # A few rows at a time stay in the processor's cache.
    for y in range(0, h, _ROWS):
        rows, cells = slice(y, min(y + _ROWS, h)), slice(y // CELL, (y + _ROWS) // CELL)
        here, size = mean[:, rows], (min(y + _ROWS, h) - y, w)
        out = np.subtract(spread_out(wide[:, cells], *size), here, out=result[:, rows])
        out /= np.maximum(spread_out(wide_pixels[:, cells], *size) - 1.0, 1.0)
        if some[cells].any():
            cell = spread_out(own[:, cells], *size) - here
            cell /= np.maximum(spread_out(pixels[:, cells], *size) - 1.0, 1.0)
            np.copyto(out, cell, where=spread_out(some[cells], *size))
        if few[cells].any():
            above = min(y, 1)
            near = neighbours(mean[:, y - above : y + _ROWS + 1])[:, above : above + size[0]]
            near -= here
            number = lines.T[rows] * columns - np.float32(1.0)
            near /= np.maximum(number, np.float32(1.0))
            np.copyto(out, near, where=spread_out(few[cells], *size))
    return np.maximum(result, 0.0, out=result)


def by_cells(planes: np.ndarray) -> np.ndarray:
    """Add up 8x8 pixels (those at the edge may be fewer), planes (..., h, w)."""
    *leading, h, w = planes.shape
    whole = h - h % CELL
    # Over whole cells as one sum: `reduceat` takes ten times as long.
    rows = planes[..., :whole, :].reshape(*leading, whole // CELL, CELL, w).sum(axis=-2)
    if whole < h:
        rows = np.concatenate([rows, planes[..., whole:, :].sum(axis=-2, keepdims=True)], axis=-2)
    return np.add.reduceat(rows, range(0, w, CELL), axis=-1)


def pixels_of_cells(height: int, width: int) -> np.ndarray:
    """Count the pixels of each cell, float32, shape (1, cells_y, cells_x)."""
    rows, columns = (by_cells(np.ones((1, n), np.float32)) for n in (height, width))
    return (rows.T * columns)[None]


def spread_out(cells: np.ndarray, height: int, width: int) -> np.ndarray:
    """Give each pixel what its cell has, planes (..., cells_y, cells_x)."""
    rows = np.repeat(cells, CELL, axis=-1)[..., :width]
    return rows[..., np.arange(height) // CELL, :]


def neighbours(planes: np.ndarray, reach: int = 1) -> np.ndarray:
    """Add up (2 reach + 1)^2 neighbours in planes (..., h, w); beyond the border is nothing."""
    rows = planes.copy()
    for shift in range(1, reach + 1):
        rows[..., shift:, :] += planes[..., :-shift, :]
        rows[..., :-shift, :] += planes[..., shift:, :]
    result = rows.copy()
    for shift in range(1, reach + 1):
        result[..., shift:] += rows[..., :-shift]
        result[..., :-shift] += rows[..., shift:]
    return result
