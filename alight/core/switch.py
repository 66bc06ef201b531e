"""Choice among models, lane by lane, in packets whose lanes need different ones.

Each model runs only if one of the lanes needs it, over all lanes, and is then blended in.
"""

from __future__ import annotations

from collections.abc import Iterable

from alight.core.registry import Kernel
from lanewise.jit import kernel
from lanewise.simd import any_lane, lanes_mask, where


def switch(cases: Iterable[tuple[int, Kernel]]) -> Kernel:
    """Write a kernel that asks the model of each lane.

    Parameters
    ----------
    cases : iterable of (int, kernel)
        Number of a model, and a kernel ``(scene, surface, kind, query, active, value) -> value``:
        what it makes of a value in its lanes. What it answers in the others is not used.

    Returns
    -------
    kernel ``(scene, surface, kind, query, active, value) -> value``
        The value, a number, a `Vec3` or a record, stays as it is in lanes that are not active or
        whose kind is none of the numbers.
    """
    cases = list(cases)
    if not cases:
        return _keep
    (number, answer), rest = cases[0], switch(cases[1:])

    @kernel
    def step(scene, surface, kind, query, active, value):
        mine = active & (kind == number)
        if any_lane(mine):
            value = where(mine, answer(scene, surface, kind, query, mine, value), value)
        return rest(scene, surface, kind, query, active, value)

    return step


@kernel
def _keep(scene, surface, kind, query, active, value):
    return value


def is_one_of(numbers: Iterable[int]) -> Kernel:
    """Write a kernel ``(kind) -> mask``: the kind is one of the numbers."""
    numbers = list(numbers)
    if not numbers:
        return _never
    number, rest = numbers[0], is_one_of(numbers[1:])

    @kernel
    def is_one(kind):
        return (kind == number) | rest(kind)

    return is_one


@kernel
def _never(kind):
    return lanes_mask(False)
