r"""Stratified sampler: one jittered sample in each cell of an n x n grid.

Samples come in blocks of n^2. Within a block, each pair of dimensions visits the n x n cells once,
in a random permutation of its own; a new block follows when it is used up, so any number of
samples is allowed and none is rounded.

Source: Cook, Stochastic sampling in computer graphics (1986); PBR4 section 8.5.
"""

from __future__ import annotations

import math
from typing import Literal, Self

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.field_types import Strata
from alight.core.rng import hash_1, hash_2, sample_keys, unit_float
from alight.core.spec import Sampler
from alight.samplers.permutation import make_permute
from lanewise.jit import kernel
from lanewise.simd import minimum, to_float


class Stratified(Sampler):
    """Jittered grid.

    Parameters
    ----------
    strata : int in [1, 1024], default 4
        Cells n along each axis; a block holds n * n samples.
    """

    type: Literal["stratified"] = "stratified"
    strata: Strata = 4

    @property
    def block(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Samples that are one whole."""
        return self.strata**2

    def with_block(self, samples: int) -> Self:
        """Strata for blocks of at most so many samples."""
        return self.replaced(strata=max(1, math.isqrt(samples)))


EXAMPLES = (Stratified(), Stratified(strata=1), Stratified(strata=7))


#: Slope of log(mean squared error) over log(samples) for a smooth integrand, in 1-D and 2-D, while
#: the strata of one block grow with it. Further blocks of the same size only average: slope -1.
EXPECTED_RATE = (-3.0, -2.0)

#: As for `sobol`; blocks of n = 16 samples are permuted: n / (n - 1).
WORST_GAIN = 16 / 15


def make_kernels(strata):
    """(get_1d, get_2d) of this sampler for blocks of strata * strata samples."""
    cells = strata * strata
    permute = make_permute(cells)
    width, height = 1.0 / strata, 1.0 / cells

    @kernel
    def get_1d(state, dimension):
        block, a, b = block_and_keys(state, cells)
        cell = permute(state.index - block * cells, hash_1(a, b, dimension))
        a, b = sample_keys(a, b, state.index)
        jitter = unit_float(hash_1(a, b, dimension))
        return minimum((to_float(cell) + jitter) * height, ONE_MINUS_EPSILON)

    @kernel
    def get_2d(state, dimension):
        block, a, b = block_and_keys(state, cells)
        cell = permute(state.index - block * cells, hash_1(a, b, dimension))
        a, b = sample_keys(a, b, state.index)
        first, second = hash_2(a, b, dimension)
        row = cell // strata
        column = cell - row * strata
        x = minimum((to_float(column) + unit_float(first)) * width, ONE_MINUS_EPSILON)
        y = minimum((to_float(row) + unit_float(second)) * width, ONE_MINUS_EPSILON)
        return x, y

    return get_1d, get_2d


@kernel
def block_and_keys(state, cells):
    """Number of the block that a sample is in, and the keys of that block."""
    block = state.index // cells
    a, b = state.a, state.b
    a, b = sample_keys(a, b, block)
    return block, a, b
