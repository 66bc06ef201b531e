r"""Correlated multi-jittered sampler: n x n strata and n^2 rows and columns at once.

Each block of n^2 samples has one sample in each cell of the n x n grid, and one in each of the n^2
rows and columns, so 1-D projections are as even as the 2-D pattern.

Source: Kensler, Correlated multi-jittered sampling, Pixar technical memo 13-01 (2013).
"""

from __future__ import annotations

import math
from typing import Literal, Self

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.field_types import Strata
from alight.core.rng import hash_2, mix, sample_keys, unit_float
from alight.core.spec import Sampler
from alight.samplers import stratified
from alight.samplers.permutation import make_permute
from alight.samplers.stratified import block_and_keys
from lanewise.jit import kernel
from lanewise.simd import minimum, to_float


class Multijittered(Sampler):
    """Jittered grid with even projections.

    Parameters
    ----------
    strata : int in [1, 1024], default 4
        Cells n along each axis; a block holds n * n samples.
    """

    type: Literal["multijittered"] = "multijittered"
    strata: Strata = 4

    @property
    def block(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Samples that are one whole."""
        return self.strata**2

    def with_block(self, samples: int) -> Self:
        """Strata for blocks of at most so many samples."""
        return self.replaced(strata=max(1, math.isqrt(samples)))


EXAMPLES = (Multijittered(), Multijittered(strata=1), Multijittered(strata=7))


#: Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D, while
#: the strata of one block grow with it. Further blocks of the same size only average: slope -1.
#: All n columns share the order of rows, so the errors of a row's n samples add up: what is left
#: is a sum over n random rows, (1 / n^2)^2 * n = N^-1.5. With few samples the evenness of both
#: projections wins: the error is below that of `stratified` up to thousands of samples.
EXPECTED_RATE = (-3.0, -1.5)

#: As for `sobol`; blocks of n = 16 samples are permuted: n / (n - 1).
WORST_GAIN = 16 / 15


def make_kernels(strata):
    """(get_1d, get_2d) of this sampler for blocks of strata * strata samples."""
    cells = strata * strata
    permute, permute_line = make_permute(cells), make_permute(strata)
    width = 1.0 / strata

    @kernel
    def get_2d(state, dimension):
        block, a, b = block_and_keys(state, cells)
        order, lines = hash_2(a, b, dimension)
        cell = permute(state.index - block * cells, order)
        row = cell // strata
        column = cell - row * strata
        # Each column puts its samples into its n sub-columns in one and the same order of rows,
        # and rows likewise: all n^2 sub-columns and sub-rows are hit once.
        sub_column = permute_line(row, lines)
        sub_row = permute_line(column, mix(lines))
        a, b = sample_keys(a, b, state.index)
        first, second = hash_2(a, b, dimension)
        x = (to_float(column) + (to_float(sub_column) + unit_float(first)) * width) * width
        y = (to_float(row) + (to_float(sub_row) + unit_float(second)) * width) * width
        return minimum(x, ONE_MINUS_EPSILON), minimum(y, ONE_MINUS_EPSILON)

    # A single number has no second axis: the n^2 strata of the interval, as in `stratified`.
    return stratified.make_kernels(strata)[0], get_2d
