"""Which samples a film holds: disjoint ranges of sample indices for every 8x8 cell.

Two films may be added only if no sample is in both. Films of uniform pictures hold the same ranges
in each cell; equal ranges are one shared object, and the union of two objects is worked out once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np

from alight.core.errors import FilmError

#: Width and height of a cell in pixels; cells are counted from the corner of the full film.
CELL_SIZE = 8


class SampleRanges:
    """A set of sample indices as sorted, disjoint, non-adjacent ranges [first, end).

    Parameters
    ----------
    ranges : iterable of (int, int)
        Pairs (first, end) with 0 <= first <= end, in any order; touching ones are joined.

    Raises
    ------
    FilmError
        If a range is reversed or negative, or if two of them overlap.

    Examples
    --------
    >>> SampleRanges([(32, 64), (0, 32), (100, 101)])
    SampleRanges([(0, 64), (100, 101)])
    """

    __slots__ = ("ranges",)

    def __init__(self, ranges: Iterable[tuple[int, int]] = ()) -> None:
        self.ranges = _normalised((int(first), int(end)) for first, end in ranges)

    @property
    def count(self) -> int:
        """How many samples there are."""
        return sum(end - first for first, end in self.ranges)

    def overlap(self, other: SampleRanges) -> SampleRanges:
        """Find the samples that are in both."""
        common = (
            (max(a, c), min(b, d))
            for a, b in self.ranges
            for c, d in other.ranges
            if max(a, c) < min(b, d)
        )
        return SampleRanges(common)

    def union(self, other: SampleRanges) -> SampleRanges:
        """All samples of both, as one shared object for equal operands.

        Raises
        ------
        FilmError
            If a sample is in both: its light would be counted twice.
        """
        return _union(self, other)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Visit the pairs (first, end)."""
        return iter(self.ranges)

    def __eq__(self, other: object) -> bool:
        """Compare the sets of samples."""
        return isinstance(other, SampleRanges) and self.ranges == other.ranges

    def __hash__(self) -> int:
        """Equal sets have equal hashes."""
        return hash(self.ranges)

    def __repr__(self) -> str:
        """Write the ranges as they are made."""
        return f"SampleRanges({list(self.ranges)})"

    def __str__(self) -> str:
        """Say the samples in words, the last one included."""
        return ", ".join(_in_words(first, end) for first, end in self.ranges) or "none"


def _in_words(first: int, end: int) -> str:
    """Samples from the first to the one before the end."""
    return f"{first}" if end == first + 1 else f"{first} to {end - 1}"


def _normalised(ranges: Iterable[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    joined: list[tuple[int, int]] = []
    for first, end in sorted(ranges):
        if not 0 <= first <= end:
            raise FilmError(f"sample range must have 0 <= first <= end, got [{first}, {end})")
        if first == end:
            continue
        if joined and first < joined[-1][1]:
            last = min(end, joined[-1][1])
            held = f"{'sample' if last == first + 1 else 'samples'} {_in_words(first, last)}"
            raise FilmError(f"{held} would be counted twice")
        if joined and first == joined[-1][1]:
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((first, end))
    return tuple(joined)


@lru_cache(maxsize=4096)
def _union(a: SampleRanges, b: SampleRanges) -> SampleRanges:
    return SampleRanges((*a.ranges, *b.ranges))


EMPTY = SampleRanges()


def empty_cells(width: int, height: int) -> np.ndarray:
    """Give one `SampleRanges` per cell of a film without samples.

    Parameters
    ----------
    width, height : int
        Size of the full film in pixels.

    Returns
    -------
    ndarray of object, shape (cells_y, cells_x)
    """
    return np.full((-(-height // CELL_SIZE), -(-width // CELL_SIZE)), EMPTY, dtype=object)


def cells_of(x: int, y: int, width: int, height: int) -> tuple[slice, slice]:
    """Index of the cells that a window of pixels of the full film touches."""
    return (
        slice(y // CELL_SIZE, -(-(y + height) // CELL_SIZE)),
        slice(x // CELL_SIZE, -(-(x + width) // CELL_SIZE)),
    )


def cells_with(pairs: np.ndarray) -> np.ndarray:
    """Make cells that hold one range of samples each; equal ranges are one object.

    Parameters
    ----------
    pairs : ndarray of int64, shape (cells_y, cells_x, 2)
        (first, count) of each cell.

    Returns
    -------
    ndarray of object, shape (cells_y, cells_x)
    """
    if pairs.size and (pairs == pairs[0, 0]).all():
        first, count = pairs[0, 0].tolist()
        return np.full(pairs.shape[:2], SampleRanges([(first, first + count)]), dtype=object)
    known: dict[tuple[int, int], SampleRanges] = {}
    cells = []
    for first, count in pairs.reshape(-1, 2).tolist():
        if (first, count) not in known:
            known[first, count] = SampleRanges([(first, first + count)])
        cells.append(known[first, count])
    return _grid(cells, pairs.shape[:2])


def union_of_cells(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Unite two grids of equal shape, cell by cell (refuses overlap as `SampleRanges.union`)."""
    # By identity: most cells share their object, and tiles are added often.
    ours, theirs = a.ravel().tolist(), b.ravel().tolist()
    if ours and all(cells.count(cells[0]) == a.size for cells in (ours, theirs)):
        return np.full(a.shape, _union(ours[0], theirs[0]), dtype=object)
    known: dict[tuple[int, int], SampleRanges] = {}
    cells = []
    for held, added in zip(ours, theirs, strict=True):
        pair = id(held), id(added)
        if pair not in known:
            known[pair] = _union(held, added)
        cells.append(known[pair])
    return _grid(cells, a.shape)


def _grid(cells: list[SampleRanges], shape: tuple[int, ...]) -> np.ndarray:
    grid = np.full(len(cells), EMPTY, dtype=object)
    grid[:] = cells
    return grid.reshape(shape)
