"""Functions of kernels on disk, as optimised LLVM bitcode: found by their text, not by their file.

Only a root kernel becomes machine code (`lanewise.machine_code`), and any change of a source asks
for all of them again. What they consist of stays: a function whose text, and whose callees' text,
is as before is read instead of compiled. So is what two programs have in common. A function whose
text is as before, but not that of its callees, is linked with these anew (`lanewise.unlinked`).

A function's name in LLVM IR ends with the digest of its text, so that functions of several
processes can meet in one module. Numba's own functions are counted in each process; kernels call
few of them (`lanewise.scalar_instructions`) and have them inlined.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

from lanewise.kept_files import read_kept, write_kept
from lanewise.machine import functions_folder
from lanewise.numba_adapter import (
    DIGEST,
    NullCache,
    OptimisedLibrary,
    as_compiled,
    bare_descriptor,
    look_in,
)
from lanewise.unlinked import Unlinked, description, link, takes_kernels, unlinked

#: Functions of the same text and for the same arguments, whose callees have other types.
VARIANTS = 4


def keep_on_disk(dispatcher: Any, digest: str, alone: str) -> None:
    """Look for a kernel's functions on disk before compiling them, and keep them there.

    Parameters
    ----------
    dispatcher : Numba dispatcher
        The kernel.
    digest : str
        Of its text and all that it calls.
    alone : str
        Of its text without what it calls.
    """
    setattr(dispatcher.py_func, DIGEST, digest)
    look_in(dispatcher, KeptFunctions(dispatcher.py_func, digest, alone))


def digest_on_disk(dispatcher: Any) -> str | None:
    """The digest that `keep_on_disk` was given; None of a kernel that is not kept."""
    return getattr(dispatcher.py_func, DIGEST, None)


class KeptFunctions(NullCache):
    """The functions of one kernel, by the types of their arguments.

    A function that is found is neither typed nor lowered, nor is what it calls: its bitcode has
    that inside already. Where only what it calls is new, it is linked with that. A function that
    takes kernels is not kept: what they do is not in its text.
    """

    def __init__(self, function: FunctionType, digest: str, alone: str) -> None:
        self.function, self.digest, self.alone = function, digest, alone

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Numba asks for a function before it compiles one; None has it compiled."""
        if takes_kernels(sig):
            return None
        kept = _unpickled(_path(sig, self.digest))
        if kept is not None:
            descriptor, bitcode = kept
            library = OptimisedLibrary(target_context.codegen(), descriptor.qualname)
            library.load(bitcode)
            return as_compiled(descriptor, library, target_context)
        for path in self._of_text(sig):
            kept = _unpickled(path)
            parts = None if kept is None else Unlinked(*kept)
            compiled = parts and link(parts, self.function, self.digest, target_context)
            if compiled is not None:
                self._keep_optimised(sig, compiled)
                return compiled
        return None

    def save_overload(self, sig: Any, cres: Any) -> None:
        """Numba has compiled a function."""
        if takes_kernels(sig):
            return
        self._keep_optimised(sig, cres)
        parts = unlinked(cres, self.function, self.digest)
        if parts is not None:
            for path in self._of_text(sig):
                if read_kept(path) is None:
                    _pickle(path, tuple(parts), _types_in(parts))
                    break

    def _of_text(self, sig: Any) -> Iterator[Path]:
        """Where the text is kept without its callees: once for each types that these had."""
        return (_path(sig, self.alone, f"{number}.unlinked") for number in range(VARIANTS))

    def _keep_optimised(self, sig: Any, compiled: Any) -> None:
        kept = bare_descriptor(compiled), compiled.library.bitcode()
        _pickle(_path(sig, self.digest), kept, _types_of(compiled.fndesc))


def _path(arguments: Any, digest: str, form: str = "bitcode") -> Path:
    """Where a function for arguments of these types is kept."""
    words = "|".join((digest, *map(description, arguments)))
    return functions_folder() / f"{hashlib.sha256(words.encode()).hexdigest()[:32]}.{form}"


def _types_of(descriptor: Any) -> Iterator[Any]:
    yield descriptor.restype
    yield from descriptor.argtypes


def _types_in(parts: Unlinked) -> Iterator[Any]:
    yield from _types_of(parts.descriptor)
    for call in parts.calls:
        yield from call.arguments
        yield from call.keywords.values()


def _pickle(path: Path, parts: tuple, kinds: Iterable[Any]) -> None:
    """Keep a descriptor and what follows it, if the types in it can be read again."""
    if not all(map(comes_back, kinds)):
        return
    try:
        content = pickle.dumps(parts)
    except Exception:  # a function of a text without a module, for instance
        return
    write_kept(path, {}, content)


@cache
def comes_back(kind: Any) -> bool:
    """Whether a type is the same after pickling."""
    try:
        return pickle.loads(pickle.dumps(kind)) == kind
    except Exception:  # a record that cannot be imported by its name
        return False


def _unpickled(path: Path) -> Any:
    """What `_pickle` kept, or None."""
    kept = read_kept(path)
    if kept is None:
        return None
    try:
        return pickle.loads(kept[1])
    except Exception:  # whatever unpickling runs into, for instance a class that has moved
        return None
