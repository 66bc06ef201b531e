"""Whether a few bright samples decide which of two arms is noisier.

The jackknife over batches knows what batches have met. Light that one sample in a million brings
may be in two batches of one arm and by chance in none of the other, which then seems to be quiet
beyond doubt. But if both arms meet such samples equally often, each of them is as likely in either:
how many are in the noisier one is binomial, and its tail bounds any p-value (the sign test).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

#: Of all squares of both arms, this part is asked who brings it; more samples than `FEW` are many.
CARRIED, FEW = 0.9, 64


class Squares(NamedTuple):
    """Weighted squared deviations of the replicates' pixels from their mean.

    Attributes
    ----------
    largest : (n,) float64
        The `FEW` largest, or all.
    total : float
        Sum of all.
    """

    largest: np.ndarray
    total: float


class Decided(NamedTuple):
    """What few samples decide.

    Attributes
    ----------
    samples : int
        That carry the noise; 0 where there are many.
    p_value : float
        Of "both arms meet them equally often"; 0 where there are many.
    """

    samples: int = 0
    p_value: float = 0.0


def squares_of(sums: np.ndarray, weights: np.ndarray) -> Squares:
    """Squares of one batch.

    Parameters
    ----------
    sums : (h, w, replicates, 3) float64
    weights : (h, w, 3) float64
        Of squared deviations.
    """
    deviations = sums - sums.mean(axis=2, keepdims=True)
    squares = (deviations**2 * weights[:, :, None]).sum(axis=3).ravel()
    return Squares(np.sort(squares)[::-1][:FEW], float(squares.sum()))


def decided(here: Sequence[Squares], there: Sequence[Squares]) -> Decided:
    """Ask whether few samples carry the noise of two arms, and how surely they differ then."""
    total = sum(batch.total for batch in (*here, *there))
    largest = [np.concatenate([batch.largest for batch in arm]) for arm in (here, there)]
    in_here = np.repeat([True, False], [len(values) for values in largest])
    values = np.concatenate(largest)
    order = np.argsort(-values, kind="stable")
    enough = np.flatnonzero(np.cumsum(values[order]) >= CARRIED * total)
    if not len(enough) or enough[0] >= FEW or total <= 0.0:
        return Decided()
    count = int(enough[0]) + 1
    mine = int(in_here[order[:count]].sum())
    tail = sum(math.comb(count, k) for k in range(max(mine, count - mine), count + 1))
    return Decided(count, min(1.0, 2.0 * tail / 2**count))
