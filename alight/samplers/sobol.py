r"""Sobol' sampler with hashed Owen scrambling, padded: the default.

Each pair of dimensions uses the first two dimensions of the Sobol' sequence, a (0, 2)-sequence in
base 2: of the first 2^k samples, every dyadic rectangle of area 2^-k holds exactly one. Pairs are
decorrelated by a shuffle of the sample index and a scramble of their own.

Source: Sobol' (1967); Owen (1995); Burley, Practical hash-based Owen scrambling, JCGT 9(4) (2020);
PBR4 section 8.7.
"""

from __future__ import annotations

from typing import Literal

from alight.core.rng import hash_2, unit_float
from alight.core.spec import Sampler
from alight.samplers.owen import scramble_reversed, shuffle_index
from lanewise.jit import kernel
from lanewise.simd import reverse_bits


class Sobol(Sampler):
    """Owen-scrambled Sobol' sequence."""

    type: Literal["sobol"] = "sobol"


EXAMPLES = (Sobol(),)


#: Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D, at
#: powers of two (in between it is near -2).
EXPECTED_RATE = (-3.0, -3.0)

#: Largest variance of a product of Walsh functions of two dimensions, times plain Monte Carlo's.
#: Consecutive samples of a progressive sequence lie in opposite halves in *every* dimension, so
#: their products of two first digits agree: 2. Products of three cancel, and on average nothing
#: is lost.
WORST_GAIN = 2.0


def make_kernels():
    """(get_1d, get_2d) of this sampler."""
    return get_1d, get_2d


@kernel
def get_1d(state, dimension):
    """The number of `dimension`: the van der Corput sequence, shuffled and scrambled."""
    shuffle, scramble = _seeds(state, dimension)
    index = shuffle_index(state.index, shuffle)
    # The sequence is the reversed index, so the reversed word that is scrambled is the index.
    return unit_float(reverse_bits(scramble_reversed(index, scramble)))


@kernel
def get_2d(state, dimension):
    """The numbers of `dimension` and `dimension` + 1: a point of a (0, 2)-sequence."""
    shuffle, scramble = _seeds(state, dimension)
    index = shuffle_index(state.index, shuffle)
    x = scramble_reversed(index, scramble)
    y = scramble_reversed(_second_dimension(index), _third_seed(shuffle, scramble))
    return unit_float(reverse_bits(x)), unit_float(reverse_bits(y))


@kernel
def _seeds(state, dimension):
    a, b = state.a, state.b
    return hash_2(a, b, dimension)


@kernel
def _third_seed(shuffle, scramble):
    """A seed whose lower and upper halves are independent of each of the other two's."""
    return shuffle ^ (scramble >> 16 | scramble << 16)


@kernel
def _second_dimension(index):
    """Bit-reversed second Sobol' coordinate.

    Its generator matrix is Pascal's triangle modulo 2, binomial(k, j), whose 2^m block is
    [[1, 1], [0, 1]] times that of 2^(m-1): one exclusive-or step for each of the 5 levels.
    """
    index = index ^ ((index >> 1) & 0x55555555)
    index = index ^ ((index >> 2) & 0x33333333)
    index = index ^ ((index >> 4) & 0x0F0F0F0F)
    index = index ^ ((index >> 8) & 0x00FF00FF)
    return index ^ (index >> 16)
