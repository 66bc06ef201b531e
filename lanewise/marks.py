"""Marks functions as kernel source; nothing is compiled here."""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

#: Attributes that mark a function as kernel text, and as strict.
KERNEL, STRICT = "__lanewise_kernel__", "__lanewise_strict__"


def kernel(function: Callable | None = None, *, strict: bool = False) -> Callable:
    """Mark a function as kernel text.

    Parameters
    ----------
    strict : bool, default False
        Compile without any fast-math, this function and everything that it calls. For edge
        functions, error bounds and exact sums, where a reordered or contracted operation is a bug.
    """
    if function is None:
        return lambda f: kernel(f, strict=strict)
    setattr(function, KERNEL, True)
    setattr(function, STRICT, strict)
    return function


class Specialised:
    """A kernel that is written anew for each program; calling it needs `instantiate`."""

    def __init__(self, factory: Callable[[Any], Callable]):
        self.factory = factory
        self.__name__ = factory.__name__
        self.__doc__ = factory.__doc__

    def __call__(self, *args) -> Any:
        """Refuse: the text is not written yet."""
        raise TypeError(f"{self.__name__} depends on the program: use instantiate() first")


def specialised(factory: Callable[[Any], Callable]) -> Specialised:
    """Mark a factory ``program -> kernel`` whose name kernels can call like a kernel."""
    return Specialised(factory)


def is_kernel(value: Any) -> bool:
    """True for functions marked with `kernel`."""
    return isinstance(value, types.FunctionType) and hasattr(value, KERNEL)
