"""Photometric profiles of lamps: the files of LM-63 (``.ies``), 1986 to 2002, type C.

A file gives the candelas of a lamp over vertical angles from its axis (0 straight ahead, which is
down for a lamp that hangs) and horizontal angles around it, often only those that symmetry leaves.

Source: IES LM-63-02, Standard File Format for the Electronic Transfer of Photometric Data.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError, quote

#: Steps of the grid that kernels look up: vertical in [0, 180], horizontal in [0, 360] degrees.
VERTICAL_STEP, HORIZONTAL_STEP = 0.5, 1.0

#: Largest file, bytes, and most numbers of one.
_MOST_BYTES, _MOST_VALUES = 1 << 24, 1 << 20

_SUFFIX = ".ies"
_HEADER = 13
_TYPES = {2: "B", 3: "A"}
#: First and last horizontal angle that are allowed, and what they leave to symmetry.
_SPANS = ((0.0, 0.0), (0.0, 90.0), (0.0, 180.0), (0.0, 360.0), (90.0, 270.0))


class Profile(NamedTuple):
    """Luminous intensities of a lamp.

    Attributes
    ----------
    vertical : (v,) float64, degrees
        Ascending, in [0, 180].
    horizontal : (h,) float64, degrees
        Ascending; see `profile_problem`.
    candela : (h, v) float64
    """

    vertical: NDArray[np.float64]
    horizontal: NDArray[np.float64]
    candela: NDArray[np.float64]


def profile_problem(profile: Profile) -> str | None:
    """Say what is wrong with angles and values, if anything is."""
    vertical, horizontal, candela = profile
    for name, angles in (("vertical", vertical), ("horizontal", horizontal)):
        finite = angles.ndim == 1 and len(angles) > 0 and np.isfinite(angles).all()
        if not finite or not np.all(np.diff(angles) > 0.0):
            return f"{name} angles must ascend, got {_some(angles)}"
    if not (vertical[0] >= 0.0 and vertical[-1] <= 180.0):
        return f"vertical angles must lie in [0, 180], got {_some(vertical)}"
    if (horizontal[0], horizontal[-1]) not in _SPANS:
        return (
            "horizontal angles must be 0 alone, or go from 0 to 90, 180 or 360, or from 90 to 270, "
            f"got {horizontal[0]:g} to {horizontal[-1]:g}"
        )
    if candela.shape != (len(horizontal), len(vertical)):
        return (
            f"candela must be {len(horizontal)} rows of {len(vertical)} numbers, one a horizontal "
            f"and one a vertical angle, got {' x '.join(map(str, candela.shape))}"
        )
    if not (np.isfinite(candela).all() and candela.min() >= 0.0 and candela.max() <= 1e15):
        return "candela must be finite and not negative"
    return None


def _some(angles: np.ndarray) -> str:
    shown = ", ".join(f"{angle:g}" for angle in np.ravel(angles)[:6])
    return shown + (", ..." if angles.size > 6 else "")


def read_profile(path: Path, name: str = "") -> Profile:
    """Read a file.

    Parameters
    ----------
    path : Path
    name : str, optional
        How messages call it.

    Raises
    ------
    SceneError
        If it is missing or is no such file; the issue's path is ``file``.
    """
    name = name or str(path)
    try:
        if path.suffix.lower() != _SUFFIX:
            raise ValueError(f"must be a file of LM-63 with the ending {_SUFFIX}")
        if path.stat().st_size > _MOST_BYTES:
            raise ValueError(f"is larger than {_MOST_BYTES >> 20} MB")
        return parse_profile(path.read_text("latin-1"))
    except OSError as error:
        text = f"{quote(name)}: {(error.strerror or 'cannot be read').lower()}"
    except ValueError as error:
        text = f"{quote(name)}: {error}"
    raise SceneError([Issue("file", text)])


def parse_profile(text: str) -> Profile:
    """The profile of a file's text.

    Raises
    ------
    ValueError
        If it is not one of LM-63, or of a kind that is not read.
    """
    found = re.search(r"^[ \t]*TILT[ \t]*=[ \t]*(.*?)[ \t]*$", text, re.MULTILINE)
    if found is None:
        raise ValueError("is not an LM-63 file: a line TILT= is missing")
    numbers = _Numbers(text[found.end() :])
    tilt = found[1].upper()
    if tilt == "INCLUDE":
        # How a lamp dims when it is tilted: ours is as it was measured.
        numbers.take(1, "geometry of the tilt")
        numbers.take(2 * numbers.count("pairs of the tilt"), "tilt")
    elif tilt != "NONE":
        raise ValueError(f"TILT={found[1]}: another file is not read; TILT must be NONE or INCLUDE")
    first = numbers.take(3, "lamps")
    sizes = [numbers.count("vertical angles"), numbers.count("horizontal angles")]
    kind, rest = numbers.count("photometric type"), numbers.take(_HEADER - 6, "header")
    if kind != 1:
        known = f"type {_TYPES[kind]}" if kind in _TYPES else f"type number {kind}"
        raise ValueError(f"holds photometry of {known}: only type C (number 1) is read")
    if sizes[0] * sizes[1] > _MOST_VALUES:
        raise ValueError(f"has {sizes[0]} x {sizes[1]} values: at most {_MOST_VALUES} are read")
    vertical = numbers.take(sizes[0], "vertical angles")
    horizontal = numbers.take(sizes[1], "horizontal angles")
    values = numbers.take(sizes[0] * sizes[1], "candela values").reshape(sizes[1], sizes[0])
    # Multiplier; factors of the ballast and of its lamp.
    with np.errstate(over="ignore", invalid="ignore"):
        # What is too large, or no number, is found below.
        candela = values * (first[2] * rest[4] * rest[5])
    profile = Profile(vertical, horizontal, candela)
    problem = profile_problem(profile)
    if problem:
        raise ValueError(problem)
    return profile


class _Numbers:
    """The numbers of a file in their order."""

    def __init__(self, text: str):
        self.words = re.split(r"[\s,]+", text.strip())
        self.at = 0

    def take(self, count: int, what: str) -> NDArray[np.float64]:
        """The next numbers."""
        words = self.words[self.at : self.at + count]
        self.at += count
        if len(words) < count:
            raise ValueError(f"ends among the {what}: {count} numbers, got {len(words)}")
        try:
            return np.array([float(word) for word in words])
        except ValueError:
            wrong = next(word for word in words if not _is_number(word))
            raise ValueError(f"{what}: must be numbers, got {wrong[:40]!r}") from None

    def count(self, what: str) -> int:
        """The next whole number, at least 1."""
        value = float(self.take(1, what)[0])
        if not (1.0 <= value <= _MOST_VALUES and value == int(value)):
            raise ValueError(f"{what}: must be a whole number from 1 on, got {value:g}")
        return int(value)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def grid(profile: Profile) -> NDArray[np.float64]:
    """Candelas at even angles: rows are vertical, columns horizontal; dark where nothing is given.

    Returns
    -------
    (361, 361) or (361, 1) float64
        One column for a lamp that is the same all around.
    """
    vertical, horizontal, candela = profile
    down = np.arange(0.0, 180.0 + 0.5 * VERTICAL_STEP, VERTICAL_STEP)
    planes = np.array([np.interp(down, vertical, row, left=0.0, right=0.0) for row in candela])
    if len(horizontal) == 1:
        return planes.T.copy()
    around = folded(np.arange(0.0, 360.0 + 0.5 * HORIZONTAL_STEP, HORIZONTAL_STEP), horizontal)
    return np.array([np.interp(around, horizontal, column) for column in planes.T])


def folded(around: NDArray[np.float64], horizontal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in [0, 360] degrees, mapped to those of a file by symmetry."""
    first, last = horizontal[0], horizontal[-1]
    if first == 90.0:
        turned = (around - 90.0) % 360.0
        return 90.0 + np.minimum(turned, 360.0 - turned)
    if last == 360.0:
        return around
    half = np.minimum(around, 360.0 - around)
    return np.minimum(half, 180.0 - half) if last == 90.0 else half
