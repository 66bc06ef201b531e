"""Code that gives the same bits on every x86-64-v3 processor (`lanewise.machine.PORTABLE`).

All arithmetic of these processors is that of IEEE 754, but for their estimates of reciprocals and
of reciprocal square roots, rcpps and rsqrtps, whose bits Intel and AMD define each for itself. LLVM
takes them where fast-math lets it. Kernels call no function of the C library but memset.
"""

from __future__ import annotations

from typing import Any

from lanewise.machine import PORTABLE, PORTABLE_CPU, PTX, target

_NO_ESTIMATES = '"reciprocal-estimates"="none"'


def compile_for_target() -> None:
    """Tell Numba the processor, before it makes its code generator."""
    from numba import config

    chosen = {
        PORTABLE: {"CPU_NAME": PORTABLE_CPU, "CPU_FEATURES": ""},
        # What is optimised before it goes to `lanewise.ptx` must not know vectors of this machine.
        PTX: {"CPU_NAME": "x86-64", "CPU_FEATURES": "", "LOOP_VECTORIZE": 0, "SLP_VECTORIZE": 0},
    }
    for name, value in chosen.get(target(), {}).items():
        setattr(config, name, value)


def forbid_estimates(module: Any) -> None:
    """Keep estimates out of the functions of a module of llvmlite, if it is for all processors."""
    if target() == PORTABLE:
        for function in module.functions:
            if not function.is_declaration:
                # llvmlite's method `add` refuses attributes that it does not know.
                set.add(function.attributes, _NO_ESTIMATES)
