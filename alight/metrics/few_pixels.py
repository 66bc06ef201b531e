"""How many pixels a sum of squared errors really has, however few they are."""

from __future__ import annotations

import math

import numpy as np


class FewPixels:
    """Keeps a few pixels that carry the error from passing for many.

    The products of two halves that tell the spread are close to 0 by chance where there are few of
    them: for one pixel of R = 4 each is one of two chi-squared numbers with one degree of freedom.
    The squares of the pixels' covariances by all replicates tell it too: they are too large where
    tails are heavy, but never leave less than one pixel. So the spread is that of the products and
    once their own deviation, as far as the squares say so.

    Parameters
    ----------
    replicates, size : int
        Of the picture, at least 4, and of each half, at least 2.
    """

    def __init__(self, replicates: int, size: int) -> None:
        self._freedom, half = replicates - 1, size - 1
        # Of the product of two halves' squared errors, over its mean: 8 for R = 4.
        self._variance = (1.0 + 2.0 / half) ** 2 - 1.0
        self._sum = self._squares = self._fourth_powers = 0.0

    def add(self, covariances: np.ndarray) -> None:
        """Add pixels: their covariances of channels, weighted, (3, 3, rows, w), d <= c."""
        trace = covariances[0, 0] + covariances[1, 1] + covariances[2, 2]
        whole, n = trace * trace, self._freedom
        # tr(Sigma^2) by normal noise (Wishart's distribution), which three channels share at best.
        least = whole / np.float32(3.0 + 2.0 / n)
        square = whole * np.float32(-1.0 / n)
        for c in range(3):
            square += covariances[c, c] ** 2
            for d in range(c):
                square += np.float32(2.0) * covariances[c, d] ** 2
        square *= np.float32(n * n / ((n + 2.0) * (n - 1.0)))
        np.maximum(least, square, out=least)
        self.add_sums(
            float(trace.sum(dtype=np.float64)),
            float(least.sum(dtype=np.float64)),
            float(np.square(least, dtype=np.float64).sum()),
        )

    def add_sums(self, traces: float, squares: float, fourth_powers: float) -> None:
        """Add pixels by their sums: of traces, of squares at least, and of these squared."""
        self._sum += traces
        self._squares += squares
        self._fourth_powers += fourth_powers

    def at_least(self, spread: float, value: float) -> float:
        """The sum of sigma^4, given its estimate by products and the sum of sigma^2."""
        scale = (value / self._sum) ** 2 if self._sum > 0.0 else 0.0
        chance = math.sqrt(self._variance * self._fourth_powers)
        return max(spread, min(scale * self._squares, spread + scale * chance))

    def freedom(self, value: float, spread: float) -> float:
        """Degrees of freedom of a sum: (sum of sigma^2)^2 over the sum of sigma^4.

        The squared sum of estimates is too large by their variance, 2 / (R - 1) times the spread.
        """
        if spread <= 0.0:
            return 1e12
        alike = value * value / spread
        return min(max(alike - 2.0 / self._freedom, min(alike, 1.0)), 1e12)
