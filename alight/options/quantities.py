"""Kinds of options that are numbers: whole ones, times, shares, any."""

from __future__ import annotations

import numbers
import re
from dataclasses import dataclass
from typing import Any

from alight.core.errors import quote, show_value
from alight.options.kinds import Kind

_MOST_FRAMES = 10_000_000


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
class Frames(Kind):
    """A range of frames: (first, the one after the last), or a text as ``0:120``.

    Examples
    --------
    >>> Frames().check("0:120")
    (0, 120)
    """

    metavar = "FIRST:END"

    def check(self, value: Any) -> tuple[int, int]:
        """Read both; the range must not be empty."""
        shown = show_value(value)
        if isinstance(value, str):
            found = re.fullmatch(r"\s*(\d{1,9}):(\d{1,9})\s*", value)
            value = found and (int(found[1]), int(found[2]))
        is_pair = isinstance(value, tuple | list) and len(value) == 2
        whole = is_pair and all(isinstance(n, int) and not isinstance(n, bool) for n in value)
        if not whole or not 0 <= value[0] < value[1] <= _MOST_FRAMES:
            raise ValueError(
                f"must be FIRST:END with 0 <= FIRST < END <= {_MOST_FRAMES}, as 0:120, got {shown}"
            )
        return value[0], value[1]

    def write(self, value: Any) -> str:
        """With a colon."""
        return f"{value[0]}:{value[1]}"


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


class Part(Kind):
    """One of several equal parts: (number, of how many), counted from 1, or a text as ``3/40``.

    Examples
    --------
    >>> Part().check("3/40")
    (3, 40)
    """

    metavar = "I/N"

    def check(self, value: Any) -> tuple[int, int]:
        """Read both."""
        shown = show_value(value)
        if isinstance(value, str):
            found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", value.strip())
            value = found and (int(found[1]), int(found[2]))
        whole = isinstance(value, tuple | list) and all(type(number) is int for number in value)
        if not whole or len(value) != 2 or not 1 <= value[0] <= value[1]:
            raise ValueError(f"must be I/N with 1 <= I <= N, as 3/40, got {shown}")
        return value[0], value[1]

    def write(self, value: Any) -> str:
        """With a slash."""
        return f"{value[0]}/{value[1]}"
