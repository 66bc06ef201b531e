"""Numbers in attributes: plain decimal ones, finite."""

from __future__ import annotations

import math
import re

from alight.core.errors import quote

MOST_NUMBERS = 100_000
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")


class NotNumbersError(ValueError):
    """A text that does not hold the numbers it should; the message says what it must be."""


def parse_number(text: str) -> float:
    """Read one finite number.

    Raises
    ------
    NotNumbersError
        If it is none.
    """
    word = text.strip()
    if not _NUMBER.fullmatch(word) or len(word) > 400:
        raise NotNumbersError(f"must be a number, got {quote(text)}")
    number = float(word)
    if not math.isfinite(number):
        raise NotNumbersError(f"must be finite, got {quote(text)}")
    return number


def parse_integer(text: str) -> int:
    """Read one whole number.

    Raises
    ------
    NotNumbersError
        If it is none.
    """
    number = parse_number(text)
    if number != int(number):
        raise NotNumbersError(f"must be a whole number, got {quote(text)}")
    return int(number)


def parse_numbers(text: str, *counts: int) -> list[float]:
    """Read numbers between commas or blanks.

    Parameters
    ----------
    text : str
    *counts : int
        How many there may be; any number if nothing is given.

    Raises
    ------
    NotNumbersError
        If there are others, or something is none.
    """
    words = text.replace(",", " ").split()
    if counts and len(words) not in counts:
        wanted = " or ".join(str(count) for count in counts)
        raise NotNumbersError(f"must hold {wanted} numbers, got {len(words)}: {quote(text)}")
    if len(words) > MOST_NUMBERS:
        raise NotNumbersError(f"must hold at most {MOST_NUMBERS} numbers, got {len(words)}")
    return [parse_number(word) for word in words]
