"""What laws work out of a description, kept from one law to the next."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from types import ModuleType
from typing import ParamSpec, TypeVar

from alight.core.registry import REGISTERED

P = ParamSpec("P")
R = TypeVar("R")


def remembered(most: int) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Keep the last results of a function, for as long as the same models are registered.

    Parameters
    ----------
    most : int
        How many results.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        # Descriptions stay equal when their model is registered anew: its module does not.
        @lru_cache(maxsize=most)
        def kept(models: tuple[ModuleType, ...], *args: P.args, **kwargs: P.kwargs) -> R:
            return function(*args, **kwargs)

        @wraps(function)
        def found(*args: P.args, **kwargs: P.kwargs) -> R:
            models = tuple(m for family in REGISTERED.values() for m in family.values())
            return kept(models, *args, **kwargs)

        return found

    return decorate
