"""All that lanewise takes from Numba and llvmlite beyond what they document, in one place.

The rest of the package uses `numba.types`, `typeof`, `from_dtype`, `config` and `numba.extending`,
`llvmlite.ir` and `llvmlite.binding`. The names below are Numba's own affair and may change with any minor version.
Each says in one line what is assumed of it, and `lanewise.canary` tries them one by one. So do the
`METHODS` of objects that Numba and llvmlite hand to the rest of the package.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

from copy import copy
from functools import partial
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba import njit, typeof, types
from numba.core import cgutils  # struct proxies, `alloca_once`, `get_or_insert_function`
from numba.core import ir as numba_ir  # Const, Global and FreeVar hold `value`, which may be set
from numba.core.caching import NullCache  # a dispatcher's `_cache`, which is asked first
from numba.core.codegen import JITCodeLibrary  # optimises `_final_module`, then finalises it
from numba.core.compiler import (
    CompilerBase,  # runs the pass managers that `define_pipelines` returns
    DefaultPassBuilder,  # `define_nopython_pipeline(state)` is what njit does
    compile_result,  # what a dispatcher keeps of a function
)
from numba.core.compiler_lock import global_compiler_lock  # is held while LLVM works
from numba.core.compiler_machinery import (
    FunctionPass,  # one step over a function: `run_pass(state)`
    PassManager,  # steps in order: `add_pass`, `add_pass_after`, `finalize`
    register_pass,  # no step runs without it
)
from numba.core.errors import (
    NumbaError,  # whatever keeps a kernel from being compiled
    TypingError,  # what a call template raises where no type fits
)
from numba.core.imputils import lower_constant  # how a global of our type becomes LLVM IR
from numba.core.typed_passes import (
    NativeLowering,  # lowers into `state.library` and leaves a result in ``state["cr"]``
    NoPythonBackend,  # turns ``state["cr"]`` into what the dispatcher keeps
    NopythonTypeInference,  # asks `state.typingctx` for the type of every call
    PreLowerStripPhis,  # lowering knows no phi nodes
)
from numba.core.typing.templates import (
    AbstractTemplate,  # `generic` gives the signature of an operator
    infer_global,  # adds a template to an operator of Python
    signature,  # result and arguments of a function
)
from numba.core.untyped_passes import (
    DeadBranchPrune,  # after `Float32Constants` and before SSA, as in Numba's own order
    FixupArgs,  # needs nothing but byte code
    IRProcessing,  # the first step after which constants can be found
    ReconstructSSA,  # type inference wants it
    TranslateByteCode,  # the first step
)

from lanewise.machine_code import ObjectCode
from lanewise.portable import forbid_estimates

__all__ = [
    "DIGEST", "AbstractTemplate", "NullCache", "OptimisedLibrary", "TypingError", "as_compiled",
    "bare_descriptor", "cgutils", "infer_global", "jit", "look_in", "lower_constant",
    "make_struct", "object_code",
]  # fmt: skip

#: What Numba raises for a kernel that it does not compile.
NOT_COMPILED = NumbaError


#: (class, method or attribute) that other files use -> what is assumed of it. The code generators
#: are given a `BaseContext` as `context`, and unboxing a `PythonAPI` as `c.pyapi`.
METHODS = {
    ("numba.core.base.BaseContext", "cast"): "converts a value to another type",
    ("numba.core.base.BaseContext", "get_constant"): "a Python number as a constant",
    ("numba.core.base.BaseContext", "get_data_type"): "how a type is laid out in memory",
    ("numba.core.base.BaseContext", "get_dummy_value"): "what a call that returns None gives",
    ("numba.core.base.BaseContext", "get_value_as_data"): "a value as it is laid out in memory",
    ("numba.core.base.BaseContext", "get_value_type"): "the LLVM type of values of a type",
    ("numba.core.base.BaseContext", "make_tuple"): "a tuple of values",
    ("numba.core.pythonapi.PythonAPI", "decref"): "gives a reference back",
    ("numba.core.pythonapi.PythonAPI", "err_occurred"): "not null if Python has raised",
    ("numba.core.pythonapi.PythonAPI", "float_as_double"): "the double in a Python float",
    ("numba.core.pythonapi.PythonAPI", "number_float"): "a number as a Python float",
    ("numba.core.pythonapi.PythonAPI", "object_getattr_string"): "an attribute by its name",
    ("llvmlite.ir.Type", "as_pointer"): "pointers know the type that they point to",
    ("llvmlite.ir.PointerType", "pointee"): "the type that a pointer points to",
}


def make_struct(context: Any, builder: Any, kind: types.Type, **fields: Any) -> Any:
    """A value of a type with a `StructModel`, from its fields; Numba keeps them by name."""
    struct = cgutils.create_struct_proxy(kind)(context, builder)
    for name, value in fields.items():
        setattr(struct, name, value)
    return struct._getvalue()


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

    #: What was lowered for the function itself, as bitcode; None if that was several modules.
    alone: bytes | None = b""
    #: What type inference asked about other kernels, with the answers.
    calls: tuple = ()

    def add_linking_library(self, library):
        """Link with a function; not with Numba's runtime, "nrt", as kernels count no references."""
        if library.name != "nrt" or isinstance(library, OptimisedLibrary):
            super().add_linking_library(library)

    def add_ir_module(self, ir_module):
        """Take in what is being lowered."""
        forbid_estimates(ir_module)
        super().add_ir_module(ir_module)

    def add_llvm_module(self, ll_module):
        """Take in what was lowered."""
        self._optimize_functions(ll_module)
        bitcode = ll_module.as_bitcode()
        self.alone = bitcode if self.alone == b"" else None
        # Through bitcode, as one that is linked anew (`lanewise.unlinked`).
        self.take_in(llvm.parse_bitcode(bitcode))

    def take_in(self, module: Any) -> None:
        """Take in a module whose functions have been optimised one by one."""
        self._final_module.link_in(module)

    @property
    def linked(self) -> list[Any]:
        """The libraries that it is linked with, each once."""
        return list(dict.fromkeys(self._linking_libraries))

    def _finalize_final_module(self):
        # Numba's method of this name, without its last steps: the engine and its object cache.
        # Callers get what `load` would give them, so that they become the same code in a process
        # that compiles all of it and in one that finds a part on disk.
        self._final_module = llvm.parse_bitcode(self._final_module.as_bitcode())
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def bitcode(self) -> bytes:
        """The optimised module, as `load` reads it."""
        self._ensure_finalized()
        return self._final_module.as_bitcode()

    def load(self, bitcode: bytes) -> None:
        """Be the library that gave this `bitcode`."""
        self._final_module = llvm.parse_bitcode(bitcode)
        self._finalize_dynamic_globals()
        self._finalized = True

    def object_code(self) -> bytes:
        """Machine code for this processor."""
        self._ensure_finalized()
        # `_tm` is llvmlite's TargetMachine for this processor, which knows `emit_object`.
        return self._codegen._tm.emit_object(self._final_module)


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerToLibrary(NativeLowering):
    """Lowering to LLVM IR, without an entry point for Python."""

    _name = "lanewise_lower_to_library"

    def run_pass(self, state):
        """Lower one function."""
        state.flags.no_compile = True  # to stop before the engine is asked for an address
        digest = getattr(state.func_id.func, DIGEST, None)
        if digest is not None:
            # The name of a function in LLVM IR ends with this, a count if nothing else is said:
            # functions of several processes meet in one module, and must not share a name.
            state.func_id.unique_id = digest
        state.library = OptimisedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.calls = tuple(state.calls)
        super().run_pass(state)
        entry = unused_entry()
        lowered = state["cr"]
        state.targetctx.insert_user_function(entry, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=entry)
        return True


def unused_entry() -> Any:
    """An entry point for a dispatcher, which tells its functions apart by it; nothing calls it.

    It must be a built-in callable. Methods of two lists are never equal.
    """
    return [].append


#: Attribute of a kernel's function: the digest of its text, if there is one.
DIGEST = "__lanewise_digest__"


def as_compiled(descriptor: Any, library: OptimisedLibrary, target_context: Any) -> Any:
    """What Numba would have made: a function that is described, and the library that has it."""
    return compile_result(
        typing_context=target_context.typing_context,
        target_context=target_context,
        entry_point=unused_entry(),
        library=library,
        signature=signature(descriptor.restype, *descriptor.argtypes),
        objectmode=False,
        lifted=(),
        fndesc=descriptor,
        reload_init=[],
    )


def bare_descriptor(compiled: Any) -> Any:
    """Names and types of a compiled function, without what only its lowering needs."""
    descriptor = copy(compiled.fndesc)
    descriptor.typemap = descriptor.calltypes = None
    return descriptor


def look_in(dispatcher: Any, cache: NullCache) -> None:
    """Let a dispatcher ask `cache` before it compiles, and tell it what it has compiled."""
    dispatcher._cache = cache


class RememberingContext:
    """Numba's typing context, which gives at once the answers that it has given before.

    To find out what ``a + b`` is, Numba asks everything that is known of +, ours last, and writes
    a message for each that does not fit: an eighth of the time of a compilation.
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        #: ((dispatcher, arguments, keywords), signature) of each call of a kernel.
        self.calls: list[tuple] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, arguments: Any, keywords: Any) -> Any:
        """The signature of a call; not of kernels and methods, which are asked once each."""
        if keywords or not isinstance(function, types.Function):
            answer = self._context.resolve_function_type(function, arguments, keywords)
            if isinstance(function, types.Dispatcher):
                asked = function.dispatcher, tuple(arguments), dict(keywords)
                if (asked, answer) not in self.calls:
                    self.calls.append((asked, answer))
            return answer
        question = function, tuple(arguments)
        if question not in ANSWERS:
            answer = self._context.resolve_function_type(function, arguments, keywords)
            if answer is None:
                return None
            ANSWERS[question] = answer
        return ANSWERS[question]


#: Function and types of arguments -> the signature of the call.
ANSWERS: dict[tuple, Any] = {}


@register_pass(mutates_CFG=True, analysis_only=False)
class KernelTypeInference(NopythonTypeInference):
    """Type inference that asks each question once."""

    _name = "lanewise_type_inference"

    def run_pass(self, state):
        """Infer the types of one function."""
        context, state.typingctx = state.typingctx, RememberingContext(state.typingctx)
        try:
            return super().run_pass(state)
        finally:
            state.calls, state.typingctx = state.typingctx.calls, context


class LeanCompiler(CompilerBase):
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


class StockCompiler(CompilerBase):
    """Numba's nopython pipeline as it is, but for the constants, which are part of the text."""

    def define_pipelines(self):
        """The passes in order."""
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        pipeline.add_pass_after(Float32Constants, IRProcessing)
        pipeline.finalize()
        return [pipeline]


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
