"""Results that are worked out from arrays once, however often they are needed."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def once(
    known: dict[tuple, T], arrays: tuple[np.ndarray, ...], other: Hashable, make: Callable[[], T]
) -> T:
    """What `make` gives, worked out once if the arrays are read-only.

    Parameters
    ----------
    known : dict
        Where results are kept, for as long as their arrays live.
    arrays : tuple of ndarray
        By which objects they are, not by their numbers.
    other : hashable
        What else the result depends on.
    make : callable
    """
    if any(array.flags.writeable for array in arrays):
        return make()
    key = (*map(id, arrays), other)
    if key not in known:
        known[key] = make()
        for array in arrays:
            weakref.finalize(array, known.pop, key, None)
    return known[key]
