"""Arguments of the functions that Python calls: what they are, and which words name them.

Options have tables (`alight.options`); this is for what a function is about: a scene, a film, a
path. A wrong one is told by its name at once, not by whatever line trips over it later.
"""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numpy as np

from alight.core.errors import OptionError, show_value, unknown_name

P = ParamSpec("P")
R = TypeVar("R")
V = TypeVar("V")

PATH = (str, os.PathLike)
WHOLE = (int, np.integer)


def expect(value: V, kinds: type | tuple[type, ...], name: str, wanted: str) -> V:
    """Give an argument back, or refuse it.

    Parameters
    ----------
    value : object
    kinds : type or tuple of types
        What it may be; a truth value is no number.
    name : str
        Of the argument.
    wanted : str
        What it may be, in words.

    Raises
    ------
    OptionError

    Examples
    --------
    >>> expect("a.png", PATH, "path", "a path")
    'a.png'
    >>> try:
    ...     expect(True, WHOLE, "width", "a whole number")
    ... except OptionError as error:
    ...     print(error)
    width: must be a whole number, got true
    """
    if isinstance(value, kinds) and not (isinstance(value, bool) and kinds is WHOLE):
        return value
    raise OptionError(f"must be {wanted}, got {show_value(value)}", name)


def expect_path(path: V) -> V:
    """Give a path back, or refuse what is none; see `expect`."""
    return expect(path, PATH, "path", "a path")


def known_words(hint: str = "") -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function refuse unknown keywords as options are refused, with the nearest name.

    Parameters
    ----------
    hint : str, optional
        The way to what people expect of other keywords.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        parameters = inspect.signature(function).parameters.values()
        words = [one.name for one in parameters if one.kind in (one.KEYWORD_ONLY, _EITHER)]

        @functools.wraps(function)
        def called(*args: P.args, **given: P.kwargs) -> R:
            _refuse_unknown(given, words, hint)
            return function(*args, **given)

        return called

    return decorate


_EITHER = inspect.Parameter.POSITIONAL_OR_KEYWORD


def _refuse_unknown(given: dict[str, Any], words: list[str], hint: str) -> None:
    for name in given:
        if name not in words:
            text = unknown_name("argument", name, words)
            raise OptionError(f"{text}; {hint}" if hint else text)
