"""What the compiler made of the hot kernel: float32 only, no reference counting."""

from __future__ import annotations

import re

import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.rendering.job import Job
from alight.rendering.schedules.schedule import Uniform
from alight.scene import flatten
from lanewise import machine_code as machine_code_module
from lanewise.jit import load_compiler


@pytest.fixture(scope="module")
def machine_code():
    """LLVM IR of the main loop for the Cornell box with mirror and glass, after optimisation."""
    compiler, seen = load_compiler(), {}
    compile_ = compiler.object_code

    def look(dispatcher, arguments):
        result = compile_(dispatcher, arguments)
        (compiled,) = dispatcher.overloads.values()
        seen[dispatcher.py_func.__name__] = compiled.library.get_llvm_str()
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiler, "object_code", look)
        # Made in any case; of the functions inside, those that are on disk are not made again.
        patch.setattr(machine_code_module, "read_code", lambda path: None)
        flat = flatten(alight.load("mirror-and-glass"))
        job = Job(compile_scene(flat), Uniform(0, 1), seed=0, threads=1, replicates=4)
        job.start(None)
    return seen["render_samples"]


def test_no_double_arithmetic(machine_code):
    found = re.findall(
        r"= (?:fadd|fsub|fmul|fdiv|fcmp|fpext|sitofp|uitofp)[^\n]*\bdouble\b[^\n]*", machine_code
    )
    assert not found, "\n".join(found[:5])


def test_no_reference_counting(machine_code):
    body = machine_code
    hot = [
        part
        for part in re.split(r"(?=^define )", body, flags=re.MULTILINE)
        if part.startswith("define")
        and "render_samples" in part.split("\n")[0]
        and "cpython" not in part.split("\n")[0]
    ]
    assert hot
    assert not any("NRT_incref" in part or "NRT_decref" in part for part in hot)


def test_the_kernel_works_on_whole_packets(machine_code):
    from lanewise.machine import lanes_of_machine

    assert f"<{lanes_of_machine()} x float>" in machine_code
