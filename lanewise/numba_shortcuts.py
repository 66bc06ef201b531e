"""Numba's work done in a shorter way, with the same result, while a kernel is compiled.

Compile time is a user's time, and most of it is Numba's own Python: some of no use to kernels, some
done over and over. Nothing here changes a bit of what is compiled.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import llvmlite.binding as llvm
from numba.core import (
    base,  # its `_has_loc` says whether a code generator takes ``loc``, by its signature
    errors,  # its `_termcolor_inst` colours messages, with methods that take and give text
    ir,  # its `Inst._rec_list_vars` lists each `Var` in a value of an instruction, in order
)
from numba.core.compiler_lock import global_compiler_lock  # is held while LLVM works
from numba.core.lowering import Lower  # its `lower_binop` writes the code of ``a + b``

#: (operator, types of operands) -> the function behind it, and the signature of that.
OPERATORS: dict[tuple, tuple[Any, Any]] = {}


class KernelLower(Lower):
    """Lowering that resolves an operator once, not at each of its uses.

    Numba tries every known overload of +, ours last, and writes a message for each that does not
    fit; and before that, whether the operands are constants, which kernels never learn.
    """

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        """Numba's method of this name."""
        if expr.static_lhs is not ir.UNDEFINED or expr.static_rhs is not ir.UNDEFINED:
            return super().lower_binop(resty, expr, op)
        context, builder = self.context, self.builder
        signature = self.fndesc.calltypes[expr]
        question = op, signature.args
        if question not in OPERATORS:
            function = context.typing_context.resolve_value_type(op)
            answer = function.get_call_type(context.typing_context, signature.args, {})
            OPERATORS[question] = function, answer
        function, answer = OPERATORS[question]
        names = expr.lhs.name, expr.rhs.name
        values = [self.loadvar(name) for name in names]
        operands = tuple(
            context.cast(builder, value, self.typeof(name), kind)
            for name, value, kind in zip(names, values, signature.args, strict=True)
        )
        result = context.get_function(function, answer)(builder, operands)
        return context.cast(builder, result, signature.return_type, resty)


@contextmanager
def shortcuts() -> Iterator[None]:
    """Compile in a shorter way; no other thread can compile meanwhile."""
    with global_compiler_lock, untold_of_locks(), ExitStack() as stack:
        for owner, name, other in (
            # Colours ask what terminal there is, for each message, of which none is shown.
            (errors, "_termcolor_inst", Uncoloured()),
            (ir.Inst, "_rec_list_vars", variables_in),
            (base, "_has_loc", cache(base._has_loc)),
        ):
            stack.callback(setattr, owner, name, getattr(owner, name))
            setattr(owner, name, other)
        yield


@contextmanager
def untold_of_locks() -> Iterator[None]:
    """Call LLVM without notifying Numba's timers of each call.

    There are two for each kernel on the way to the one that is being compiled: of the time for a
    Cornell box, a twentieth.
    """
    lock = llvm.ffi.lib._lock
    with global_compiler_lock:
        with lock._lock:
            told, lock._cblist = lock._cblist, []
        try:
            yield
        finally:
            with lock._lock:
                lock._cblist = told


class Uncoloured:
    """Marks up no message."""

    def __getattr__(self, name: str) -> type[str]:
        return str


def variables_in(_instruction: Any, value: Any, before: list | None = None) -> list:
    """Numba's method `_rec_list_vars` of an instruction, which makes a list for each value."""
    found: list = [] if before is None else before
    if isinstance(value, str):  # most are
        pass
    elif isinstance(value, ir.Var):
        found.append(value)
    elif isinstance(value, ir.Inst):
        found.extend(value.list_vars())
    elif isinstance(value, list | tuple | dict):
        for one in value.values() if isinstance(value, dict) else value:
            variables_in(_instruction, one, found)
    return found


def leave_scipy_alone() -> None:
    """Keep Numba from importing SciPy's linear algebra to see whether it is there.

    It does so before it compiles anything, a quarter of a second, and again when it needs it.
    """
    if "numba.np.arraymath" in sys.modules or not find_spec("scipy"):
        return
    # Its `ensure_blas` does that, and `arraymath` calls it as it is imported.
    linalg: Any = import_module("numba.np.linalg")
    import_it = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        arraymath: Any = import_module("numba.np.arraymath")
        arraymath.ensure_blas = import_it
    finally:
        linalg.ensure_blas = import_it
