"""Colours in files of other programs: what reading them has in common, however they are spelled.

A spectrum is reduced by what it is for (see `alight.core.spectra`). What a reader of
one format adds is how its elements spell numbers and name spectra.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, TypeVar

import numpy as np

from alight.core.errors import quote
from alight.core.spectra import reduction_error, to_linear_srgb
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError, Reach

Color = list[float]
#: A spectrum: wavelengths in nm, ascending, and values.
Pairs = tuple[np.ndarray, np.ndarray]
#: What a colour is for: it decides how a spectrum is reduced.
Role = Literal["reflectance", "index", "light"]
Item = TypeVar("Item")

LARGEST = 1e15
#: The least error of a reduction that is reported.
TOLD = 0.02
MOST_BYTES = 2**20


class NoColorError(ValueError):
    """Something that is no colour; the message says why."""


class ColorReader(ABC, Generic[Item]):
    """Reads colours.

    Parameters
    ----------
    report : Report
        Of the reader, with ``error(item, message)``.
    reach : Reach
        Finds files with spectra.
    """

    #: What `_read` raises where an item is no colour.
    PROBLEMS: ClassVar[tuple[type[ValueError], ...]] = (NoColorError, OutOfReachError)

    def __init__(self, report: Any, reach: Reach) -> None:
        self.report = report
        self.reach = reach
        self._files: dict[Path, Pairs] = {}

    def read(self, item: Item, role: Role) -> Color | None:
        """Read an item of the file that gives a colour.

        Returns
        -------
        list of 3 floats, or None
            Linear sRGB; None after a problem, which has been reported.
        """
        try:
            color = self._read(item, role)
        except self.PROBLEMS as error:
            self.report.error(item, str(error))
            return None
        if color is not None and max(color) > LARGEST:
            self.report.error(item, f"must be at most {LARGEST:g}, got {max(color):g}")
            return None
        return color

    @abstractmethod
    def _read(self, item: Item, role: Role) -> Color | None:
        """Find the colour; None after a problem that has been reported."""

    def _tell_error(self, item: Item, pairs: Pairs, role: Role) -> None:
        """Say how far light is off where three numbers stand for a spectrum."""
        if role == "index":
            return
        seen, again = reduction_error(*pairs, shines=role == "light")
        if max(seen, again) < TOLD:
            return
        after = "" if role == "light" else f", after two reflections by {100.0 * again:.0f} %,"
        off = f"it is seen off by {100.0 * seen:.0f} %{after} of its largest channel"
        text = f"is reduced to linear sRGB: {off}"
        self.report.warn(item, text)

    def _pairs_of_file(self, name: str) -> Pairs:
        """Read a file of lines "wavelength value", ``#`` before remarks, once."""
        path = self.reach.find(name)
        if path not in self._files:
            self._files[path] = _read_pairs(path, name)
        return self._files[path]


def _read_pairs(path: Path, name: str) -> Pairs:
    text = content_of(path, MOST_BYTES).decode("utf-8", "replace").replace(",", " ")
    words = " ".join(line.partition("#")[0] for line in text.splitlines()).split()
    try:
        numbers = np.array(words, np.float64)
    except ValueError:
        raise NoColorError(f"{quote(name)} holds words that are no numbers") from None
    if not np.isfinite(numbers).all():
        raise NoColorError(f"{quote(name)} holds numbers that are not finite")
    try:
        return pairs_of(numbers)
    except NoColorError as error:
        raise NoColorError(f"{quote(name)}: {error}") from None


def pairs_of(numbers: np.ndarray) -> Pairs:
    """A spectrum from wavelengths and values by turns.

    Raises
    ------
    NoColorError
        If it is none.
    """
    if len(numbers) < 4 or len(numbers) % 2:
        raise NoColorError(
            f"must hold pairs of wavelength in nm and value, at least 2, got {len(numbers)} numbers"
        )
    return checked(numbers[0::2], numbers[1::2])


def checked(wavelengths: np.ndarray, values: np.ndarray) -> Pairs:
    """The same, if it is a spectrum.

    Raises
    ------
    NoColorError
        If there are too few wavelengths, they do not ascend, or a value is negative or too large.
    """
    if len(values) < 2:
        raise NoColorError(f"must hold at least 2 wavelengths, got {len(values)}")
    if not (np.diff(wavelengths) > 0.0).all():
        raise NoColorError("wavelengths must ascend")
    if values.min() < 0.0 or values.max() > LARGEST:
        worst = values.min() if values.min() < 0.0 else values.max()
        raise NoColorError(f"values must be in [0, {LARGEST:g}], got {worst:g}")
    return wavelengths, values


def reduced(pairs: Pairs, role: Role) -> Color:
    """Reduce a spectrum to linear sRGB."""
    color = to_linear_srgb(*pairs, shines=role == "light")
    # A surface that is too bright by rounding, or in a channel that sRGB cannot show.
    return [min(channel, 1.0) for channel in color] if role == "reflectance" else color
