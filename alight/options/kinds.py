"""What the value of an option may be: one check, and one message, for Python and the command line.

`check` takes what a Python call gives, `parse` what somebody has typed. Both give the value that
the renderer works with, or raise a `ValueError` whose text says what is wrong.
"""

from __future__ import annotations

import numbers
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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


@dataclass(frozen=True)
class Whole(Kind):
    """A whole number in [least, most]."""

    least: int
    most: int
    metavar = "INTEGER"

    def parse(self, text: Any) -> int:
        """Read digits."""
        found = re.fullmatch(r"[+-]?\d{1,18}", text.strip())
        return self.check(int(text) if found else _number_or_text(text))

    def check(self, value: Any) -> int:
        """Refuse truth values and fractions, too."""
        whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
        if not whole or not self.least <= int(value) <= self.most:
            raise ValueError(f"must be a whole number {self.range}, got {show_value(value)}")
        return int(value)

    @property
    def range(self) -> str:
        """The interval."""
        return f"in [{self.least}, {self.most}]"


@dataclass(frozen=True)
class Seconds(Kind):
    """A time: a number of seconds, or a text such as ``90s``, ``5m`` or ``1.5h``.

    Examples
    --------
    >>> Seconds().check("5m")
    300.0
    """

    can_be_zero: bool = False
    metavar = "TIME"

    def check(self, value: Any) -> float:
        """Read the unit."""
        shown, seconds = show_value(value), value
        if isinstance(value, str):
            text = value.strip().lower()
            found = re.fullmatch(r"(\d{1,9}(?:\.\d{0,9})?(?:e[+-]?\d{1,2})?)\s*([smh]?)", text)
            if found is None:
                raise ValueError(f"must be a time such as 60s, 5m or 1h, got {quote(value)}")
            seconds = float(found[1]) * {"": 1, "s": 1, "m": 60, "h": 3600}[found[2]]
        elif isinstance(value, bool) or not isinstance(value, numbers.Real):
            raise ValueError(f"must be a time in seconds, or such as 60s, 5m or 1h, got {shown}")
        if not (seconds > 0 or (self.can_be_zero and seconds == 0)):
            raise ValueError(f"must be {self.range} seconds, got {value}")
        return float(seconds)

    def write(self, value: Any) -> str:
        """In seconds."""
        return f"{value!r}s".replace(".0s", "s")

    @property
    def range(self) -> str:
        """The least time."""
        return ">= 0" if self.can_be_zero else "> 0"


@dataclass(frozen=True)
class Share(Kind):
    """A number that may be written as a percentage, in [least, most] without the open ends.

    Examples
    --------
    >>> Share(0.0, 1.0).check("2.5%")
    0.025
    """

    least: float
    most: float
    least_is_open: bool = False
    most_is_open: bool = False
    metavar = "PERCENT"

    def check(self, value: Any) -> float:
        """Read a percentage."""
        share = value
        if isinstance(value, str):
            found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,12})?|\.\d{1,12})\s*(%?)", value.strip())
            if found is None:
                raise ValueError(f"must be a share such as 2% or 0.02, got {quote(value)}")
            share = float(found[1]) / (100.0 if found[2] else 1.0)
        elif isinstance(value, bool) or not isinstance(value, numbers.Real):
            raise ValueError(f"must be a share such as 2% or 0.02, got {show_value(value)}")
        above = self.least < share if self.least_is_open else self.least <= share
        below = share < self.most if self.most_is_open else share <= self.most
        if not (above and below):
            raise ValueError(f"must lie {self.range}, got {share:.6g}")
        return float(share)

    def write(self, value: Any) -> str:
        """In percent, if that says all of it."""
        percent = f"{100 * value:g}%"
        return percent if self.check(percent) == value else f"{value:.12f}"

    @property
    def range(self) -> str:
        """The interval, in percent."""
        low = f"({_percent(self.least)}" if self.least_is_open else f"[{_percent(self.least)}"
        return f"in {low}, {_percent(self.most)}{')' if self.most_is_open else ']'}"


def _percent(share: float) -> str:
    return f"{100 * share:g} %" if share else "0"


@dataclass(frozen=True)
class Number(Kind):
    """A number in (least, most), or with the ends."""

    least: float
    most: float
    is_closed: bool = False
    metavar = "FLOAT"

    def parse(self, text: Any) -> float:
        """Read a decimal number."""
        return self.check(_number_or_text(text))

    def check(self, value: Any) -> float:
        """Refuse what is no number."""
        real = isinstance(value, numbers.Real) and not isinstance(value, bool)
        ends = self.is_closed and real and value in (self.least, self.most)
        if not real or not (ends or self.least < float(value) < self.most):
            raise ValueError(f"must be a number {self.range}, got {_plain(value)}")
        return float(value)

    def write(self, value: Any) -> str:
        """All digits."""
        return repr(value)

    @property
    def range(self) -> str:
        """The interval."""
        ends = f"{self.least:g}", f"{self.most:g}"
        return f"in [{ends[0]}, {ends[1]}]" if self.is_closed else f"between {' and '.join(ends)}"


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _plain(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else show_value(value)


#: Names, or what gives them: those of a registry are asked for when a name is checked.
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


class Size(Kind):
    """Pixels: (width, height), one number for a square, or a text as ``512x512``.

    Examples
    --------
    >>> Size().check("640x480")
    (640, 480)
    """

    metavar = "WxH"

    def check(self, value: Any) -> tuple[int, int]:
        """Read both; the scene checks their range."""
        if isinstance(value, str):
            text = value.strip().lower()
            found = re.fullmatch(r"(\d{1,9})(?:[x,*](\d{1,9}))?", text)
            value = found and (int(found[1]), int(found[2] or found[1]))
            shown = quote(text)
        else:
            shown = show_value(value)
            value = (value, value) if isinstance(value, int) else value
        if (sizes := _whole_numbers(value, 2)) is None:
            raise ValueError(f"must be WIDTHxHEIGHT in pixels, as 512x512, got {shown}")
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
    """

    type: str = ""
