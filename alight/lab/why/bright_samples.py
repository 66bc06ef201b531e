"""Whether a few bright samples decide which of two arms is noisier.

The jackknife over batches knows what batches have met. Light that one sample in a million brings
may be in two batches of one arm and by chance in none of the other, which then seems to be quiet
beyond doubt. But if both arms meet such samples equally often, each of them is in one or the other
with a probability that is known, its share of the batches: the number in one is binomial, and its
tail bounds any p-value (a sign test, where both have as many batches).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

#: Share of both arms' squares that few samples have to carry; more samples than `FEW` are many.
CARRIED, FEW = 0.9, 64


class Squares(NamedTuple):
    """Weighted squared deviations of the replicates from their mean, a sum for each pixel.

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
    # Pixel by pixel: a bright sample moves the mean of all replicates, and is one sample.
    squares = (deviations**2 * weights[:, :, None]).sum(axis=(2, 3)).ravel()
    return Squares(np.sort(squares)[::-1][:FEW], float(squares.sum()))


def decided(here: Sequence[Squares], there: Sequence[Squares]) -> Decided:
    """Whether few samples carry the noise of two arms, and how surely the arms differ then."""
    total = sum(batch.total for batch in (*here, *there))
    largest = [np.concatenate([batch.largest for batch in arm]) for arm in (here, there)]
    in_here = np.repeat([True, False], [len(values) for values in largest])
    values = np.concatenate(largest)
    order = np.argsort(-values, kind="stable")
    enough = np.flatnonzero(np.cumsum(values[order]) >= CARRIED * total)
    if not len(enough) or enough[0] >= FEW or total <= 0.0:
        return Decided()
    count = int(enough[0]) + 1
    mine, share = int(in_here[order[:count]].sum()), len(here) / (len(here) + len(there))
    part = [math.comb(count, k) * share**k * (1.0 - share) ** (count - k) for k in range(count + 1)]
    return Decided(count, min(1.0, 2.0 * min(sum(part[: mine + 1]), sum(part[mine:]))))
