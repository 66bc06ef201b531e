"""A classical bug of path tracers as a small patch, with the test that must find it."""

from __future__ import annotations

from typing import NamedTuple


class Mutant(NamedTuple):
    """One bug.

    Attributes
    ----------
    name : str
        The bug, in words.
    file : str
        Inside the package.
    edits : tuple of (str, str)
        Texts that occur exactly once in the file, and what takes their places.
    killer : str
        The test, as pytest names it, that passes without the bug and fails with it.
    package : str, default "alight"
        The package that it is planted in.
    """

    name: str
    file: str
    edits: tuple[tuple[str, str], ...]
    killer: str
    package: str = "alight"
