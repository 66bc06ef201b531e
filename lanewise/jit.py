"""Marking, specialising and compiling kernels.

`kernel` only marks a plain Python function. `specialised` marks a factory that writes a kernel for
one *program* (the models that a scene uses and the options that are fixed while it renders).
`instantiate` walks the call graph from a root kernel, puts the program's own functions in the
places of the factories, and hands the result to Numba, or leaves it in Python (the NumPy twin).

Numba is imported by the first compilation, not before: loading scenes, asking for help and kernels
that were compiled before (`machine_code`) do not need a compiler.
"""

from __future__ import annotations

import builtins
import gc
import threading
import types
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import Any

from lanewise.application import setting, variable
from lanewise.kernel_text import check_text, explained, is_ours
from lanewise.machine_code import MachineCode, ObjectCode
from lanewise.marks import STRICT, Specialised, is_kernel, kernel, specialised
from lanewise.simd import WIDEST, LaneCount
from lanewise.source_digest import digest_of, digests_of_text

__all__ = ["FAST_MATH", "Specialised", "instantiate", "is_kernel", "kernel", "specialised"]

#: Fast-math of shading code. Never nnan or ninf: NaN must be seen, infinity is used as "no hit".
FAST_MATH = frozenset({"contract", "reassoc", "arcp", "nsz", "afn"})


def instantiate(
    root: Callable,
    program: Hashable = None,
    *,
    compiled: bool = True,
    observe: Callable[[Any, Callable], Callable] | None = None,
    lanes: int = WIDEST,
) -> Callable:
    """The kernel `root` for one program, ready to be called.

    Parameters
    ----------
    root : function
        A kernel, or a `Specialised` one.
    program : hashable, optional
        What the factories below `root` specialise on.
    compiled : bool, default True
        Machine code by Numba; False gives the same text in Python, for the NumPy twin.
    observe : callable, optional
        For the twin: given each kernel as text names it (a function or a `Specialised`) and what
        would be called in its place, it returns what is called, so that calls can be looked at.
    lanes : int, default 16
        For the twin: lanes of a packet, a power of two from 16 on. NumPy takes about as long for a
        few hundred numbers as for one.
    """
    if not compiled:
        return _PythonBuild(program, observe, lanes).get(root)

    if uses_stock_pipeline():
        return StockKernel(root, program)

    def compile_for(arguments: tuple) -> ObjectCode:
        build = _CompiledBuild(program)
        with no_garbage_collection(), explained(build.users):
            return load_compiler().object_code(build.get(root), arguments)

    text = root.factory if isinstance(root, Specialised) else root
    # The digest tells a kernel that is in no package from an older one of the same name.
    digest = digest_of({"root": text})
    identity = f"{text.__module__}.{text.__qualname__} {digest} {program!r}"
    return MachineCode(root.__name__, identity, compile_for)


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """A compiler makes millions of objects that stay: to look for cycles takes a tenth of it."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


class _Build(ABC):
    """One walk over the call graph; the subclasses say what a node becomes."""

    @abstractmethod
    def make(self, node: Callable, strict: bool) -> Any:
        """What a kernel becomes."""

    def __init__(self, program: Hashable):
        self.program = program
        self.done: dict[Any, Any] = {}

    def get(self, node: Any, strict: bool = False) -> Any:
        """The kernel `node` for this program, made once."""
        if isinstance(node, Specialised):
            node = self.text_of(node)
        strict = strict or getattr(node, STRICT)
        key = (node, strict)
        if key not in self.done:
            self.done[key] = self.make(node, strict)
        return self.done[key]

    def text_of(self, node: Specialised) -> Callable:
        """The kernel that a factory writes for this program (written once a build)."""
        key = (node, "text")
        if key not in self.done:
            self.done[key] = _write(node, self.program)
        return self.done[key]

    def replacement(self, value: Any, strict: bool) -> Any:
        """What stands for a value that kernel text names; the value itself if nothing must."""
        if isinstance(value, Specialised) or is_kernel(value):
            return self.get(value, strict)
        return value

    def clone(self, function: types.FunctionType, strict: bool) -> types.FunctionType:
        """The same code over globals and a closure in which kernels are replaced."""
        scope = dict(function.__globals__)
        for name in _names(function.__code__):
            value = scope.get(name, getattr(builtins, name, None))
            if value is not None:
                scope[name] = self.replacement(value, strict)
        cells = tuple(
            types.CellType(self.replacement(cell.cell_contents, strict))
            for cell in function.__closure__ or ()
        )
        copy = types.FunctionType(
            function.__code__, scope, function.__name__, function.__defaults__, cells or None
        )
        copy.__qualname__, copy.__module__ = function.__qualname__, function.__module__
        copy.__doc__ = function.__doc__
        return copy


class _PythonBuild(_Build):
    def __init__(
        self, program: Hashable, observe: Callable | None = None, lanes: int = WIDEST
    ) -> None:
        super().__init__(program)
        self.observe, self.lanes = observe, lanes

    def get(self, node: Any, strict: bool = False) -> Any:
        made = super().get(node, strict)
        return made if self.observe is None else self.observe(node, made)

    def make(self, node: Callable, strict: bool) -> Callable:
        # What an observed kernel calls is observed too.
        needed = self.observe is not None or self.lanes != WIDEST or depends_on_program(node)
        return self.clone(node, strict) if needed else node

    def replacement(self, value: Any, strict: bool) -> Any:
        if self.lanes != WIDEST:
            if isinstance(value, LaneCount):
                return LaneCount(self.lanes)
            if counts_lanes(value):
                return self.done.setdefault(value, self.clone(value, strict))
        return super().replacement(value, strict)


class _CompiledBuild(_Build):
    def __init__(self, program: Hashable, stock: bool = False) -> None:
        super().__init__(program)
        self.stock = stock
        self.compiler = load_compiler()
        #: Kernels that are neither of lanewise nor of its application.
        self.users: list[types.FunctionType] = []

    def get(self, node: Any, strict: bool = False) -> Any:
        root = not self.done
        if root:
            self.done[None] = None
            text = self.text_of(node) if isinstance(node, Specialised) else node
            return self.make(text, strict, root=True)
        return super().get(node, strict)

    def make(self, node: Callable, strict: bool, root: bool = False) -> Any:
        if not is_ours(node):
            check_text(node)
            self.users.append(node)
        strict = strict or getattr(node, STRICT)
        shared = not depends_on_program(node)
        key = (node, strict, root, self.stock)
        if shared and key in _SHARED:
            return _SHARED[key]
        fast_math = set() if strict else set(FAST_MATH)
        result = self.compiler.jit(
            self.clone(node, strict), fast_math=fast_math, root=root, stock=self.stock
        )
        if not self.stock:
            self.keep_on_disk(result, node, strict, root, *sorted(fast_math))
        if shared:
            _SHARED[key] = result
        return result

    def keep_on_disk(self, dispatcher: Any, node: Callable, strict: bool, *words: object) -> None:
        """Have a kernel's functions kept, if its text can be told from any other."""

        def digest_of_callee(value: Any) -> str | None:
            return self.compiler.digest_on_disk(self.get(value, strict))

        digests = digests_of_text(node, digest_of_callee, *words)
        if digests is not None:
            self.compiler.keep_on_disk(dispatcher, *digests)

    def replacement(self, value: Any, strict: bool) -> Any:
        value = self.compiler.primitive(value)
        return super().replacement(value, strict)


_SHARED: dict[tuple, Any] = {}

#: Modules of what kernels call for a packet as a whole.
_PRIMITIVES = frozenset({"lanewise.simd", "lanewise.records"})


@lru_cache(maxsize=4096)
def _write(node: Specialised, program: Hashable) -> Callable:
    text = node.factory(program)
    if isinstance(text, Specialised):
        return _write(text, program)
    if not is_kernel(text):
        raise TypeError(f"{node.__name__} must return a kernel, got {text!r}")
    return text


@cache
def depends_on_program(node: Any) -> bool:
    """True if a factory is reachable from the kernel `node`."""
    if isinstance(node, Specialised):
        return True
    if not is_kernel(node):
        return False
    used = [node.__globals__.get(name) for name in _names(node.__code__)]
    used += [cell.cell_contents for cell in node.__closure__ or ()]
    return any(depends_on_program(v) for v in used if isinstance(v, Specialised) or is_kernel(v))


def counts_lanes(value: Any) -> bool:
    """True of a primitive that depends on how many lanes a packet has."""
    if not isinstance(value, types.FunctionType) or value.__module__ not in _PRIMITIVES:
        return False
    return not {"LANES", "room_for"}.isdisjoint(value.__code__.co_names)


def _names(code: types.CodeType) -> set[str]:
    """Global names in a code object and in those nested in it."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= _names(constant)
    return names


# ---------------------------------------------------------------- the compiler


def uses_stock_pipeline() -> bool:
    """Whether ``LANEWISE_PIPELINE`` asks for Numba's own pipeline ("stock"; else "lean").

    Raises
    ------
    ValueError
        If it is neither.
    """
    asked = setting("PIPELINE") or "lean"
    if asked not in ("lean", "stock"):
        raise ValueError(f"{variable('PIPELINE')} must be lean or stock, got {asked!r}")
    return asked == "stock"


def dispatcher_of(root: Callable, program: Hashable = None, *, stock: bool = False) -> Any:
    """Numba's dispatcher of a root kernel, not compiled for any arguments yet."""
    return _CompiledBuild(program, stock).get(root)


class StockKernel:
    """A root kernel that Numba compiles with all its passes, loads and calls in its own way.

    Nothing is kept on disk. To find out whether a wrong result is due to `LeanCompiler`, to
    `MachineCode` or to the text: only the text is common to both.
    """

    def __init__(self, root: Callable, program: Hashable) -> None:
        self._root, self._program = root, program
        self._lock = threading.Lock()
        self._dispatcher: Any = None
        self._users: list[types.FunctionType] = []

    def __call__(self, *arguments: Any) -> None:
        """Run; the first call for arguments of new types compiles."""
        with self._lock:
            if self._dispatcher is None:
                build = _CompiledBuild(self._program, stock=True)
                self._dispatcher, self._users = build.get(self._root), build.users
        with explained(self._users):
            self._dispatcher(*arguments)

    def fixed(self) -> Callable[..., None]:
        """The same: Numba looks at the types of every call."""
        return self


@lru_cache(maxsize=1)
def load_compiler():
    """Import Numba and our compiler."""
    from lanewise import compiler

    return compiler
