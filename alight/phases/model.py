"""What the renderer takes from the file of a phase function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from alight.core.registry import Kernel, Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class PhaseModel(Record):
    """A phase function.

    Attributes
    ----------
    parameter : (spec) -> float
        The number that its kernels are given.
    mean_cosine : (spec) -> float
        Mean of the cosine between the directions before and after.
    density : kernel ``(parameter, one_minus_cosine)``
        Per steradian.
    sample : kernel ``(parameter, u)``
        1 - cosine, from u in [0, 1).
    """

    parameter: Callable[[Any], float]
    mean_cosine: Callable[[Any], float]
    density: Kernel
    sample: Kernel


#: All phase functions, by name.
PHASES = Records("phases", PhaseModel)
