r"""Halton sampler: the radical inverse of the sample index in one prime base per dimension.

.. math:: \Phi_b\Bigl(\sum_k d_k b^k\Bigr) = \sum_k d_k b^{-k-1}

Digits are permuted at random, which removes the correlation of neighbouring large bases and makes
the estimate unbiased. Large bases need many samples before they are even, so only the first 40
dimensions (the camera's and those of two vertices of the path) have a base of their own; later
ones are padded with pairs of the scrambled Sobol' sequence.

Source: Halton (1960); PBR4 section 8.6.
"""

from __future__ import annotations

from typing import Literal

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.rng import M3, hash_1, mix
from alight.core.spec import Sampler
from alight.samplers.sobol import get_1d as padded_number
from alight.samplers.sobol import get_2d as padded_pair
from lanewise.jit import kernel
from lanewise.simd import any_lane, lanes, lanes_u32, minimum, to_float, to_uint, where


class Halton(Sampler):
    """Scrambled Halton sequence."""

    type: Literal["halton"] = "halton"


EXAMPLES = (Halton(),)


#: Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D, at
#: any number of samples (steeper at powers of the base, which differ between the dimensions).
EXPECTED_RATE = (-2.0, -2.0)

#: Largest variance of a product of Walsh functions of two dimensions, times plain Monte Carlo's.
#: Consecutive samples of a progressive sequence lie in opposite halves in *every* dimension, so
#: their products of two first digits agree: 2. Products of three cancel, and on average nothing
#: is lost.
WORST_GAIN = 2.0

#: Bases of the first dimensions: the camera's and those of two vertices of the path.
PRIMES = (
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71,
    73, 79, 83, 89, 97, 101, 103, 107, 109, 113, 127, 131, 137, 139, 149, 151, 157, 163, 167, 173,
)  # fmt: skip

# Digits below this have no place in a float32 in [0, 1).
_FINEST = 2.0**-24


def make_kernels():
    """(get_1d, get_2d) of this sampler."""
    return get_1d, get_2d


@kernel
def get_1d(state, dimension):
    """The number of `dimension`."""
    base = _base(state, dimension)
    padded = base == 0
    value = _radical_inverse(state, dimension, where(padded, 2, base))
    if any_lane(padded):
        value = where(padded, padded_number(state, dimension), value)
    return value


@kernel
def get_2d(state, dimension):
    """The numbers of `dimension` and `dimension` + 1."""
    base_x, base_y = _base(state, dimension), _base(state, dimension + 1)
    padded = base_y == 0
    x = _radical_inverse(state, dimension, where(padded, 2, base_x))
    y = _radical_inverse(state, dimension + 1, where(padded, 2, base_y))
    if any_lane(padded):
        x_padded, y_padded = padded_pair(state, dimension)
        x, y = where(padded, x_padded, x), where(padded, y_padded, y)
    return x, y


@kernel
def _base(state, dimension):
    """Prime of a dimension, as lanes; 0 beyond the table."""
    base = state.index & 0
    for k in range(len(PRIMES)):
        base = where(lanes_u32(dimension) == k, PRIMES[k], base)
    return base


@kernel
def _radical_inverse(state, dimension, base):
    """Scrambled radical inverse of the index in a prime base (u32 lanes)."""
    a, b = state.a, state.b
    key = hash_1(a, b, dimension)
    b_float = to_float(base)
    inverse = 1.0 / b_float
    rest, prefix, scale, value = state.index, lanes_u32(1), lanes(1.0), lanes(0.0)
    more = scale > _FINEST
    while any_lane(more):
        higher = _divide(rest, base, inverse)
        digit = rest - higher * base
        # Owen's scrambling: the digits that follow each prefix are permuted on their own. The maps
        # d -> m d + c (mod b), m in [1, b), c in [0, b), send any two digits to any two different
        # ones alike, which is all that the variance of scrambled points depends on.
        h = mix(key ^ prefix * M3)
        m = 1 + ((h >> 16) * (base - 1) >> 16)
        moved = m * digit + ((h & 0xFFFF) * base >> 16)
        moved -= to_uint((to_float(moved) + 0.5) * inverse) * base
        scale = where(more, scale * inverse, scale)
        value = where(more, value + to_float(moved) * scale, value)
        prefix = prefix * base + digit
        rest = higher
        more = scale > _FINEST
    return minimum(value, ONE_MINUS_EPSILON)


@kernel
def _divide(n, d, inverse):
    """n // d in u32 lanes, for d < 256 and inverse = 1 / d.

    The float32 quotient is off by at most 768 / d + 3 (three roundings of n < 2^32, truncation).
    The remainder that it leaves, moved up by 1024 d to be positive, is below 2^19, where the half
    makes truncation exact.
    """
    quotient = to_uint(to_float(n >> 1) * inverse) * 2
    rest = n - quotient * d + 1024 * d
    return quotient + to_uint((to_float(rest) + 0.5) * inverse) - 1024
