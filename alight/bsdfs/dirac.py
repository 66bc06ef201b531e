"""Models of delta lobes only, whose directions only sampling can find."""

from __future__ import annotations

from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_vec3


@kernel
def evaluate(params, wo, wi):
    """(0, 0): directions that were not sampled from a delta lobe never lie in it."""
    return lanes_vec3(0.0), lanes(0.0)
