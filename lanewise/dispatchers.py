"""Numba's dispatchers of kernels: which options, and for arguments of which types."""

from __future__ import annotations

from functools import partial
from typing import Any

from numba import njit, types

from lanewise.numba_adapter import LeanCompiler, StockCompiler, TypingError


def jit(function: Any, *, fast_math: set[str], root: bool, stock: bool = False) -> Any:
    """A Numba dispatcher; of lean root kernels `object_code` makes something to be called."""
    dispatcher = njit(  # pyright: ignore[reportCallIssue]
        function,
        nogil=True,
        fastmath=fast_math,
        error_model="numpy",
        pipeline_class=StockCompiler if stock else LeanCompiler,
        # Only Numba's own calls from Python need these.
        no_cpython_wrapper=not (root and stock),
        no_cfunc_wrapper=True,
        # Kernels have nothing whose references are counted.
        _nrt=stock,
        # A call would pass the state of 16 paths through memory: a fifth of the time.
        forceinline=not root,
    )
    if not stock:
        dispatcher.get_call_template = partial(call_template, dispatcher)
    return dispatcher


def call_template(dispatcher: Any, arguments: Any, keywords: Any) -> tuple:
    """What a call of a kernel is, after Numba's method of this name: one kernel for all numbers.

    Numba would compile another one for each constant in a call. Inlined, they are the same machine
    code. Only where the text has to know the number (how many lanes) is one made for it.
    """
    method = type(dispatcher).get_call_template
    plain = [types.unliteral(argument) for argument in arguments]
    if keywords or plain == list(arguments):
        return method(dispatcher, arguments, keywords)
    try:
        return method(dispatcher, plain, keywords)
    except TypingError:
        return method(dispatcher, arguments, keywords)
