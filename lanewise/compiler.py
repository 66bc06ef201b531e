"""How kernel text becomes machine code: Numba with float32 constants and our primitives.

Only `lanewise.jit.load_compiler` imports this module, at the first compilation.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numba import njit, types
from numba.core import ir as numba_ir
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass
from numba.core.errors import TypingError
from numba.core.typed_passes import (
    NativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.typing.typeof import typeof
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FixupArgs,
    IRProcessing,
    ReconstructSSA,
    TranslateByteCode,
)

from lanewise import simd
from lanewise.lane_types import N
from lanewise.machine_code import ObjectCode
from lanewise.wide_instructions import PRIMITIVES


@register_pass(mutates_CFG=False, analysis_only=False)
class Float32Constants(FunctionPass):
    """Make Python floats in kernel text float32, so that no product becomes a double."""

    _name = "lanewise_float32_constants"

    def __init__(self):
        super().__init__()

    def run_pass(self, state):  # pyright: ignore[reportIncompatibleMethodOverride]
        """Replace the constants of one function."""
        for block in state.func_ir.blocks.values():
            for statement in block.body:
                value = getattr(statement, "value", None)
                constant = isinstance(value, (numba_ir.Const, numba_ir.Global, numba_ir.FreeVar))
                if constant and type(value.value) is float:
                    value.value = np.float32(value.value)
        return True


class OptimisedLibrary(JITCodeLibrary):
    """Optimised LLVM IR, to link with or to make an object file of.

    It is kept out of Numba's own engine. Were it in there, a kernel's calls could go to this copy
    of a function in place of the one in the kernel's own module, which is optimised together with
    its callers, and the same program could round differently from one process to the next.
    """

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def object_code(self) -> bytes:
        """Machine code for this processor."""
        self._ensure_finalized()
        return self._codegen._tm.emit_object(self._final_module)


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerToLibrary(NativeLowering):
    """Lowering to LLVM IR, without an entry point for Python."""

    _name = "lanewise_lower_to_library"

    def run_pass(self, state):
        """Lower one function."""
        state.flags.no_compile = True
        state.library = OptimisedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        # The dispatcher insists on an entry point of its own, a built-in callable, to tell its
        # functions apart; nothing ever calls this one. Methods of two lists are never equal.
        entry = [].append
        lowered = state["cr"]
        state.targetctx.insert_user_function(entry, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=entry)
        return True


class _Remembering:
    """Numba's typing context, which gives at once the answers that it has given before.

    To find out what ``a + b`` is, Numba asks everything that is known of +, ours last, and writes
    a message for each that does not fit: an eighth of the time of a compilation.
    """

    def __init__(self, context: Any) -> None:
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, keywords: Any) -> Any:
        """The signature of a call; not of kernels and methods, which are asked once each."""
        if keywords or not isinstance(function, types.Function):
            return self._context.resolve_function_type(function, arguments, keywords)
        question = function, tuple(arguments)
        if question not in _ANSWERS:
            answer = self._context.resolve_function_type(function, arguments, keywords)
            if answer is None:
                return None
            _ANSWERS[question] = answer
        return _ANSWERS[question]


_ANSWERS: dict[tuple, Any] = {}


@register_pass(mutates_CFG=True, analysis_only=False)
class KernelTypeInference(NopythonTypeInference):
    """Type inference that asks each question once."""

    _name = "lanewise_type_inference"

    def run_pass(self, state):
        """Infer the types of one function."""
        context, state.typingctx = state.typingctx, _Remembering(state.typingctx)
        try:
            return super().run_pass(state)
        finally:
            state.typingctx = context


class KernelCompiler(CompilerBase):
    """Numba's nopython pipeline reduced to the passes that kernel text needs.

    Compile time is a user's time, and nearly all of it is Numba's own. Left out are passes for
    closures, generators, list comprehensions, parallel loops and typed-IR rewrites, none of which
    kernels have, and the annotation of types for display.
    """

    def define_pipelines(self):
        """The passes in order."""
        pipeline = PassManager("lanewise")
        for step in (
            TranslateByteCode,
            FixupArgs,
            IRProcessing,
            Float32Constants,
            DeadBranchPrune,
            ReconstructSSA,
            KernelTypeInference,
            PreLowerStripPhis,
            LowerToLibrary,
            NoPythonBackend,
        ):
            pipeline.add_pass(step, step._name)
        pipeline.finalize()
        return [pipeline]


def jit(function, *, fast_math, root):
    """A Numba dispatcher; of root kernels `object_code` makes something that can be called."""
    dispatcher = njit(  # pyright: ignore[reportCallIssue]
        function,
        nogil=True,
        fastmath=fast_math,
        error_model="numpy",
        pipeline_class=KernelCompiler,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        # A call would pass the state of 16 paths through memory: a fifth of the time.
        forceinline=not root,
    )
    dispatcher.get_call_template = partial(_call_template, dispatcher)
    return dispatcher


def _call_template(dispatcher: Any, arguments: Any, keywords: Any) -> tuple:
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


def object_code(dispatcher: Any, arguments: tuple) -> ObjectCode:
    """Compile a root kernel for arguments of these types.

    Raises
    ------
    TypeError
        If it returns something.
    """
    signature = tuple(map(typeof, arguments))
    dispatcher.compile(signature)
    compiled = dispatcher.overloads[signature]
    described = compiled.fndesc
    if described.restype != types.none:
        raise TypeError(f"{described.qualname}: a kernel called from Python must return nothing")
    packer = compiled.target_context.get_arg_packer(described.argtypes)
    plain = [str(t) for t in packer.argument_types]
    with global_compiler_lock:
        code = compiled.library.object_code()
    return ObjectCode(
        described.llvm_func_name,
        tuple("ptr" if t.endswith(("*", "ptr")) else t for t in plain),
        code,
    )


def primitive(value):
    """The compiled stand-in for a primitive or constant of `simd`; other values as they are."""
    if isinstance(value, simd.LaneCount):
        return N
    try:
        return PRIMITIVES.get(value, value)
    except TypeError:  # not hashable, so not one of ours
        return value
