"""The weights of multiple importance sampling, for each strategy to find light.

The derivation is in `alight.integrators.path`.
"""

from __future__ import annotations

from lanewise.jit import kernel
from lanewise.simd import lanes, where

#: Strategies of light sampling, as numbers that kernels compare.
BY_LIGHT, MIS, BY_BSDF = 0, 1, 2
STRATEGIES = {"emitter": BY_LIGHT, "mis": MIS, "bsdf": BY_BSDF}


def weights_of(strategy, heuristic):
    """The kernels (bsdf_weight, light_weight) of a strategy: w_b and w_l, whose sum is one."""

    @kernel
    def bsdf_weight(path, light_pdf):
        """w_b: weight of light that a BSDF sample hit."""
        if strategy == MIS:
            return where(path.delta, 1.0, heuristic(path.pdf, light_pdf))
        if strategy == BY_BSDF:
            return where(path.delta, 1.0, lanes(1.0))
        return where(path.delta, 1.0, lanes(0.0))

    @kernel
    def light_weight(light, bsdf_pdf):
        """w_l: weight of light that light sampling chose."""
        if strategy == MIS:
            return where(light.delta, 1.0, heuristic(light.pdf, bsdf_pdf))
        return where(light.delta, 1.0, lanes(1.0))

    return bsdf_weight, light_weight
