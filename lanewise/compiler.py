"""How kernel text becomes machine code: Numba, with our primitives in the places of their twins.

Only `lanewise.jit.load_compiler` imports this module, at the first compilation.
"""

from __future__ import annotations

from typing import Any

from lanewise import (
    memory_instructions,
    record_instructions,
    scalar_instructions,
    simd,
    wide_instructions,
)
from lanewise.dispatchers import jit
from lanewise.instructions import PRIMITIVES
from lanewise.kept_functions import digest_on_disk, keep_on_disk
from lanewise.lane_types import N
from lanewise.numba_adapter import object_code
from lanewise.portable import compile_for_target

__all__ = ["digest_on_disk", "jit", "keep_on_disk", "object_code", "primitive"]

compile_for_target()

# They fill PRIMITIVES.
assert memory_instructions and record_instructions and scalar_instructions and wide_instructions


def primitive(value: Any) -> Any:
    """The compiled stand-in for a primitive or constant of `simd`; other values as they are."""
    if isinstance(value, simd.LaneCount):
        return N
    try:
        return PRIMITIVES.get(value, value)
    except TypeError:  # not hashable, so not one of ours
        return value
