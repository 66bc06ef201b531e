r"""Independent sampler: every number is drawn independently of the others.

The error of a mean of N samples falls as N^{-1/2}, whatever the integrand: the baseline.

Source: PBR4 section 8.3.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.core.rng import hash_1, hash_2, sample_keys, unit_float
from alight.core.spec import Sampler
from lanewise.jit import kernel


class Independent(Sampler):
    """Plain Monte Carlo."""

    independent: ClassVar[bool] = True
    type: Literal["independent"] = "independent"


EXAMPLES = (Independent(),)

#: Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D.
EXPECTED_RATE = (-1.0, -1.0)


def make_kernels():
    """(get_1d, get_2d) of this sampler."""
    return get_1d, get_2d


@kernel
def get_1d(state, dimension):
    """The number of `dimension`."""
    a, b = _keys(state)
    return unit_float(hash_1(a, b, dimension))


@kernel
def get_2d(state, dimension):
    """The numbers of `dimension` and `dimension` + 1."""
    a, b = _keys(state)
    first, second = hash_2(a, b, dimension)
    return unit_float(first), unit_float(second)


@kernel
def _keys(state):
    a, b = state.a, state.b
    return sample_keys(a, b, state.index)
