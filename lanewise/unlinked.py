"""Functions of kernels before they are linked with what they call.

What a kernel's text becomes depends on the functions that it calls only through their types. So
text whose callees have changed is neither typed nor lowered again: it is linked with the new ones
and optimised. A combination of models of which each was met before costs LLVM's part alone.

That is right only if every call, those included that type inference asked about on its way to the
final types, has the signature that it had, and if calls of one function are still calls of one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from copy import copy
from functools import cache
from types import FunctionType
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba import types

from lanewise.numba_adapter import OptimisedLibrary, TypingError, as_compiled, bare_descriptor


class Call(NamedTuple):
    """What type inference asked about a kernel, and was answered.

    Attributes
    ----------
    name : str
        What the text calls the kernel.
    arguments, keywords : tuple, dict
        Types that were asked about.
    signature : str
        What the function that is called takes and gives, with the names of fields: types alone are
        the same where a record's fields have been renamed or swapped.
    symbol : str
        Its name in LLVM IR.
    """

    name: str
    arguments: tuple
    keywords: dict
    signature: str
    symbol: str


class Unlinked(NamedTuple):
    """A function without those that it calls.

    Attributes
    ----------
    descriptor : Numba function descriptor
    digest : str
        What its name in LLVM IR ends with.
    bitcode : bytes
        Its own module.
    calls : tuple of Call
    linked : tuple of int
        The calls whose functions it is linked with, in this order.
    is_root : bool
        As of `OptimisedLibrary`.
    """

    descriptor: Any
    digest: str
    bitcode: bytes
    calls: tuple[Call, ...]
    linked: tuple[int, ...]
    is_root: bool


def unlinked(compiled: Any, function: FunctionType, digest: str) -> Unlinked | None:
    """Take what was compiled apart; None if that cannot be done.

    Parameters
    ----------
    compiled : Numba compile result
    function : function
        The text, in which other text was replaced by dispatchers.
    digest : str
        Of the text and all that it calls.
    """
    library = compiled.library
    if library.alone is None:
        return None
    named = kernels_named(function)
    names = {id(kernel): name for name, kernel in named.items()}
    uses = Counter(map(id, named.values()))
    calls, libraries = [], []
    for (kernel, arguments, keywords), answer in library.calls:
        # By which of two names was it called? Next time they may be two kernels.
        if uses[id(kernel)] != 1 or takes_kernels((*arguments, *keywords.values())):
            return None
        callee = kernel.overloads[answer.args]
        calls.append(
            Call(
                names[id(kernel)], arguments, keywords,
                signature=_signature(answer),
                symbol=callee.fndesc.llvm_func_name,
            )
        )  # fmt: skip
        libraries.append(callee.library)
    if not all(used in libraries for used in library.linked):
        return None  # with one of Numba's own functions
    linked = tuple(libraries.index(used) for used in library.linked)
    return Unlinked(
        bare_descriptor(compiled), digest, library.alone, tuple(calls), linked, library.is_root
    )


def link(found: Unlinked, function: FunctionType, digest: str, target_context: Any) -> Any:
    """Link a function with what its text calls now; None if it has to be compiled.

    Parameters
    ----------
    found : Unlinked
        The same text, for arguments of the same types.
    function, digest
        As for `unlinked`.
    target_context : Numba target context

    Returns
    -------
    compiled : Numba compile result or None
    """
    named = kernels_named(function)
    libraries, symbols = [], {}
    for call in found.calls:
        kernel = named[call.name]
        try:
            asked = types.Dispatcher(kernel)
            answer = asked.get_call_type(kernel.typingctx, call.arguments, call.keywords)
        except TypingError:
            return None
        if answer is None or _signature(answer) != call.signature:
            return None
        callee = kernel.overloads[answer.args]
        libraries.append(callee.library)
        symbol = callee.fndesc.llvm_func_name
        if symbols.setdefault(call.symbol, symbol) != symbol:
            return None
    if len(set(symbols.values())) < len(symbols):
        return None
    descriptor = copy(found.descriptor)
    for part in ("mangled_name", "env_name", "unique_name", "uid"):
        setattr(descriptor, part, getattr(descriptor, part).replace(found.digest, digest))
    module = llvm.parse_bitcode(found.bitcode)
    _rename(module, lambda name: symbols.get(name) or name.replace(found.digest, digest))
    library = OptimisedLibrary(target_context.codegen(), descriptor.qualname)
    library.is_root = found.is_root
    library.take_in(module)
    for at in found.linked:
        library.add_linking_library(libraries[at])
    return as_compiled(descriptor, library, target_context)


def _signature(answer: Any) -> str:
    return " ".join(map(description, (*answer.args, answer.return_type)))


def _rename(module: llvm.ModuleRef, renamed: Callable[[str], str]) -> None:
    symbols = [*module.functions, *module.global_variables]
    names = [renamed(symbol.name) for symbol in symbols]
    # LLVM alters a name that another symbol has, so two cannot swap theirs at once.
    for number, symbol in enumerate(symbols):
        symbol.name = f"lanewise.{number}"
    for symbol, name in zip(symbols, names, strict=True):
        symbol.name = name
        assert symbol.name == name, f"two symbols are called {name}"


def takes_kernels(arguments: Iterable[Any]) -> bool:
    """Whether arguments of these types are kernels, or tuples that hold one."""
    return any(
        isinstance(kind, types.Dispatcher)
        or (isinstance(kind, types.BaseTuple) and takes_kernels(kind))
        for kind in arguments
    )


@cache
def description(kind: Any) -> str:
    """A type as far as code depends on it: of a record, also what its fields are called."""
    if isinstance(kind, types.BaseTuple):
        record = getattr(kind, "instance_class", tuple)
        name = f"{record.__module__}.{record.__qualname__}{getattr(record, '_fields', '')}"
        return f"{name}({', '.join(map(description, kind))})"
    return f"{type(kind).__qualname__} {kind}"


def kernels_named(function: FunctionType) -> dict[str, Any]:
    """The dispatchers among the globals and in the closure that a text names, by name."""
    code, scope = function.__code__, function.__globals__
    found = {name: scope[name] for name in code.co_names if name in scope}
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        found[name] = cell.cell_contents
    return {name: value for name, value in found.items() if hasattr(value, "overloads")}
