"""A digest of what kernels are made from: byte code, constants, globals and closures.

Text and comments play no part, so it is the same wherever a function was typed: in a file, in a
notebook or at the prompt.
"""

from __future__ import annotations

import hashlib
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from lanewise.application import LANEWISE, application
from lanewise.marks import Specialised, is_kernel


def digest_of(functions: dict[str, Any]) -> str:
    """Short digest of named functions and values, with all that they reach.

    Kernels and the functions of the same packages are read; others count by their names. Other
    sources of lanewise and of its application are another cache folder anyway
    (`lanewise.machine`).
    """
    given = [value for value in functions.values() if isinstance(value, FunctionType)]
    hashed = {LANEWISE.name, application().name}
    reader = _Reader({_top(function.__module__) for function in given} - hashed, hashed)
    reader.feed(functions)
    return reader.hash.hexdigest()[:16]


class _Reader:
    def __init__(self, packages: set[str], hashed: set[str]) -> None:
        self.hash = hashlib.sha256()
        self.packages, self.hashed = packages, hashed
        self.seen: dict[int, int] = {}
        # So that no other value gets the identity of one that was seen.
        self.kept: list[Any] = []

    def word(self, *parts: object) -> None:
        for part in parts:
            self.hash.update(f"{part}\0".encode())

    def feed(self, value: Any) -> None:
        """Add a value; the second time it is met, only which one it was."""
        if isinstance(value, str | bytes | int | float | complex | bool | None | np.generic):
            self.word(type(value).__name__, repr(value))
            return
        if id(value) in self.seen:
            self.word("again", self.seen[id(value)])
            return
        self.seen[id(value)] = len(self.seen)
        self.kept.append(value)
        if isinstance(value, np.ndarray):
            self.word("array", value.dtype, value.shape)
            self.hash.update(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, dict):
            self.items(value)
        elif isinstance(value, tuple | list):
            self.word(type(value).__name__, len(value))
            for item in value:
                self.feed(item)
        elif isinstance(value, set | frozenset):
            self.word("set", *sorted(map(repr, value)))
        elif isinstance(value, Specialised):
            self.feed(value.factory)
        elif isinstance(value, FunctionType):
            self.function(value)
        elif isinstance(value, CodeType):
            self.code(value)
        elif isinstance(value, type):
            self.word("class", value.__qualname__, getattr(value, "_fields", ""))
        else:
            self.word(type(value).__qualname__, getattr(value, "__name__", ""))

    def items(self, mapping: dict[Any, Any]) -> None:
        self.word("mapping", len(mapping))
        for key, value in mapping.items():
            self.word(key)
            self.feed(value)

    def function(self, function: FunctionType) -> None:
        top = _top(function.__module__)
        if top in self.packages or (is_kernel(function) and top not in self.hashed):
            self.code(function.__code__)
            self.items(dict(sorted(function.__dict__.items())))
            self.feed(function.__defaults__)
            self.globals(function)
        else:
            self.word("function", function.__module__, function.__qualname__)
        # Also of kernels that our own factories write: they differ by what they were given.
        for cell in function.__closure__ or ():
            self.feed(cell.cell_contents)

    def code(self, code: CodeType) -> None:
        self.word("code", code.co_argcount, code.co_names, code.co_varnames, code.co_freevars)
        self.hash.update(code.co_code)
        for constant in code.co_consts:
            self.feed(constant)

    def globals(self, function: FunctionType) -> None:
        names = sorted(_names(function.__code__))
        for name in names:
            if name in function.__globals__:
                value = function.__globals__[name]
                self.word(name)
                self.feed(value)
                if isinstance(value, ModuleType) and _top(value.__name__) not in self.hashed:
                    # ``constants.K``: kernel text sees the attribute.
                    self.items({key: vars(value)[key] for key in names if key in vars(value)})


def _top(module: str | None) -> str:
    return (module or "").split(".")[0]


def _names(code: CodeType) -> set[str]:
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names
