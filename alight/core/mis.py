"""Multiple importance sampling: weights of a sample that two densities could have produced.

Both weights of a pair add up to 1. Neither overflows for large densities, and where both are
0 (or infinite) each gets 1/2: never NaN.

Source: Veach, Robust Monte Carlo Methods (1997), section 9.2.2 (power heuristic: exponent 2).
"""

from __future__ import annotations

from lanewise.jit import kernel
from lanewise.simd import maximum, minimum, where


@kernel(strict=True)
def _ratio(pdf_a, pdf_b):
    """The smaller density over the larger one, in [0, 1]; 1 where they are equal."""
    low, high = minimum(pdf_a, pdf_b), maximum(pdf_a, pdf_b)
    equal = low == high
    return where(equal, 1.0, low / where(equal, 1.0, high))


@kernel(strict=True)
def balance_heuristic(pdf_a, pdf_b):
    """pdf_a / (pdf_a + pdf_b): weight of a sample drawn with density pdf_a."""
    ratio = _ratio(pdf_a, pdf_b)
    return where(pdf_a >= pdf_b, 1.0, ratio) / (1.0 + ratio)


@kernel(strict=True)
def power_heuristic(pdf_a, pdf_b):
    """pdf_a^2 / (pdf_a^2 + pdf_b^2): weight of a sample drawn with density pdf_a."""
    ratio = _ratio(pdf_a, pdf_b)
    squared = ratio * ratio
    return where(pdf_a >= pdf_b, 1.0, squared) / (1.0 + squared)
