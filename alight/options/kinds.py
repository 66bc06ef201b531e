"""What the value of an option may be: one check, and one message, for Python and the command line.

`check` takes what a Python call gives, `parse` what somebody has typed. Both give the value that
the renderer works with, or raise a `ValueError` whose text says what is wrong.
"""

from __future__ import annotations

import json
import numbers
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from alight.core.errors import quote, show_value, unknown_name


class Kind:
    """What an option may be.

    Attributes
    ----------
    metavar : str
        How help names a value.
    is_repeated : bool
        Whether the command line takes the option several times.
    """

    metavar = "TEXT"
    is_repeated = False

    def parse(self, text: Any) -> Any:
        """Read what was typed: a text, a list of texts if `is_repeated`, a bool of a switch."""
        return self.check(text)

    def check(self, value: Any) -> Any:
        """Give the value, or say why it is none."""
        return value

    def write(self, value: Any) -> Any:
        """Write a value as `parse` reads it."""
        return str(value)

    @property
    def range(self) -> str:
        """What is allowed, in words; empty where the type says it."""
        return ""


#: Names, or what gives them: those of a registry are looked up when a name is checked.
Known = Sequence[str] | Callable[[], Iterable[str]]


def listed(known: Known) -> list[str]:
    """List the names."""
    return list(known() if callable(known) else known)


@dataclass(frozen=True)
class Choice(Kind):
    """One of some names."""

    word: str
    known: Known
    metavar = "NAME"

    def check(self, value: Any) -> str:
        """Name the nearest one."""
        if value not in (known := listed(self.known)):
            raise ValueError(unknown_name(self.word, str(value), known))
        return value

    @property
    def range(self) -> str:
        """The names."""
        return f"one of {', '.join(listed(self.known))}"


@dataclass(frozen=True)
class Names(Kind):
    """Some of many names: a sequence of texts, or one text with commas.

    Examples
    --------
    >>> Names("layer", ("direct", "indirect")).check("direct, indirect")
    ('direct', 'indirect')
    """

    word: str
    known: Known
    metavar = "NAMES"

    def check(self, value: Any) -> tuple[str, ...]:
        """Name the nearest one of each that there is not."""
        texts = value.split(",") if isinstance(value, str) else value
        if not isinstance(texts, Sequence) or not all(isinstance(text, str) for text in texts):
            raise ValueError(f"must be names, got {show_value(value)}")
        names = tuple(name.strip() for name in texts if name.strip())
        known = listed(self.known)
        for name in names:
            if name not in known:
                raise ValueError(unknown_name(self.word, name, known))
        return names

    def write(self, value: Any) -> str:
        """With commas."""
        return ",".join(value)


class Paper(NamedTuple):
    """A size on paper, in inches."""

    width: float
    height: float

    @classmethod
    def read(cls, text: str) -> Paper | None:
        """From a text as ``3.5x2.5in``; None if it has no unit."""
        number = r"(\d{1,6}(?:\.\d{0,6})?|\.\d{1,6})"
        found = re.fullmatch(rf"{number}[x*]{number}\s*(in|cm|mm)", text)
        if found is None:
            return None
        unit = {"in": 1.0, "cm": 1.0 / 2.54, "mm": 1.0 / 25.4}[found[3]]
        return cls(float(found[1]) * unit, float(found[2]) * unit)

    def pixels(self, dpi: int) -> tuple[int, int]:
        """At so many pixels per inch, at least 1."""
        return max(1, round(self.width * dpi)), max(1, round(self.height * dpi))


class Size(Kind):
    """Pixels: (width, height), one number for a square, or a text as ``512x512``.

    A text may also be a size on paper, ``3.5x2.5in`` or ``9x6cm``: `SizedOptions` makes pixels of
    it.

    Examples
    --------
    >>> Size().check("640x480")
    (640, 480)
    >>> Size().check("3.5x2.5in")
    Paper(width=3.5, height=2.5)
    """

    metavar = "WxH"

    def check(self, value: Any) -> tuple[int, int] | Paper:
        """Read both; the scene checks their range."""
        if isinstance(value, Paper):
            return value
        if isinstance(value, str):
            text = value.strip().lower()
            if paper := Paper.read(text):
                return paper
            found = re.fullmatch(r"(\d{1,9})(?:[x,*](\d{1,9}))?", text)
            value = found and (int(found[1]), int(found[2] or found[1]))
            shown = quote(text)
        else:
            shown = show_value(value)
            value = (value, value) if isinstance(value, numbers.Integral) else value
        if (sizes := _whole_numbers(value, 2)) is None:
            text = "must be WIDTHxHEIGHT in pixels or on paper, as 512x512 or 9x6cm"
            raise ValueError(f"{text}, got {shown}")
        return sizes[0], sizes[1]

    def write(self, value: Any) -> str:
        """With an x."""
        return "x".join(map(str, value))


class Crop(Kind):
    """Part of a picture: (x, y, width, height), or a text as ``0,16,64,32``.

    Examples
    --------
    >>> Crop().check("0,16,64,32")
    (0, 16, 64, 32)
    """

    metavar = "X,Y,W,H"

    def check(self, value: Any) -> tuple[int, int, int, int]:
        """Read all four; the scene checks their range."""
        shown = show_value(value)
        if isinstance(value, str):
            numbers_ = r"(\d{1,9}),(\d{1,9}),(\d{1,9}),(\d{1,9})"
            found = re.fullmatch(numbers_, value.replace(" ", ""))
            value = found and [int(n) for n in found.groups()]
        if (edges := _whole_numbers(value, 4)) is None:
            raise ValueError(f"must be X,Y,WIDTH,HEIGHT in pixels, got {shown}")
        return edges[0], edges[1], edges[2], edges[3]

    def write(self, value: Any) -> str:
        """With commas."""
        return ",".join(map(str, value))


def _whole_numbers(value: Any, count: int) -> list[int] | None:
    value = value.tolist() if hasattr(value, "tolist") else value
    if not isinstance(value, Sequence) or len(value) != count:
        return None
    whole = [isinstance(n, numbers.Integral) and not isinstance(n, bool) for n in value]
    return [int(n) for n in value] if all(whole) else None


@dataclass(frozen=True)
class Text(Kind):
    """Any text or number; who uses it checks it."""

    metavar: str = "TEXT"

    def write(self, value: Any) -> str:
        """Numbers without digits that say nothing."""
        return f"{value:g}" if isinstance(value, float) else str(value)


class Switch(Kind):
    """On or off."""

    def check(self, value: Any) -> bool:
        """Refuse all but truth values."""
        if not isinstance(value, bool):
            raise ValueError(f"must be true or false, got {show_value(value)}")
        return value


@dataclass(frozen=True)
class File(Kind):
    """A path."""

    metavar: str = "FILE"

    def check(self, value: Any) -> Path:
        """Make a path of a text."""
        if not isinstance(value, str | os.PathLike):
            raise ValueError(f"must be a path, got {show_value(value)}")
        return Path(value)


@dataclass(frozen=True)
class Files(Kind):
    """Paths: one, or a sequence of them."""

    metavar: str = "FILE"
    is_repeated = True

    def check(self, value: Any) -> tuple[Path, ...]:
        """Make paths of texts."""
        several = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        return tuple(File().check(path) for path in several)

    def write(self, value: Any) -> list[str]:
        """Each for itself."""
        return [str(path) for path in value]


@dataclass(frozen=True)
class Texts(Kind):
    """Texts: one, or a sequence of them."""

    metavar: str = "TEXT"
    is_repeated = True

    def check(self, value: Any) -> tuple[str, ...]:
        """Refuse what is no text."""
        several = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        for text in several:
            if not isinstance(text, str):
                raise ValueError(f"must be texts as {self.metavar}, got {show_value(text)}")
        return tuple(several)

    def write(self, value: Any) -> list[str]:
        """Each for itself."""
        return list(value)


class Definitions(Kind):
    """Values of names: a mapping; on the command line ``NAME=VALUE``, any number of times.

    Examples
    --------
    >>> Definitions().parse(["spp=64", "scene=a=b"])
    {'spp': '64', 'scene': 'a=b'}
    """

    metavar = "NAME=VALUE"
    is_repeated = True

    def parse(self, text: Any) -> dict[str, str]:
        """Split each at its first equals sign."""
        found = {}
        for one in text:
            name, equals, value = one.partition("=")
            if not equals or not name.strip():
                raise ValueError(f"must be NAME=VALUE, got {quote(one)}")
            found[name.strip()] = value
        return found

    def check(self, value: Any) -> dict[str, str]:
        """Make texts of the values."""
        if not isinstance(value, Mapping):
            raise ValueError(f"must map names to values, got {show_value(value)}")
        return {str(name): str(one) for name, one in value.items()}

    def write(self, value: Any) -> list[str]:
        """Each for itself."""
        return [f"{name}={one}" for name, one in value.items()]


@dataclass(frozen=True)
class Anything(Kind):
    """An object that only Python can give.

    Parameters
    ----------
    type : str
        What it is, for the documentation: its class may stand above this package.
    has : str, default ""
        An attribute that it must have.
    """

    type: str = ""
    has: str = ""

    def check(self, value: Any) -> Any:
        """Refuse what would fail only later, when samples could be lost."""
        if value is not None and self.has and not hasattr(value, self.has):
            what = self.type or f"an object with {self.has}"
            raise ValueError(f"must be {what}, got {show_value(value)}")
        return value


@dataclass(frozen=True)
class PlainData(Anything):
    """A mapping that JSON can hold."""

    def check(self, value: Any) -> Any:
        """Refuse what a file could not hold."""
        try:
            if isinstance(value, Mapping):
                json.dumps(dict(value))
                return value
        except (TypeError, ValueError) as error:
            raise ValueError(f"must be plain JSON: {error}") from None
        raise ValueError(f"must be a mapping of plain JSON, got {show_value(value)}")
