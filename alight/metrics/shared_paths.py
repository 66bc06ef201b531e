r"""How sure an error is where one path adds to several pixels.

The estimate of `alight.metrics.own_error` lacks a sum of products of independent errors, whose
variance is that of a sum over pixels. Where light paths splat, pixels are not independent. With C
the covariance of the picture's error over all its values and W their weights, the variance is
proportional to

.. math:: \operatorname{tr}(W C W C) = \operatorname E\bigl[(a^T W b)^2\bigr]

for independent errors a and b of covariance C. Contrasts between the replicates of one half are
such a, those of the other half such b.
"""

from __future__ import annotations

import numpy as np


class SharedPaths:
    """The products of both halves' contrasts, summed band by band.

    Parameters
    ----------
    replicates : int
        At least 4: each half has contrasts of its own.
    """

    def __init__(self, replicates: int) -> None:
        self._replicates, half = replicates, replicates // 2
        # Orthonormal and orthogonal to the mean, as the columns of Helmert's matrix are.
        self._first = _contrasts(half)
        self._second = _contrasts(replicates - half)
        self._sums = np.zeros((half - 1, replicates - half - 1))

    def add(self, means: np.ndarray, weights: np.ndarray) -> None:
        """Add some rows.

        Parameters
        ----------
        means : ndarray, shape (R, 3, rows, w)
            Of the samples of each replicate, which have about as many each.
        weights : ndarray, shape (3, rows, w)
            By which squared errors are multiplied.
        """
        scaled = (means * np.sqrt(weights)).reshape(self._replicates, -1)
        half = self._replicates // 2
        self._sums += (self._first.T @ scaled[:half]) @ (self._second.T @ scaled[half:]).T

    @property
    def spread(self) -> float:
        """Estimate tr(W C W C)."""
        return float(np.mean((self._sums / self._replicates) ** 2))


def _contrasts(count: int) -> np.ndarray:
    """Orthonormal columns whose sums are 0, shape (count, count - 1)."""
    columns = np.column_stack([np.ones(count), np.eye(count)[:, : count - 1]])
    return np.linalg.qr(columns)[0][:, 1:]
