"""Goals cut into passes: what is missing in each cell, and how much of it is rendered at once."""

from __future__ import annotations

import math

import numpy as np

from alight.films import CELL_SIZE, Film, SampleRanges
from alight.films.sample_ranges import cells_of
from alight.rendering.schedules.schedule import Goal
from alight.rendering.tiles.tile_kernel import Tile

#: A pass is long enough for its overhead not to show: adding its sums to a film of 512x512 pixels
#: and 4 replicates takes 50 ms. Progress, checkpoints and cancelling do not wait for its end.
PASS_SECONDS = 2.0

#: Samples per pixel of a pass without an end: more than a film has room for.
_ENDLESS = 2**40


class Work:
    """What is left of a goal: the first gap of each cell.

    Parameters
    ----------
    goal : Goal
    film : Film
        Samples that it holds are not rendered again, wherever a render was stopped before.

    Attributes
    ----------
    next, end : ndarray of int64, shape (cells_y, cells_x)
        Samples next to end - 1 are missing.
    """

    def __init__(self, goal: Goal, film: Film) -> None:
        shape = film.cells.shape
        self.next, self.end = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
        window = cells_of(*film.crop)
        # Mostly all cells are alike, as in a new film.
        asked = goal.first[window], goal.count[window]
        held = film.cells[window]
        if held.size and all(part.min() == part.max() for part in asked):
            cells = held.ravel().tolist()
            if cells.count(cells[0]) == len(cells):
                gap = first_gap(cells[0], int(asked[0].flat[0]), int(asked[1].flat[0]))
                self.next[window], self.end[window] = gap
                return
        # Cells that hold the same samples share one object: by it a gap is known without a hash.
        gaps: dict[tuple[int, int, int], tuple[int, int]] = {}
        cells = held.ravel().tolist()
        firsts, counts = (part.ravel().tolist() for part in asked)
        found = []
        for cell, first, count in zip(cells, firsts, counts, strict=True):
            key = (id(cell), first, count)
            if key not in gaps:
                gaps[key] = first_gap(cell, first, count)
            found.append(gaps[key])
        both = np.array(found, np.int64).reshape(*held.shape, 2)
        self.next[window], self.end[window] = both[..., 0], both[..., 1]

    @property
    def left(self) -> int:
        """Samples per pixel that the cell with the most of them still lacks."""
        return int((self.end - self.next).max(initial=0))

    def take(self, step: int) -> np.ndarray:
        """Cut off a pass of `step` samples per pixel, or fewer where fewer are missing.

        A cell that lacks less than others gets less in each pass, so that all end together: the
        threads are evenly busy until the last one.

        Returns
        -------
        ndarray of int64, shape (cells_y, cells_x, 2)
            (first, count) of each cell.
        """
        missing = self.end - self.next
        step = min(step, self.left)
        count = -(-missing * step // max(self.left, 1))
        ranges = np.stack([self.next, count], axis=-1)
        self.next = self.next + count
        return ranges


def first_gap(cell: SampleRanges, first: int, count: int) -> tuple[int, int]:
    """Find the first range [next, end) of samples that a cell lacks of `count` after `first`."""
    end = first + count
    for begin, stop in cell:
        if begin > first:
            return first, min(begin, end)
        first = max(first, min(stop, end))
    return first, end


def ranges_of(tile: Tile, ranges: np.ndarray) -> np.ndarray:
    """Cut the cells that a tile touches out of those of the full film."""
    rows = slice(tile.y0 // CELL_SIZE, -(-tile.y1 // CELL_SIZE))
    return ranges[rows, tile.x0 // CELL_SIZE : -(-tile.x1 // CELL_SIZE)]


class Pace:
    """How many samples per pixel make a pass.

    Parameters
    ----------
    spp_per_pass : int, optional
        Fixed size; by default passes grow until one takes `seconds`.
    seconds : float

    Attributes
    ----------
    step : int
        Samples per pixel of the next pass, about.
    """

    def __init__(self, spp_per_pass: int | None, seconds: float = PASS_SECONDS) -> None:
        self._fixed = spp_per_pass is not None
        self._exact = self._fixed
        # Where passes have no end, the first one is all.
        self._endless = math.isinf(seconds)
        self._seconds = seconds
        self.step = spp_per_pass or (_ENDLESS if self._endless else 1)

    def count(self, missing: int) -> int:
        """Samples per pixel of the next pass, given how many are missing."""
        if self._exact:
            return min(self.step, missing)
        # Equal passes: a short one at the end would cost as much to add to the film as a long one.
        return -(-missing // max(round(missing / self.step), 1))

    def adapt(self, count: int, seconds: float, left: float | None) -> None:
        """Choose the size of the next pass.

        Parameters
        ----------
        count : int
            Samples per pixel of the last pass.
        seconds : float
            That it took.
        left : float or None
            Seconds until the time limit.
        """
        if self._fixed or self._endless:
            return
        seconds = max(seconds, 1e-9)
        self.step = max(1, min(16 * count, int(count * self._seconds / seconds)))
        self._exact = left is not None
        if left is not None:
            self.step = max(1, min(self.step, int(left / seconds * count)))
