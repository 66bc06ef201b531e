"""A digest of what kernels are made from: byte code, constants, globals and closures.

Text and comments play no part, so it is the same wherever a function was typed: in a file, in a
notebook or at the prompt.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from enum import Enum
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from lanewise.application import LANEWISE, application
from lanewise.marks import Specialised, is_kernel
from lanewise.simd import LaneCount
from lanewise.vec3 import Vec3


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


#: Where an object is in memory says nothing of it.
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")


class _Reader:
    def __init__(self, packages: set[str], hashed: set[str]) -> None:
        self.hash = hashlib.sha256()
        self.packages, self.hashed = packages, hashed
        self.seen: dict[int, int] = {}
        # So that no other value gets the identity of one that was seen.
        self.kept: list[Any] = []

    def raw(self, data: bytes) -> None:
        self.hash.update(data)

    def word(self, *parts: object) -> None:
        for part in parts:
            self.raw(f"{part}\0".encode())

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
            self.raw(np.ascontiguousarray(value).tobytes())
        elif isinstance(value, dict):
            self.items(value)
        elif isinstance(value, tuple | list):
            self.word(type(value).__name__, len(value))
            for item in value:
                self.feed(item)
        elif isinstance(value, set | frozenset):
            self.word("set", *sorted(map(repr, value)))
        elif isinstance(value, Specialised):
            self.function(value.factory, is_text=True)
        elif isinstance(value, FunctionType):
            self.function(value)
        elif isinstance(value, CodeType):
            self.code(value)
        elif isinstance(value, Vec3):
            self.word("Vec3")
            self.feed((value.x, value.y, value.z))
        elif isinstance(value, type):
            self.word("class", value.__qualname__, getattr(value, "_fields", ""))
            self.feed(getattr(value, "_field_defaults", None))
            self.members(value)
        elif isinstance(value, ModuleType):
            self.word("module", value.__name__)  # `globals` reads what is used of it
        else:
            self.word(type(value).__qualname__, _ADDRESS.sub("", repr(value)))
            if hasattr(value, "py_func"):  # Numba's dispatchers
                self.function(value.py_func, is_text=True)

    def members(self, kind: type) -> None:
        """What kernels see of an enumeration."""
        if issubclass(kind, Enum):
            self.items({name: one.value for name, one in kind.__members__.items()})

    def items(self, mapping: dict[Any, Any]) -> None:
        self.word("mapping", len(mapping))
        for key, value in mapping.items():
            self.word(key)
            self.feed(value)

    def function(self, function: FunctionType, is_text: bool = False) -> None:
        top = _top(function.__module__)
        is_text = is_text or is_kernel(function)
        if top in self.packages or (is_text and top not in self.hashed):
            self.code(function.__code__)
            self.items(dict(sorted(function.__dict__.items())))
            self.feed(function.__defaults__)
            self.feed(function.__kwdefaults__)
            self.globals(function)
        else:
            self.word("function", function.__module__, function.__qualname__)
        # Also of kernels that our own factories write: they differ by what they were given.
        for cell in function.__closure__ or ():
            self.feed(cell.cell_contents)

    def code(self, code: CodeType) -> None:
        self.word("code", code.co_argcount, code.co_names, code.co_varnames, code.co_freevars)
        self.raw(code.co_code)
        for constant in code.co_consts:
            self.feed(constant)

    def globals(self, function: FunctionType) -> None:
        names = sorted(_names(function.__code__))
        for name in names:
            if name in function.__globals__:
                value = function.__globals__[name]
                self.word(name)
                self.feed(value)
                self.attributes(value, names)

    def attributes(self, value: Any, names: list[str], path: tuple[ModuleType, ...] = ()) -> None:
        """``constants.K``, ``package.constants.K``: kernel text sees the attribute."""
        if not isinstance(value, ModuleType) or _top(value.__name__) in self.hashed:
            return
        if value in path:  # modules may import each other
            return
        used = {key: vars(value)[key] for key in names if key in vars(value)}
        self.items(used)
        for one in used.values():
            self.attributes(one, names, (*path, value))


class UnreadableError(Exception):
    """A kernel names something of which no digest can be made."""


def digests_of_text(
    function: FunctionType, called: Callable[[Any], str | None], *circumstances: object
) -> tuple[str, str] | None:
    """Two short digests of one kernel's text, with what it calls and without.

    Unlike `digest_of`, it takes no sources for granted but those of lanewise.

    Parameters
    ----------
    function : function
        Kernel text, as it was written: with kernels and primitives, not with what replaces them.
    called : callable
        The digest of a kernel or `Specialised` that the text names; None if that has none.
    circumstances : object
        What else decides the code, as words.

    Returns
    -------
    (str, str) or None
        None if it is unknown what the text or what it calls is made from.
    """
    reader = _TextReader(called)
    try:
        reader.word(function.__module__, function.__qualname__, *circumstances)
        reader.text(function)
    except UnreadableError:
        return None
    return reader.hash.hexdigest()[:32], reader.alone.hexdigest()[:32]


class _TextReader(_Reader):
    """Reads once for two digests: the text takes most of the time."""

    def __init__(self, called: Callable[[Any], str | None]) -> None:
        super().__init__(set(), set())
        self.called, self.alone = called, hashlib.sha256()

    def raw(self, data: bytes) -> None:
        self.hash.update(data)
        self.alone.update(data)

    def text(self, function: FunctionType) -> None:
        self.code(function.__code__)
        self.feed(function.__defaults__)
        self.feed(function.__kwdefaults__)
        self.globals(function)
        for cell in function.__closure__ or ():
            self.feed(cell.cell_contents)

    def function(self, function: FunctionType, is_text: bool = False) -> None:
        if not is_kernel(function):
            raise UnreadableError(function)
        self.kernel(function)

    def kernel(self, value: Any) -> None:
        digest = self.called(value)
        if digest is None:
            raise UnreadableError(value)
        self.word("kernel")
        self.hash.update(f"{digest}\0".encode())

    def feed(self, value: Any) -> None:
        if isinstance(value, Specialised) or is_kernel(value):
            self.kernel(value)
        elif isinstance(value, BuiltinFunctionType | LaneCount) or _is_of_lanewise(value):
            self.word(_home(value), getattr(value, "__qualname__", type(value).__qualname__))
        elif isinstance(value, type):
            # A record. Kernels see its fields; methods are nothing to them.
            self.word("class", value.__module__, value.__qualname__, getattr(value, "_fields", ""))
            self.feed(getattr(value, "_field_defaults", None))
            self.members(value)
        elif isinstance(value, ModuleType):
            self.word("module", value.__name__)  # `globals` reads what is used of it
        elif isinstance(value, Vec3):
            self.word("Vec3")
            self.feed((value.x, value.y, value.z))
        elif isinstance(value, READABLE):
            if isinstance(value, tuple):
                self.word("record", type(value).__module__, getattr(value, "_fields", ""))
            super().feed(value)
        else:
            raise UnreadableError(value)


#: What a digest is made of part by part.
READABLE = (
    str, bytes, int, float, complex, type(None), np.generic, np.ndarray, dict, tuple, list, set,
    frozenset, FunctionType, CodeType,
)  # fmt: skip


def _is_of_lanewise(value: Any) -> bool:
    """A function or class of lanewise, whose text is in the name of the folder (`machine`)."""
    return isinstance(value, FunctionType | type) and _top(value.__module__) == LANEWISE.name


def _home(value: Any) -> str:
    """The module of a function, class or instance."""
    return getattr(value, "__module__", None) or type(value).__module__


def _top(module: str | None) -> str:
    return (module or "").split(".")[0]


def _names(code: CodeType) -> set[str]:
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names
