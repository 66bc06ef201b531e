"""Text -> words, each with its place: bare words, quoted texts, brackets, and lists of numbers."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

#: Words of a file: a remark, a quoted text, a bracket, or what stands between blanks.
_WORD = re.compile(r'#[^\n]*|"(?:[^"\\\n]|\\.)*"|[\[\]]|[^\s"\[\]#]+|"[^\n]*')
#: Nothing but numbers, so that a list of a million can be read at once.
_NUMBERS = re.compile(r"[0-9eE+\-.\s]*")
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "b": "\b", "f": "\f"}


class BrokenError(ValueError):
    """Text that is no scene of pbrt; the message says why.

    Parameters
    ----------
    message : str
    place : str
        ``file:line:column``.
    """

    def __init__(self, message: str, place: str) -> None:
        super().__init__(message)
        self.place = place


@dataclass(frozen=True)
class Word:
    """One word.

    Attributes
    ----------
    text : str
        Quoted texts without their quotes.
    at : int
        Position of its first character.
    quoted : bool
        Whether it stood in quotes.
    """

    text: str
    at: int
    quoted: bool = False


class Words:
    """Reads a text word by word.

    Parameters
    ----------
    text : str
    name : str
        Of the file, for messages.
    after : Words, optional
        Of the file that includes this one: parameters may go on there.
    """

    def __init__(self, text: str, name: str, after: Words | None = None) -> None:
        self.text = text
        self.name = name
        self.after = after
        self.at = 0
        self._next: Word | None = None
        self._lines: list[int] | None = None

    def place(self, at: int) -> str:
        """Give the ``file:line:column`` of a position."""
        if self._lines is None:
            self._lines = [0, *(m.end() for m in re.finditer("\n", self.text))]
        line = bisect_right(self._lines, at)
        return f"{self.name}:{line}:{at - self._lines[line - 1] + 1}"

    def peek(self) -> Word | None:
        """Look at the next word; None at the end."""
        if self._next is None:
            self._next = self._read()
        return self._next

    def take(self) -> Word | None:
        """Take the next word; None at the end."""
        word = self.peek()
        self._next = None
        return word

    def _read(self) -> Word | None:
        for match in _WORD.finditer(self.text, self.at):
            word = match[0]
            if word[0] == "#":
                continue
            self.at = match.end()
            if word[0] != '"':
                return Word(word, match.start())
            if len(word) < 2 or word[-1] != '"':
                raise BrokenError("this text has no closing quote", self.place(match.start()))
            return Word(_unescaped(word[1:-1]), match.start(), quoted=True)
        self.at = len(self.text)
        return None

    def take_numbers(self) -> np.ndarray | None:
        """Take what stands up to the closing bracket, if it is numbers only; float64."""
        if self._next is not None:
            return None
        end = self.text.find("]", self.at)
        if end < 0 or not _NUMBERS.fullmatch(self.text, self.at, end):
            return None
        try:
            numbers = np.array(self.text[self.at : end].split(), np.float64)
        except ValueError:
            return None
        if not np.isfinite(numbers).all():
            return None
        self.at = end + 1
        return numbers


def _unescaped(text: str) -> str:
    if "\\" not in text:
        return text
    return re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), text)


def number_of(word: Word) -> float | None:
    """Read a word as a finite number; None if it is none."""
    if word.quoted or len(word.text) > 400 or not _NUMBER.fullmatch(word.text):
        return None
    number = float(word.text)
    return number if np.isfinite(number) else None
