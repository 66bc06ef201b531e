"""What a picture's replicates say at first sight: what every estimate of its error begins with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from alight.metrics.planes import (
    over_replicates,
    planes_of,
    same_everywhere,
    squares,
    weighted,
)
from alight.metrics.surroundings import around

#: Rows that are worked on at a time: whole cells, and few enough to stay in the processor's cache.
BAND = 32


class Survey(NamedTuple):
    """A picture by its replicates, its noise and its surroundings: work that estimates share.

    Attributes
    ----------
    means : ndarray of float32, shape (h, w, R, 3)
        Of the samples of each replicate.
    counts : ndarray of int, shape (h, w, R), or (1, 1, R) where all pixels have the same
    known : ndarray of bool, shape (h, w)
        Pixels without an empty replicate; none if there is only one.
    picture, variance, surroundings : ndarray of float32, shape (3, h, w)
        The picture, its squared standard error, and the brightness around each pixel.
    epsilon : float
        (0.1 times the mean of the picture) squared.
    shares_paths : bool, default False
        Whether one path adds to several pixels, whose errors then depend on each other.
    """

    means: np.ndarray
    counts: np.ndarray
    known: np.ndarray
    picture: np.ndarray
    variance: np.ndarray
    surroundings: np.ndarray
    epsilon: float
    shares_paths: bool = False

    @property
    def replicates(self) -> int:
        """How many there are."""
        return self.counts.shape[2]

    def bands(self) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Some rows at a time, and the replicates' means and counts there, plane by plane."""
        yield from _bands(self.means, self.counts)


def survey(means: np.ndarray, counts: np.ndarray, shares_paths: bool = False) -> Survey:
    """Survey a picture.

    Parameters
    ----------
    means : ndarray of float32, shape (h, w, R, 3)
        Of the samples of each replicate.
    counts : ndarray of int, shape (h, w, R)
    shares_paths : bool, default False
        See `Survey`.
    """
    h, w, replicates, _ = means.shape
    counts = same_everywhere(counts)
    known = np.zeros((h, w), bool)
    if replicates > 1:
        known[...] = over_replicates(counts, np.minimum) > 0
    picture, variance = np.zeros((3, h, w), np.float32), np.zeros((3, h, w), np.float32)
    for rows, m, k in _bands(means, counts):
        picture[:, rows] = own = weighted(m, k)
        spread = squares(m, k, own)
        spread /= np.maximum(k.sum(axis=0), np.float32(1.0)) * np.float32(max(replicates - 1, 1))
        variance[:, rows] = spread
    lit = np.maximum(picture, 0.0)
    average = float(lit.mean(dtype=np.float64))
    epsilon = 0.01 * average * average
    surroundings = around(lit, variance, epsilon)
    return Survey(
        means=means, counts=counts, known=known, picture=picture, variance=variance,
        surroundings=surroundings, epsilon=epsilon, shares_paths=shares_paths,
    )  # fmt: skip


def _bands(means: np.ndarray, counts: np.ndarray) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
    for y in range(0, len(means), BAND):
        rows = slice(y, min(y + BAND, len(means)))
        yield rows, *planes_of(means[rows], counts[rows] if len(counts) > 1 else counts)
