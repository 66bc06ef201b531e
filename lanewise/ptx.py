"""Kernels for the GPUs of NVIDIA: the same text with one lane a thread, as PTX for their driver.

A process compiles for one target, and LLVM ends a process in which it is given what a target cannot
do; so PTX is made by a process of its own, once, and kept like machine code.
"""

from __future__ import annotations

import importlib
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Hashable
from typing import Any, NamedTuple

import numpy as np

from lanewise.application import application
from lanewise.jit import instantiate
from lanewise.machine import PTX, choose_target
from lanewise.machine_code import MachineCode, ObjectCode, read_code, write_code
from lanewise.view import View

#: The least processor that the code runs on, Turing of 2018, and the version of PTX, whose kernels
#: take more than 4 KB of arguments.
TRIPLE, PROCESSOR, FEATURES = "nvptx64-nvidia-cuda", "sm_75", "+ptx83"

#: Threads of a block.
THREADS = 128

#: Name of the kernel in its PTX.
ENTRY = "lanewise_entry"


class LoweringError(Exception):
    """A kernel that does not become PTX, and what was said of it."""


class Asked(NamedTuple):
    """What PTX is made of.

    Attributes
    ----------
    module, name : str
        Of the root kernel, whose last argument is the number of the thread.
    program : hashable
    arguments : tuple
        Of the types of the kernel's.
    """

    module: str
    name: str
    program: Hashable
    arguments: tuple

    @property
    def kernel(self) -> MachineCode:
        """The kernel in this process, for its own target."""
        made = instantiate(getattr(importlib.import_module(self.module), self.name), self.program)
        if not isinstance(made, MachineCode):
            raise LoweringError("Numba's own pipeline makes no PTX")
        return made


def ptx_of(module: str, name: str, program: Hashable, arguments: tuple) -> ObjectCode:
    """The PTX of a root kernel for arguments of these types, kept or made.

    Returns
    -------
    ObjectCode
        Its last argument is the number of threads, in the place of the thread.

    Raises
    ------
    LoweringError
    """
    asked = Asked(module, name, program, _of_types(arguments))
    path = asked.kernel.path(arguments, PTX)
    found = read_code(path)
    if found is None:
        found = _made_elsewhere(asked)
        write_code(path, found)
    return found


def _of_types(value: Any) -> Any:
    """The same with tables of one number."""
    if isinstance(value, View):
        return View(np.zeros(1, value.dtype))
    if isinstance(value, tuple):
        parts = map(_of_types, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def _made_elsewhere(asked: Asked) -> ObjectCode:
    """What a process of its own makes."""
    begin = (
        f"import sys; sys.path[:] = {sys.path!r}; import {application().name}\n"
        f"from {__name__} import answer; answer()"
    )
    done = subprocess.run(
        [sys.executable, "-c", begin], input=pickle.dumps(asked), capture_output=True, check=False
    )
    if done.returncode == 0:
        return pickle.loads(done.stdout)
    said = done.stderr.decode(errors="replace").strip().splitlines() or ["it said nothing"]
    raise LoweringError(next((line for line in said if "LLVM ERROR" in line), said[-1]))


def answer() -> None:
    """Make what is asked for on standard input, in a process that has compiled nothing yet."""
    # What imports print must not mix with the answer.
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        choose_target(PTX)
        asked: Asked = pickle.load(sys.stdin.buffer)
        compile_for = asked.kernel.compile_for
        assert compile_for is not None
        answers.write(pickle.dumps(lowered(compile_for(asked.arguments))))


# ---------------------------------------------------------------- LLVM


def lowered(code: ObjectCode) -> ObjectCode:
    """PTX of a root kernel that was compiled to bitcode."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(TRIPLE).create_target_machine(
        cpu=PROCESSOR, features=FEATURES, opt=3
    )
    text = str(llvm.parse_bitcode(code.code))
    # What it says of the processor of this machine.
    text = re.sub(r"^target .*$", "", text, flags=re.MULTILINE)
    text = re.sub(r'"(target-cpu|target-features|tune-cpu)"="[^"]*"', "", text)
    module = llvm.parse_assembly(
        f'target datalayout = "{machine.target_data}"\ntarget triple = "{TRIPLE}"\n'
        + text
        + _entry(code)
    )
    module.verify()
    # Nobody else calls its functions, or looks at what Numba notes of them.
    for symbol in (*module.functions, *module.global_variables):
        if not symbol.is_declaration and symbol.name != ENTRY:
            symbol.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    passes = llvm.create_pass_builder(machine, options)
    passes.getModulePassManager().run(module, passes)
    return ObjectCode(ENTRY, code.arguments, machine.emit_assembly(module).encode())


def _entry(code: ObjectCode) -> str:
    """The kernel as the driver starts it: each thread below ``count`` is given its number."""
    taken = [f"{kind} %a{i}" for i, kind in enumerate(code.arguments[:-1])]
    given = ", ".join(["ptr %unused", "ptr %unused", *taken, "i64 %thread"])
    return f"""
declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()

define ptx_kernel void @{ENTRY}({", ".join([*taken, "i64 %count"])}) "nvvm.maxntid"="{THREADS}" {{
  %unused = alloca [2 x i64]
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %within = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %first = mul i32 %block, {THREADS}
  %number = add i32 %first, %within
  %thread = zext i32 %number to i64
  %wanted = icmp ult i64 %thread, %count
  br i1 %wanted, label %run, label %end
run:
  %status = call i32 @"{code.symbol}"({given}) alwaysinline
  br label %end
end:
  ret void
}}
"""
