"""Tiles: the sums that a film is given, where they belong in it, and whether they fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from alight.core.arguments import WHOLE, expect
from alight.core.errors import FilmError, OptionError, show_value
from alight.films import fixed_point
from alight.films.coverage import SurfaceSums
from alight.films.sample_ranges import CELL_SIZE, cells_of, cells_with
from lanewise.view import View

if TYPE_CHECKING:
    from alight.films.film import Film

#: Layers to which only the first sample of a pixel adds: a mean of numbers that name things would
#: name another thing.
FIRST_SAMPLE_LAYERS = frozenset({"id"})


class PartialFilm(NamedTuple):
    """What `render_tile` gives back: the sums of one tile.

    Attributes
    ----------
    x0, y0 : int
        Corner of the tile in pixels of the full film; a multiple of 8 or the corner of the crop.
    sums : ndarray of int64, shape (th, tw, R, C, 2)
        Fixed point, not necessarily canonical; `Film.add_tile` makes it so.
    counts : ndarray of int64, shape (th, tw, R)
    invalid, saturated : int
        Samples with NaN or infinity (added as 0) and sample values cut to 2^36.
    ranges : (int, int), or ndarray of int, shape (cells_y, cells_x, 2), or of SampleRanges
        (first, count) of the sample indices, for the whole tile or each 8x8 cell that it touches;
        or all of each cell, shape (cells_y, cells_x).
    aovs : mapping of str to ndarray of int64, shape (th, tw, c, 2)
        Fixed-point sums over all samples; of `FIRST_SAMPLE_LAYERS` only of sample 0 of each pixel,
        so that they add up whichever film holds it; zeros where none does.
    coverage : SurfaceSums, optional
        Weights of surfaces in the pixels of the tile, counted row by row.
    replicate : int, optional
        The only one that has samples here: then `sums` and `counts` have R = 1.
    """

    x0: int
    y0: int
    sums: np.ndarray
    counts: np.ndarray
    invalid: int
    saturated: int
    ranges: Any = None
    aovs: Mapping[str, np.ndarray] | None = None
    coverage: SurfaceSums | None = None
    replicate: int | None = None


def check_shape(width: int, height: int, crop: Any, replicates: int) -> None:
    """Refuse films of an impossible size or window."""
    for name, number in (("width", width), ("height", height), ("replicates", replicates)):
        expect(number, WHOLE, name, "a whole number")
    if width < 1 or height < 1:
        raise FilmError(f"film size must be at least 1x1 pixels, got {width}x{height}")
    if replicates < 1:
        raise FilmError(f"replicates must be at least 1, got {replicates}")
    if crop is not None:
        listed = isinstance(crop, list | tuple) or (isinstance(crop, np.ndarray) and crop.ndim > 0)
        whole = listed and all(isinstance(c, WHOLE) for c in crop)
        if not whole or len(crop) != 4:
            text = f"must be four whole numbers, x, y, width and height, got {show_value(crop)}"
            raise OptionError(text, "crop")
        x, y, w, h = crop
        if min(x, y) < 0 or min(w, h) < 1 or x + w > width or y + h > height:
            raise FilmError(
                f"crop {x},{y},{w},{h} must be a window of at least 1x1 pixels inside "
                f"the film of {width}x{height}"
            )


def check_channels(channels: Any, aovs: Any) -> None:
    """Refuse what are no names of channels, of the picture or of its layers."""
    wanted = 'names of channels, as ("R", "G", "B")'
    layers = 'channels by layers, as {"depth": ("Z",)}'
    lists = [(channels, "channels", wanted)]
    found = expect(aovs, (Mapping, type(None)), "aovs", layers)
    lists += [(names, "aovs", layers) for names in (found or {}).values()]
    for names, argument, text in lists:
        for name in expect(names, (list, tuple), argument, text):
            expect(name, str, argument, text)
    if len(channels) < 3:
        raise FilmError(f"a film needs at least the channels R, G, B, got {names_of(channels)}")


def window_of(film: Film, partial: PartialFilm) -> tuple[slice, slice, slice]:
    """Rows, columns and replicates of a film's arrays that a tile covers, checked."""
    x, y, w, h = film.crop
    th, tw = partial.counts.shape[:2]
    replicates = slice(0, film.replicates)
    if partial.replicate is not None:
        if not 0 <= partial.replicate < film.replicates:
            raise FilmError(f"a film of {film.replicates} replicates has no {partial.replicate}")
        replicates = slice(partial.replicate, partial.replicate + 1)
    shape = (th, tw, replicates.stop - replicates.start, len(film.channels), 2)
    if partial.sums.shape != shape or partial.counts.shape != shape[:3]:
        raise FilmError(
            f"a tile of this film has sums of shape {shape} and counts of shape {shape[:3]}, "
            f"got {partial.sums.shape} and {partial.counts.shape}"
        )
    if set(partial.aovs or {}) != set(film.aov_sums):
        raise FilmError(
            f"a tile of this film has the AOVs {names_of(film.aov_sums)}, "
            f"got {names_of(partial.aovs or {})}"
        )
    if (partial.coverage is None) != (film.coverage is None):
        raise FilmError("a tile must have a table of coverage if, and only if, the film has one")
    left, top = partial.x0 - x, partial.y0 - y
    if left < 0 or top < 0 or left + tw > w or top + th > h:
        raise FilmError(
            f"tile at ({partial.x0}, {partial.y0}) of {tw}x{th} pixels leaves the film's "
            f"window ({x}, {y}, {w}, {h})"
        )
    return slice(top, top + th), slice(left, left + tw), replicates


def ranges_of(film: Film, partial: PartialFilm) -> tuple[tuple[slice, slice], np.ndarray] | None:
    """Find the cells of a tile and the ranges that it adds to each."""
    if partial.ranges is None:
        return None
    x, y, w, h = film.crop
    th, tw = partial.counts.shape[:2]
    for name, first, size, low, high in (
        ("x", partial.x0, tw, x, x + w),
        ("y", partial.y0, th, y, y + h),
    ):
        # Half a cell marked as done would refuse its other half.
        end = first + size
        if (first % CELL_SIZE and first != low) or (end % CELL_SIZE and end != high):
            raise FilmError(f"tile edges must lie on 8x8 cells, got {name} from {first} to {end}")
    index = cells_of(partial.x0, partial.y0, tw, th)
    shape = film.cells[index].shape
    if np.asarray(partial.ranges).dtype.hasobject:
        return index, np.broadcast_to(partial.ranges, shape)
    pairs = np.broadcast_to(np.asarray(partial.ranges, np.int64), (*shape, 2))
    return index, cells_with(pairs)


def coverage_of(film: Film, partial: PartialFilm) -> SurfaceSums:
    """Rows of a tile's table by the pixels of the film."""
    assert partial.coverage is not None
    y, x = np.divmod(partial.coverage.pixels, partial.counts.shape[1])
    left, top = partial.x0 - film.crop[0], partial.y0 - film.crop[1]
    return partial.coverage._replace(pixels=(top + y) * film.crop[2] + left + x)


def check_room(film: Film, counts: np.ndarray) -> None:
    """Refuse more samples than sums can hold."""
    # AOVs have no replicates: all samples of a pixel share one sum.
    most = (counts.sum(axis=2) if film.aov_channels else counts).max(initial=0)
    if most > fixed_point.MAX_SAMPLES:
        unit = "pixel" if film.aov_channels else "pixel and replicate"
        raise FilmError(
            f"a film holds at most {fixed_point.MAX_SAMPLES} samples per {unit}, "
            f"asked for {most}; render with more replicates, or films of other seeds"
        )


def add_sums(target: np.ndarray, sums: np.ndarray) -> None:
    """Add fixed-point sums in place. Carrying first leaves limb 1 room for the addition."""
    fixed_point.carry(sums)
    target += sums
    fixed_point.carry(target)


def add_sums_compiled(
    add_rows: Callable, target: np.ndarray, window: tuple[slice, slice, slice], sums: np.ndarray
) -> None:
    """As `add_sums`, to rows, columns and replicates of `target`."""
    rows, columns, replicates = window
    row, pixel, one = target[0].size, target[0, 0].size, target[0, 0, 0].size
    start = row * rows.start + pixel * columns.start + one * replicates.start
    if sums.shape[2] == target.shape[2]:
        add_rows(View(target), start, row, View(sums), len(sums), sums[0].size // 2)
        return
    # Sums of one replicate lie apart from pixel to pixel.
    for y, of_row in enumerate(sums):
        add_rows(View(target), start + row * y, pixel, View(of_row), len(of_row), one // 2)


def names_of(names: Any) -> str:
    """A list of names for messages."""
    return ", ".join(sorted(names)) or "none"
