"""What a compilation leaves for the next one of nearly the same scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

Made = TypeVar("Made")

#: What a function makes of a large array, known by the object, and a small one, known by its bits.
Each = Callable[[Callable[[np.ndarray, np.ndarray], Any], np.ndarray, np.ndarray], Any]


class Kept:
    """Results of the last compilation, used again where what they are made of is the same.

    They are the same bits: what is kept are results of functions whose arguments decide them, and
    which nobody changes afterwards. Of each name only the newest result is kept.

    Examples
    --------
    >>> kept = Kept()
    >>> first = kept("sums", np.cumsum, np.arange(4))
    >>> kept("sums", np.cumsum, np.arange(4)) is first
    True
    """

    def __init__(self) -> None:
        self._last: dict[str, tuple[tuple[Any, ...], Any]] = {}
        self._each: dict[str, dict[tuple[int, bytes], tuple[np.ndarray, Any]]] = {}

    def __call__(self, name: str, make: Callable[..., Made], *arguments: Any) -> Made:
        """What a function makes of its arguments, or made of equal ones the last time."""
        last = self._last.get(name)
        if last is None or not is_same(last[0], arguments):
            last = self._last[name] = arguments, make(*arguments)
        return last[1]

    def each(self, name: str) -> Each:
        """Keep many results of one name: those that this compilation asks for."""
        before, now = self._each.get(name, {}), {}
        self._each[name] = now

        def known(make: Callable[[np.ndarray, np.ndarray], Any], a: np.ndarray, b: np.ndarray):
            key = id(a), b.tobytes()
            found = before.get(key)
            if found is None or found[0] is not a or a.flags.writeable:
                found = a, make(a, b)
            now[key] = found
            return found[1]

        return known


def is_same(one: Any, other: Any) -> bool:
    """Whether two values are equal, arrays in them bit for bit."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and np.array_equal(_bytes_of(one), _bytes_of(other))
        )
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(is_same, one, other))
    return bool(one == other)


def _bytes_of(array: np.ndarray) -> np.ndarray:
    """See an array as bytes: -0 is not 0, and NaN is itself."""
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8)
