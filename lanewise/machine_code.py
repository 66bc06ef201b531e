"""Compiled root kernels: kept on disk as object code, loaded and called without the compiler.

Importing Numba takes 0.9 s and 150 MB, most of what a small picture takes otherwise. It is needed
to compile; but object code is brought to life by LLVM alone, and a root kernel is a C function of
numbers and pointers, which `ctypes` calls. Kernels that were just compiled go the same way, so
there is one way only.
"""

from __future__ import annotations

import ctypes
import hashlib
import threading
from collections.abc import Callable, Iterator
from functools import lru_cache
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lanewise.kept_files import read_kept, write_kept
from lanewise.machine import cache_folder
from lanewise.vec3 import Vec3
from lanewise.view import View

#: Arguments as C sees them, by their LLVM types; every pointer is "ptr".
C_TYPES = {
    "i8": ctypes.c_int8,
    "i32": ctypes.c_int32,
    "i64": ctypes.c_int64,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "ptr": ctypes.c_void_p,
}


class ObjectCode(NamedTuple):
    """What the compiler makes of a root kernel for arguments of certain types.

    Attributes
    ----------
    symbol : str
        Name of the C function ``int f(void *result, void **error, ...)``; both are not used, since
        kernels return nothing and raise nothing.
    arguments : tuple of str
        Keys of `C_TYPES`: what follows.
    code : bytes
        An object file.
    """

    symbol: str
    arguments: tuple[str, ...]
    code: bytes


class MachineCode:
    """A root kernel, ready to be called with tables (`View`), numbers and nested tuples of them.

    Parameters
    ----------
    name : str
        First part of the names of its files.
    identity : str
        Everything beside sources, machine and types of arguments that decides the code.
    compile_for : callable or None
        Given a tuple of arguments, the `ObjectCode` for their types. None has `codes` only.
    codes : dict of str to ObjectCode, optional
        By `kind_of` the arguments: what is there already.

    Notes
    -----
    Pickled, it is its object code for the arguments that it was called with so far: for a process
    of the same fingerprint, which then needs neither compiler nor cache.
    """

    def __init__(
        self,
        name: str,
        identity: str,
        compile_for: Callable[[tuple], ObjectCode] | None,
        codes: dict[str, ObjectCode] | None = None,
    ) -> None:
        self.name, self.identity, self.compile_for = name, identity, compile_for
        self._codes = codes or {}
        self._entries: dict[str, Callable] = {}
        self._lock = threading.Lock()

    def __call__(self, *arguments: Any) -> None:
        """Run; the types of all arguments are looked at."""
        self.entry(arguments)(*leaves(arguments))

    def entry(self, arguments: tuple) -> Callable:
        """The function for the types of these arguments, which takes their `leaves`."""
        kind = kind_of(arguments)
        if kind not in self._entries:
            with self._lock:
                if kind not in self._entries:
                    self._entries[kind] = self._load(kind, arguments)
        return self._entries[kind]

    def _load(self, kind: str, arguments: tuple) -> Callable:
        if kind not in self._codes:
            self._codes[kind] = self._found_or_compiled(kind, arguments)
        return _brought_to_life(self._codes[kind])

    def _found_or_compiled(self, kind: str, arguments: tuple) -> ObjectCode:
        if self.compile_for is None:
            raise TypeError(f"{self.name} was compiled elsewhere, and not for arguments {kind}")
        path = self.path(arguments)
        compiled = read_code(path)
        if compiled is None:
            compiled = self.compile_for(arguments)
            write_code(path, compiled)
        return compiled

    def path(self, arguments: tuple, target: str | None = None) -> Path:
        """Where its code for the types of these arguments is kept, by default for our target."""
        words = f"{self.identity}\0{kind_of(arguments)}"
        digest = hashlib.sha256(words.encode()).hexdigest()[:24]
        return cache_folder(target) / f"{self.name}-{digest}.kernel"

    def __reduce__(self) -> tuple[Any, ...]:
        return MachineCode, (self.name, self.identity, None, self._codes)

    def fixed(self) -> FixedKernel:
        """The same, for arguments whose types do not change from call to call."""
        return FixedKernel(self)


class FixedKernel:
    """A root kernel for arguments whose types do not change from call to call.

    For nested tuples of tables, looking at them takes longer than a small tile. Tuples that are
    given again, as the same object, are not even taken apart. A table that is an argument itself is
    not kept: it may be most of the memory of whoever calls.

    Parameters
    ----------
    kernel : MachineCode
    """

    def __init__(self, kernel: MachineCode) -> None:
        self.kernel = kernel
        self._entry: Callable | None = None
        self._known: dict[int, tuple[Any, tuple]] = {}

    def __call__(self, *arguments: Any) -> None:
        """Run; only the first call looks at the types."""
        if self._entry is None:
            self._entry = self.kernel.entry(arguments)
        known, parts = self._known, []
        for place, argument in enumerate(arguments):
            if not isinstance(argument, tuple):
                parts += leaves(argument)
                continue
            kept = known.get(place)
            if kept is None or kept[0] is not argument:
                # Whoever calls keeps what a tuple holds alive; a replaced pair does no harm.
                kept = known[place] = (argument, tuple(leaves(argument)))
            parts += kept[1]
        self._entry(*parts)

    def __reduce__(self) -> tuple[Any, ...]:
        return FixedKernel, (self.kernel,)


def leaves(value: Any, address_of: Callable[[View], int] = attrgetter("address")) -> Iterator[Any]:
    """Numbers and addresses in an argument, in the order in which compiled code takes them."""
    if isinstance(value, View):
        yield address_of(value)
        yield value.size
    elif isinstance(value, Vec3):
        yield from (float(value.x), float(value.y), float(value.z))
    elif isinstance(value, tuple):
        for part in value:
            yield from leaves(part, address_of)
    elif isinstance(value, np.generic):
        yield value.item()
    else:
        yield value


def kind_of(value: Any) -> str:
    """The type of an argument as far as compiled code depends on it."""
    if isinstance(value, View):
        return f"View[{_name_of(value.dtype)}]"
    if isinstance(value, tuple):
        name = f"{type(value).__qualname__}{getattr(value, '_fields', '')}"
        return f"{name}({', '.join(map(kind_of, value))})"
    if isinstance(value, np.generic):
        return _name_of(value.dtype)
    return type(value).__qualname__


@lru_cache(maxsize=32)
def _name_of(dtype: np.dtype) -> str:
    """The name of a type of numbers, which NumPy makes anew each time, as slowly as 30 calls."""
    return str(dtype)


# ---------------------------------------------------------------- on disk


def read_code(path: Path) -> ObjectCode | None:
    """What `write_code` wrote; None if there is nothing, or nothing whole."""
    kept = read_kept(path)
    if kept is None:
        return None
    header, code = kept
    return ObjectCode(header["symbol"], tuple(header["arguments"]), code)


def write_code(path: Path, compiled: ObjectCode) -> None:
    """Keep code."""
    header = {"symbol": compiled.symbol, "arguments": compiled.arguments}
    write_kept(path, header, compiled.code)


# ---------------------------------------------------------------- in memory


@lru_cache(maxsize=32)
def _brought_to_life(compiled: ObjectCode) -> Callable:
    """The C function, as a callable of its leaves; the same code again is not loaded again."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    # An engine each: names are unique in the process that compiled, not among all files.
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(compiled.code))
    engine.finalize_object()
    address = engine.get_function_address(compiled.symbol)
    types = [C_TYPES[argument] for argument in compiled.arguments]
    function = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *types)(address)
    # Room for the result, which is none, and for a pointer to what was raised, which is nothing.
    unused = (ctypes.c_int64 * 2)()
    result, error = ctypes.byref(unused), ctypes.byref(unused, 8)

    # The code lives as long as its engine.
    function.engine = engine  # pyright: ignore[reportAttributeAccessIssue]

    def run(*numbers: Any) -> None:
        status = function(result, error, *numbers)
        assert status == 0, f"{compiled.symbol} ended with {status}"

    return run
