r"""Where samples go: to the 8x8 cells in which they lower the error most.

With n_c samples in a cell of relative variance V_c per sample, relMSE is the sum of V_c / n_c, and
smallest at a given cost for n_c proportional to the root of V_c (Neyman 1934, "On the two different
aspects of the representative method"). V_c comes from a **pilot that is not in the picture**: a few
samples of a seed of its own. So the counts are known before the first sample that counts, a mean is
a sum over a fixed number, and every pixel is unbiased; `docs/known-error.md` compares other ways.

`alight.rendering.schedules.cycles` has, for comparison, the rule of Blender's Cycles, which is not
unbiased.
"""

from __future__ import annotations

import math

import numpy as np

from alight.films import CELL_SIZE, Film
from alight.films.sample_ranges import cells_of
from alight.metrics.planes import box, planes_of, same_everywhere, squares, weighted

#: Samples per pixel of the pilot; fixed, so that a render can be extended to any number.
PILOT_SPP = 8

#: A cell gets no less and no more of the samples than these times its even share: what the pilot
#: did not see is not left out, and what it saw once is not overdone.
LEAST, MOST = 0.2, 8.0

#: A smaller gain is left alone, and all cells get the same.
_WORTH = 1.05

#: Weight of the cells around in a cell's variance.
_AROUND = 0.2


def _edges(start: int, length: int) -> np.ndarray:
    """Where the cells of a window begin, counted from its corner."""
    first = -(start % CELL_SIZE)
    return np.maximum(np.arange(first, length, CELL_SIZE), 0)


def over_cells(film: Film, plane: np.ndarray, operation: np.ufunc) -> np.ndarray:
    """Reduce the pixels of each cell of a film's window."""
    x, y, w, h = film.crop
    rows = operation.reduceat(plane, _edges(y, h), axis=0)
    return operation.reduceat(rows, _edges(x, w), axis=1)


def _correlation(a: np.ndarray, b: np.ndarray, weights: np.ndarray) -> float:
    """Of two planes, 0 where it is negative or nothing varies."""
    weights = weights / weights.sum()
    a, b = a - (a * weights).sum(), b - (b * weights).sum()
    spread = float((a * a * weights).sum() * (b * b * weights).sum())
    return max(float((a * b * weights).sum()) / math.sqrt(spread), 0.0) if spread > 0.0 else 0.0


def shares_of(pilot: Film) -> np.ndarray:
    """Find each cell's share of the samples from the film of a pilot.

    Returns
    -------
    ndarray of float64, shape (cells_y, cells_x)
        Of the full film; their mean over the pixels of the window is 1, and 0 outside it.
    """
    means, counts = pilot.replicate_means()
    m, k = planes_of(means, same_everywhere(counts))
    mean = weighted(m, k)
    epsilon = np.float32((0.1 * float(mean.mean(dtype=np.float64))) ** 2)
    scale = np.maximum(box(mean) ** 2 + epsilon, np.float32(1e-30))
    pixels = over_cells(pilot, np.ones(mean.shape[1:]), np.add)

    def deviation(part: slice) -> np.ndarray:
        own = weighted(m[part], k[part])
        relative = (squares(m[part], k[part], own) / scale).sum(axis=0)
        variance = over_cells(pilot, relative, np.add) / pixels
        return np.sqrt((1.0 - _AROUND) * variance + _AROUND * box(variance))

    shares = deviation(slice(None))
    if pilot.replicates >= 4:
        # Cells differ by chance, too. Two halves of the pilot tell how much of it is chance: with
        # a correlation r of halves that of the whole is 2 r / (1 + r) (Spearman and Brown 1910).
        first, second = deviation(slice(0, None, 2)), deviation(slice(1, None, 2))
        agreement = _correlation(first, second, pixels)
        average = float((shares * pixels).sum() / pixels.sum())
        shares = average + 2.0 * agreement / (1.0 + agreement) * (shares - average)
    # A few rounds of cutting and scaling settle it; a black or noiseless pilot says nothing.
    for _ in range(20):
        mean_share = float((shares * pixels).sum() / pixels.sum())
        shares = np.clip(shares / mean_share, LEAST, MOST) if mean_share > 0.0 else shares + 1.0
    # relMSE of even samples over that of these shares; counts that differ cost evenness.
    if float((shares**2 * pixels).sum() / pixels.sum()) < _WORTH:
        shares = np.ones(shares.shape)
    result = np.zeros(pilot.cells.shape)
    result[cells_of(*pilot.crop)] = shares
    return result


def counts_at(shares: np.ndarray, spp: int, replicates: int) -> np.ndarray:
    """Samples of each cell when the picture has about `spp` on average: whole rounds of replicates.

    They only grow with `spp`, so that a film of fewer is part of a film of more. A replicate gets
    4, 5, 6 or 7 times a power of two samples, as at the looks of even ones: between these the
    points of its sequence are less even, which would cost more than a finer share brings.

    Returns
    -------
    ndarray of int64, shape (cells_y, cells_x)
    """
    rounds = np.rint(shares * (spp / replicates)).astype(np.int64)
    step = np.maximum(2 ** np.floor(np.log2(np.maximum(rounds, 1))).astype(np.int64) // 4, 1)
    rounds = (rounds + step // 2) // step * step
    return replicates * np.where(shares > 0.0, np.maximum(rounds, 1), 0)
