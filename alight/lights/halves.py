"""Kernels that go through many others, by halves: compilers cannot follow long chains."""

from __future__ import annotations

from lanewise.jit import kernel


def one_after_another(steps: list):
    """``(scene, index, p, u, u2, result)``: each of the steps with what the one before left."""
    if len(steps) == 1:
        return steps[0]
    half = len(steps) // 2
    first, second = one_after_another(steps[:half]), one_after_another(steps[half:])

    @kernel
    def both(scene, index, p, u, u2, result):
        return second(scene, index, p, u, u2, first(scene, index, p, u, u2, result))

    return both


def sum_of(parts: tuple):
    """``(scene, p, d)``: the sum of kernels ``(scene, p, d)``, at least one."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    first, others = sum_of(parts[:half]), sum_of(parts[half:])

    @kernel
    def added(scene, p, d):
        return first(scene, p, d) + others(scene, p, d)

    return added
