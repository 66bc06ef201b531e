"""The exact weight of every surface in every pixel: a table with as many rows as there are pairs.

Each sample touches one pixel and is met by one surface at most, to which it adds the weight of the
pixel filter. The weights are whole numbers (`fixed_point`), so tables of tiles, passes and machines
add up in any order to the same bits, and nothing is cut off: ranks are a matter of the picture that
is written (`alight.films.mattes`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from alight.core.errors import FilmError, quote
from alight.films import fixed_point

#: Rows that may wait to be put in order.
_WAITING = 1 << 16


class SurfaceSums(NamedTuple):
    """Weights of surfaces in pixels; rows are in the order of pixels, then surfaces, each once.

    Attributes
    ----------
    pixels, surfaces : ndarray of int64, shape (n,)
        Numbers of the pixel, row by row, and of the surface.
    sums : ndarray of int64, shape (n, 2)
        Canonical fixed point.
    """

    pixels: np.ndarray
    surfaces: np.ndarray
    sums: np.ndarray

    @classmethod
    def gathered(cls, pixels: np.ndarray, surfaces: np.ndarray, sums: np.ndarray) -> SurfaceSums:
        """From rows in any order, in which pairs may occur several times."""
        sums = np.array(sums, np.int64)
        fixed_point.carry(sums)
        order = np.lexsort((surfaces, pixels))
        pixels, surfaces = pixels[order], surfaces[order]
        new = np.ones(len(order), bool)
        new[1:] = (pixels[1:] != pixels[:-1]) | (surfaces[1:] != surfaces[:-1])
        first = np.flatnonzero(new)
        # Low limbs are below 2^40: more than 2^22 of them have room.
        added = np.add.reduceat(sums[order], first, axis=0) if first.size else sums
        fixed_point.carry(added)
        return cls(pixels[first], surfaces[first], added)


def pack_sums(name: str, sums: SurfaceSums) -> dict[str, np.ndarray]:
    """The arrays of a table for an archive; none if it has no rows."""
    if not len(sums.pixels):
        return {}
    return {
        f"{name}.pixels": sums.pixels,
        f"{name}.surfaces": sums.surfaces,
        f"{name}.high": sums.sums[:, 0].copy(),
        f"{name}.low": sums.sums[:, 1].copy(),
    }


def unpack_sums(
    name: str, arrays: Mapping[str, np.ndarray], pixels_in_all: int, surfaces_in_all: int
) -> SurfaceSums:
    """What `pack_sums` gave.

    Parameters
    ----------
    name : str
    arrays : mapping of str to ndarray
    pixels_in_all, surfaces_in_all : int
        Of the film or tile that the table is of.

    Raises
    ------
    ValueError
        If the arrays are none of a table in its order, or name other pixels or surfaces.
    """
    if f"{name}.pixels" not in arrays:
        return no_sums()
    columns = [arrays[f"{name}.{part}"] for part in ("pixels", "surfaces", "high", "low")]
    pixels, surfaces, high, low = columns
    if any(one.shape != (len(pixels),) or one.dtype != np.int64 for one in columns):
        raise ValueError("columns of a table of coverage differ in length or type")
    step, further = np.diff(pixels), np.diff(surfaces) > 0
    if not ((step > 0) | ((step == 0) & further)).all():
        raise ValueError("rows of a table of coverage are out of order")
    if ((low < 0) | (low > fixed_point.LOW_MASK)).any():
        raise ValueError("weights of a table of coverage are no fixed-point numbers")
    for numbers, end in ((pixels, pixels_in_all), (surfaces, surfaces_in_all)):
        if ((numbers < 0) | (numbers >= end)).any():
            raise ValueError("a table of coverage weighs what is not there")
    return SurfaceSums(pixels, surfaces, np.stack([high, low], axis=-1))


def no_sums() -> SurfaceSums:
    """A table of no rows."""
    nothing = np.zeros(0, np.int64)
    return SurfaceSums(nothing, nothing, np.zeros((0, 2), np.int64))


class Coverage:
    """The table of a film, which grows; who uses it holds the film's lock.

    Parameters
    ----------
    names : sequence of (str, str)
        Of each surface those of its object and of its material.
    """

    def __init__(self, names: Sequence[tuple[str, str]]) -> None:
        self.names = tuple((str(thing), str(material)) for thing, material in names)
        self._sums, self._waiting, self._rows = no_sums(), [no_sums()], 0

    def add(self, sums: SurfaceSums) -> None:
        """Add rows whose pixels are those of the film."""
        self._waiting.append(sums)
        self._rows += len(sums.pixels)
        # All is put in order when it has doubled: each row waits and is moved a few times only.
        if self._rows > max(_WAITING, len(self._sums.pixels)):
            self._settle()

    def _settle(self) -> None:
        columns = zip(self._sums, *self._waiting, strict=True)
        self._sums = SurfaceSums.gathered(*map(np.concatenate, columns))
        self._waiting, self._rows = [], 0

    @property
    def sums(self) -> SurfaceSums:
        """All rows; they are never changed, so a copy is not needed."""
        if self._rows:
            self._settle()
        return self._sums

    def copy(self) -> Coverage:
        """The same rows in a table that grows by itself."""
        made = Coverage(self.names)
        made.add(self.sums)
        return made


def check_same_names(first: Coverage | None, other: Coverage | None, said: str) -> None:
    """Refuse tables whose rows stand for other things.

    Raises
    ------
    FilmError
    """
    if first is None or other is None:
        return
    if len(first.names) != len(other.names):
        text = f"the number of surfaces differs ({len(other.names)}, not {len(first.names)})"
        raise FilmError(f"{said}: {text}")
    for mine, theirs in zip(first.names, other.names, strict=True):
        for what, a, b in zip(("object", "material"), mine, theirs, strict=True):
            if a != b:
                raise FilmError(f"{said}: names differ ({what} {quote(b)}, not {quote(a)})")
