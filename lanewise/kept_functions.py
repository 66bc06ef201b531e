"""Functions of kernels on disk, as optimised LLVM bitcode: found by their text, not by their file.

Only a root kernel becomes machine code (`lanewise.machine_code`), and any change of a source asks
for all of them again. What they consist of stays: a function whose text, and whose callees' text,
is as before is read instead of compiled. So is what two programs have in common.

A function's name in LLVM IR ends with the digest of its text, so that functions of several
processes can meet in one module. Numba's own functions, such as `max` of two integers, are counted
in each process; of those that kernels call, two of one name are the same function.
"""

from __future__ import annotations

import hashlib
import pickle
from pathlib import Path
from typing import Any

from numba import types

from lanewise.kept_files import read_kept, write_kept
from lanewise.machine import functions_folder
from lanewise.numba_adapter import DIGEST, NullCache, bare_descriptor, from_bitcode, look_in


def keep_on_disk(dispatcher: Any, digest: str) -> None:
    """Look for a kernel's functions on disk before compiling them, and keep them there.

    Parameters
    ----------
    dispatcher : Numba dispatcher
        The kernel.
    digest : str
        Of its text and all that it calls.
    """
    setattr(dispatcher.py_func, DIGEST, digest)
    look_in(dispatcher, KeptFunctions(digest))


def digest_on_disk(dispatcher: Any) -> str | None:
    """The digest that `keep_on_disk` was given; None of a kernel that is not kept."""
    return getattr(dispatcher.py_func, DIGEST, None)


class KeptFunctions(NullCache):
    """The functions of one kernel, by the types of their arguments.

    A function that is found is neither typed nor lowered, nor is what it calls: its bitcode has
    that inside already.
    """

    def __init__(self, digest: str) -> None:
        self.digest = digest

    def path(self, arguments: Any) -> Path:
        """Where the function for arguments of these types is kept."""
        words = "|".join((self.digest, *map(description, arguments)))
        return functions_folder() / f"{hashlib.sha256(words.encode()).hexdigest()[:32]}.bitcode"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Numba asks for a function before it compiles one; None has it compiled."""
        kept = read_kept(self.path(sig))
        if kept is None:
            return None
        try:
            descriptor, bitcode = pickle.loads(kept[1])
        except Exception:  # whatever unpickling runs into, for instance a class that has moved
            return None
        return from_bitcode(descriptor, bitcode, target_context)

    def save_overload(self, sig: Any, cres: Any) -> None:
        """Numba has compiled a function."""
        descriptor = bare_descriptor(cres)
        try:
            content = pickle.dumps((descriptor, cres.library.bitcode()))
            found, _ = pickle.loads(content)
        except Exception:  # a record that cannot be imported by its name
            return
        if found.restype == descriptor.restype and found.argtypes == descriptor.argtypes:
            write_kept(self.path(sig), {}, content)


def description(kind: Any) -> str:
    """A type as far as code depends on it: of a record, also what its fields are called."""
    if isinstance(kind, types.BaseTuple):
        record = getattr(kind, "instance_class", tuple)
        name = f"{record.__module__}.{record.__qualname__}{getattr(record, '_fields', '')}"
        return f"{name}({', '.join(map(description, kind))})"
    return f"{type(kind).__qualname__} {kind}"
