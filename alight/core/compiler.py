"""How kernel text becomes machine code: Numba with float32 constants and our primitives.

Only `alight.core.jit.load_compiler` imports this module, at the first compilation.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numba.core import ir as numba_ir
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.untyped_passes import IRProcessing

from alight.core import simd
from alight.core.lane_types import N
from alight.core.wide_instructions import PRIMITIVES


@register_pass(mutates_CFG=False, analysis_only=False)
class Float32Constants(FunctionPass):
    """Make Python floats in kernel text float32, so that no product becomes a double."""

    _name = "alight_float32_constants"

    def __init__(self):
        super().__init__()

    def run_pass(self, state):
        for block in state.func_ir.blocks.values():
            for statement in block.body:
                value = getattr(statement, "value", None)
                constant = isinstance(
                    value, (numba_ir.Const, numba_ir.Global, numba_ir.FreeVar)
                )
                if constant and type(value.value) is float:
                    value.value = np.float32(value.value)
        return True


class KernelCompiler(CompilerBase):
    """Numba's nopython pipeline with float32 constants."""

    def define_pipelines(self):
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        pipeline.add_pass_after(Float32Constants, IRProcessing)
        pipeline.finalize()
        return [pipeline]


def jit(function, *, fast_math, root):
    """A Numba dispatcher; only root kernels are callable from Python and cached on disk."""
    return njit(
        function,
        nogil=True,
        fastmath=fast_math,
        error_model="numpy",
        pipeline_class=KernelCompiler,
        cache=root,
        no_cpython_wrapper=not root,
        no_cfunc_wrapper=True,
    )


def primitive(value):
    """The compiled stand-in for a primitive or constant of `simd`; other values as they are."""
    if isinstance(value, simd.LaneCount):
        return N
    try:
        return PRIMITIVES.get(value, value)
    except TypeError:  # not hashable, so not one of ours
        return value
