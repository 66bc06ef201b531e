"""Unseen light: the relRMSE of events that no sample has met yet."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from alight.films import CELL_SIZE, Film
from alight.rendering.pilot_rays import POINTS

#: With no event among N samples, its probability is below 3 / N with 95 % confidence.
_RULE_OF_THREE = 3.0


def cell_sum(plane: np.ndarray) -> np.ndarray:
    """Sum of each 8x8 pixels, float64, for planes (h, w, ...)."""
    y, x = range(0, plane.shape[0], CELL_SIZE), range(0, plane.shape[1], CELL_SIZE)
    return np.add.reduceat(np.add.reduceat(plane, y, axis=0, dtype=np.float64), x, axis=1)


def spread_over_pixels(cells: np.ndarray, height: int, width: int) -> np.ndarray:
    """Give every pixel the value of its cell."""
    rows, columns = np.arange(height) // CELL_SIZE, np.arange(width) // CELL_SIZE
    return cells[rows][:, columns]


class Unseen(NamedTuple):
    """relRMSE of light that no sample has met yet.

    Attributes
    ----------
    indicator : float
        If an unseen event is as bright as the largest contribution seen in its cell, and with the
        light behind glass that no sample is expected to have met.
    bound : float
        If it is as bright as a sample can be; NaN where that is not known.
    doubtful : float
        Share of the picture in whose cells `figure` exceeds the error.
    by_chance : bool, default False
        Whether only the bound counts.
    factor : float, default 1
        So many times the samples make rare light (`Film.rare_light`) smaller than the error.
    hidden : float, default 0
        That light alone, a relRMSE: what is expected to be missing, and no bound.
    """

    indicator: float
    bound: float
    doubtful: float
    by_chance: bool = False
    factor: float = 1.0
    hidden: float = 0.0

    @property
    def figure(self) -> float:
        """The smaller one; the bound where no path is led to a light, infinity if it is unknown."""
        bound = math.inf if math.isnan(self.bound) else self.bound
        return bound if self.by_chance else min(self.indicator, bound)


def unseen_of(film: Film) -> Unseen:
    """`unseen_error` of a film; `doubtful` against an error of 1 %."""
    known = film.largest_sample, film.by_chance, film.rare_light
    return unseen_error(*film.replicate_means(), 0.01, *known)


def unseen_error(
    means: np.ndarray,
    counts: np.ndarray,
    error: float,
    largest: float | None = None,
    by_chance: bool = False,
    behind: np.ndarray | None = None,
) -> Unseen:
    """Estimate the relRMSE of light that no sample has met yet.

    An event that none of the k n samples of a cell's k pixels has met has a probability below
    3 / (k n). If it brings c, up to 3 c / (k n) of each pixel's light is missing. For a bound c is
    `largest`. For the indicator it is the largest contribution seen in the cell: what one
    replicate's sum has more than the others say, at least the largest sample if that stands out.
    If any replicate is negative, samples have both signs (filters with negative lobes), and what
    one has less counts as well.

    Parameters
    ----------
    means : ndarray, shape (h, w, R, 3)
    counts : ndarray of int, shape (h, w, R)
    error : float
        For `Unseen.doubtful`.
    largest : float, optional
        No sample can be larger (`alight.rendering.schedules.sample_bound`).
    by_chance : bool, default False
        Whether no path is led to a light. A lamp that no sample has met is then in no contribution
        either, so that the indicator says nothing.
    behind : ndarray, shape (n, 7), optional
        `Film.rare_light`. No sample of a cell has met a light that k n samples find with
        probability q each, with probability exp(-k n q).
    """
    n = counts.sum(axis=2)
    height, width = n.shape
    # Where samples have both signs, what is missing may be as far below as above.
    signed = bool((means < 0.0).any())
    bright, most = [], []
    total = 0.0
    # Whole rows of cells at a time: the planes of a replicate stay in the processor's cache.
    for y in range(0, height, CELL_SIZE):
        rows = slice(y, y + CELL_SIZE)
        m = np.ascontiguousarray(means[rows].transpose(2, 3, 0, 1), np.float32)
        k = np.ascontiguousarray(counts[rows].transpose(2, 0, 1)[:, None], np.float32)
        sums = k.sum(axis=0)
        mean = (m * k).sum(axis=0) / np.maximum(sums, 1.0)
        excess = (m - mean) * (k * sums / np.maximum(sums - k, 1.0))
        if signed:
            np.abs(excess, out=excess)
        columns = range(0, width, CELL_SIZE)
        most.append(np.maximum.reduceat(excess.max(axis=(0, 2)), columns, axis=1))
        bright.append(np.add.reduceat(mean.sum(axis=1), columns, axis=1))
        total += float(mean.sum(dtype=np.float64))
    samples = np.maximum(cell_sum(n), 1.0)
    pixels = cell_sum(np.ones(n.shape))
    epsilon = (0.1 * total / (3 * n.size)) ** 2
    brightness = np.stack(bright, axis=1) / pixels
    scale = brightness**2 + epsilon
    weights = pixels / pixels.sum()
    seen = _missing(np.maximum(np.stack(most, axis=1), 0.0), samples, scale)
    hidden = _Hidden(behind, samples, brightness, epsilon)
    expected = hidden.relmse()
    missing = float(expected.sum())
    indicator = math.sqrt(float((seen * weights).sum()) + missing)
    factor = hidden.factor(error)
    # Each point stands for the same part of the picture.
    share = float((expected * POINTS > error**2).sum()) / POINTS
    if largest is None:
        doubtful = 1.0 if by_chance else max(float(weights[seen > error**2].sum()), share)
        return Unseen(indicator, math.nan, doubtful, by_chance, factor, math.sqrt(missing))
    possible = _missing(np.float64(largest), samples, scale)
    bound = math.sqrt(float((possible * weights).sum()))
    told = possible if by_chance else np.minimum(seen, possible)
    doubtful = float(weights[told > error**2].sum())
    if bound <= error:
        # Whatever the indicator says.
        return Unseen(indicator, bound, doubtful, by_chance)
    return Unseen(indicator, bound, max(doubtful, share), by_chance, factor, math.sqrt(missing))


class _Hidden:
    """Light behind glass that no sample is expected to have met."""

    def __init__(
        self,
        behind: np.ndarray | None,
        samples: np.ndarray,
        brightness: np.ndarray,
        epsilon: float,
    ) -> None:
        self.behind, self.epsilon = behind, epsilon
        if behind is not None:
            cells = behind[:, 1].astype(int)
            self.found = samples.ravel()[cells] * behind[:, 5]
            self.points, first, self.of_row = np.unique(
                behind[:, 0].astype(int), return_index=True, return_inverse=True
            )
            self.brightness = brightness.reshape(3, -1)[:, cells[first]]

    def relmse(self, factor: float = 1.0) -> np.ndarray:
        """Of each of the pilot's points that sees such light, over all points."""
        if self.behind is None:
            return np.zeros(0)
        missing = np.zeros((3, len(self.points)))
        # A cell lacks such light as a whole, with probability e^-f, or has it: the root of the mean
        # square. Roots of squares of several lights add up to no less than that of their sum.
        unmet = self.behind[:, 2:5] * np.exp(-0.5 * factor * self.found)[:, None]
        for channel in range(3):
            np.add.at(missing[channel], self.of_row, unmet[:, channel])
        # What is missing is a part of the true brightness.
        scale = (self.brightness + missing) ** 2 + self.epsilon
        return (missing**2 / np.maximum(scale, 1e-300)).mean(axis=0) / POINTS

    def factor(self, error: float) -> float:
        """So many times the samples make it smaller than an error."""
        factor = 1.0
        while factor < 1e9 and float(self.relmse(factor).sum()) > error**2:
            factor *= 1.25
        return factor


def _missing(brightest: np.ndarray, samples: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """relMSE of each cell if events so bright are missing, from planes (3, ...) and counts."""
    return ((_RULE_OF_THREE * brightest / samples) ** 2 / np.maximum(scale, 1e-300)).mean(axis=0)
