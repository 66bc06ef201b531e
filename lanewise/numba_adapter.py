"""Undocumented parts of Numba and llvmlite that lanewise uses; others are in `numba_shortcuts`.

The rest of the package uses `numba.njit`, `types`, `typeof`, `from_dtype`, `config` and
`numba.extending`, `llvmlite.ir` and `llvmlite.binding`. The names below are internal to Numba
and may change with any minor version. Each says in one line what is assumed of it, and
`lanewise.canary` tries them one by one. So do the `METHODS` of objects that Numba and llvmlite hand
to the rest of the package.
"""

# Numba declares infer_global and others as None until it is initialised.
# pyright: reportOptionalCall=false

from __future__ import annotations

import re
from copy import copy
from dataclasses import dataclass
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba import typeof, types
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
    UnsupportedBytecodeError,  # what the first pass raises; it is no NumbaError
    UnsupportedError,  # a NumbaError of those who use Numba
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

from lanewise.machine import PTX, target
from lanewise.machine_code import ObjectCode
from lanewise.numba_methods import METHODS
from lanewise.numba_shortcuts import KernelLower, leave_scipy_alone, shortcuts
from lanewise.portable import forbid_estimates
from lanewise.remembered_answers import RememberingContext

__all__ = [
    "DIGEST", "METHODS", "AbstractTemplate", "LeanCompiler", "NullCache", "OptimisedLibrary",
    "StockCompiler", "TypingError", "as_compiled", "bare_descriptor", "cgutils", "infer_global",
    "look_in", "lower_constant", "make_struct", "object_code",
]  # fmt: skip

#: What Numba raises for a kernel that it does not compile.
NOT_COMPILED = (NumbaError, UnsupportedBytecodeError)


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
    #: Whether this is a root kernel, which is not inlined anywhere.
    is_root: bool = False

    def add_linking_library(self, library):
        """Link with a function; not with Numba's runtime, "nrt", as kernels count no references."""
        if isinstance(library, OptimisedLibrary):
            super().add_linking_library(library)
        elif library.name != "nrt":
            super().add_linking_library(InlinedLibrary(library))

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

    def _optimize_functions(self, ll_module):
        # Numba's method of this name, without a pass manager for each function that is declared.
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, options = self._codegen._function_pass_manager()
                passes.run(function, options)

    def _optimize_final_module(self):
        if self.is_root:
            super()._optimize_final_module()
            return
        # The first half of Numba's method of this name: what is called is inlined. The rest would
        # be done again for each caller, up to the root, whose code and speed do not need it.
        passes, options = self._codegen._module_pass_manager(
            loop_vectorize=self._codegen._loopvect,
            slp_vectorize=False,
            opt=self._codegen._opt_level,
            cost="cheap",
        )
        passes.run(self._final_module, options)

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
        """Machine code for this processor, or LLVM bitcode for `lanewise.ptx`."""
        self._ensure_finalized()
        if target() == PTX:
            return self._final_module.as_bitcode()
        # `_tm` is llvmlite's TargetMachine for this processor, which knows `emit_object`.
        return self._codegen._tm.emit_object(self._final_module)


@dataclass(frozen=True)
class InlinedLibrary:
    """A function of Numba's own, to be inlined into the kernels that call it.

    LLVM would inline it where that seems worth while. Its estimate depends on what else is known of
    the program at that time, and with it depended how a kernel rounds.

    Attributes
    ----------
    of : JITCodeLibrary
        The function's own.
    """

    of: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.of, name)

    def _get_module_for_linking(self) -> Any:
        module = self.of._get_module_for_linking().clone()
        for function in module.functions:
            if not function.is_declaration and b"noinline" not in b" ".join(function.attributes):
                function.add_function_attribute("alwaysinline")
        return module


@register_pass(mutates_CFG=True, analysis_only=False)
class LowerToLibrary(NativeLowering):
    """Lowering to LLVM IR, without an entry point for Python."""

    _name = "lanewise_lower_to_library"

    @property
    def lowering_class(self):
        """What lowers."""
        return KernelLower

    def run_pass(self, state):
        """Lower one function."""
        state.flags.no_compile = True  # to stop before the engine is asked for an address
        digest = getattr(state.func_id.func, DIGEST, None)
        if digest is not None:
            # The name of a function in LLVM IR ends with this, a count by default: functions of
            # several processes meet in one module, and must not share a name.
            state.func_id.unique_id = digest
        state.library = OptimisedLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.calls = tuple(state.calls)
        state.library.is_root = not state.flags.forceinline
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

    def __init__(self, *state: Any) -> None:
        leave_scipy_alone()  # before Numba loads all that it knows
        super().__init__(*state)

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


def object_code(dispatcher: Any, arguments: tuple) -> ObjectCode:
    """Compile a root kernel for arguments of these types.

    Raises
    ------
    TypeError
        If it returns something.
    """
    signature = tuple(map(typeof, arguments))
    with shortcuts():
        dispatcher.compile(signature)
    compiled = dispatcher.overloads[signature]
    described = compiled.fndesc
    if described.restype != types.none:
        raise TypeError(f"{described.qualname}: a kernel called from Python must return nothing")
    packer = compiled.target_context.get_arg_packer(described.argtypes)
    plain = [str(t) for t in packer.argument_types]
    with global_compiler_lock:
        code = compiled.library.object_code()
    outside = sorted(set(re.findall(rb"\0(numba_\w+)(?=\0)", code)))
    if outside:
        names = ", ".join(name.decode() for name in outside)
        said = f"functions of Numba are not there when a kernel runs: {names}"
        # Numba dresses messages in codes of colour wherever colorama is installed.
        raise UnsupportedError(said, highlighting=False)
    return ObjectCode(
        described.llvm_func_name,
        tuple("ptr" if t.endswith(("*", "ptr")) else t for t in plain),
        code,
    )
