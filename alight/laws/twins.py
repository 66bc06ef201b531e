"""Machine code against its NumPy twin, on the same input."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from alight.compiled.program import Program
from alight.laws.report import demand, demand_close
from alight.laws.statistics import ROUNDING
from lanewise.jit import instantiate
from lanewise.view import View

#: A number as large as the compiler's rounding may make it: 16 units of 2^-24 more.
LARGER = np.float32(1.0 + 2.0**-20)


def demand_same_by_machine(
    text: Callable, program: Program, scene: Any, inputs: np.ndarray, rows: int
) -> None:
    """Compare what machine code and the twin write for the same input.

    They round in another order. So they may differ as much as the twin does where its input is
    rounded otherwise, as at an edge, and by the rounding of their largest result.

    Parameters
    ----------
    text : kernel ``(scene, inputs, out, n)``
        Writes `rows` results of n numbers.
    program : Program
    scene : namedtuple
    inputs : (k, n) float32

    Raises
    ------
    BrokenLawError
        If they differ by more, or a number is not finite.
    """
    machine = _results(text, program, scene, inputs, rows, compiled=True)
    twin = _results(text, program, scene, inputs, rows, compiled=False)
    demand(np.isfinite(machine), "a number of the compiled kernel is not finite")
    beside = []
    for first in (LARGER, 1 / LARGER):
        for others in (LARGER, 1 / LARGER):
            factors = np.full((len(inputs), 1), others, np.float32)
            factors[0] = first
            beside.append(_results(text, program, scene, inputs * factors, rows, compiled=False))
    atol = np.abs(np.array(beside) - twin).max(axis=0)
    atol = atol + ROUNDING * np.abs(twin).max(axis=1, keepdims=True)
    demand_close(machine, twin, "compiled against Python", atol=atol)


def _results(
    text: Callable, program: Program, scene: Any, inputs: np.ndarray, rows: int, compiled: bool
) -> np.ndarray:
    n = inputs.shape[1]
    out = View(np.full((rows, n), np.nan, np.float32))
    with np.errstate(all="ignore"):
        # The widest packets of which n numbers are whole ones.
        run = instantiate(text, program, compiled=compiled, lanes=n & -n)
        run(scene, View(np.ascontiguousarray(inputs, np.float32)), out, n)
    return out.shaped.astype(float)
