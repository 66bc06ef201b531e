r"""Bias and variance of an arm, pixel by pixel, from pictures of S seeds and a noisy reference.

.. math::
    \widehat{b^2} = \overline{|\bar x - r|^2 - s^2 / S - \sigma_r^2}, \qquad
    \overline{|x_i - r|^2} - \overline{\sigma_r^2} = \widehat{b^2} + \overline{s^2}
    \text{ on average over } i

with the bar over pixels and channels, s^2 the variance over the seeds and sigma_r^2 that of the
reference. Both are unbiased, so the estimate of a bias that is not there lies around 0, on either
side. Pixels are independent of each other; channels of a pixel share their paths and count as one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from alight.lab.statistics.intervals import quantile
from alight.metrics.estimate import Estimate


@dataclass
class Moments:
    """Mean and squared deviations of a growing number of pictures (Welford 1962).

    Attributes
    ----------
    count : int
    mean, squares : ndarray of float32 or float64
        Mean, and sum of squared deviations from it.
    """

    count: int = 0
    mean: np.ndarray = field(default_factory=lambda: np.zeros(()))
    squares: np.ndarray = field(default_factory=lambda: np.zeros(()))

    def add(self, picture: np.ndarray) -> None:
        """Take one more picture in."""
        if self.count == 0:
            self.mean, self.squares = np.zeros_like(picture), np.zeros_like(picture)
        self.count += 1
        difference = picture - self.mean
        self.mean = self.mean + difference / self.count
        self.squares = self.squares + difference * (picture - self.mean)

    @property
    def variance(self) -> np.ndarray:
        """Unbiased variance of one picture; NaN for fewer than two."""
        if self.count < 2:
            return np.full_like(self.mean, np.nan)
        return self.squares / (self.count - 1)


@dataclass(frozen=True)
class Parts:
    """Bias and variance of an arm, means over pixels and channels.

    Attributes
    ----------
    bias2 : Estimate
    variance : float
        Of one picture.
    """

    bias2: Estimate
    variance: float


def decompose(
    moments: Moments, reference: np.ndarray, reference_variance: np.ndarray | None
) -> Parts:
    """Estimate bias^2, with a 95 % interval, and variance.

    Parameters
    ----------
    moments : Moments
        Of at least two pictures of shape (h, w, 3).
    reference : ndarray, shape (h, w, 3)
    reference_variance : ndarray, shape (h, w, 3), optional
        None for an exact reference.
    """
    variance = moments.variance.astype(np.float64)
    difference = moments.mean.astype(np.float64) - reference
    noise = variance / moments.count
    if reference_variance is not None:
        noise = noise + reference_variance
    b2 = difference**2 - noise
    value = float(b2.mean())
    # Var(e^2) = 2 sigma^4 for the noise and 4 b^2 sigma^2 for its product with the bias.
    pixel_noise, pixel_b2 = noise.sum(axis=2), b2.sum(axis=2)
    crossed = max(float((pixel_b2 * pixel_noise).sum()), 0.0)
    width = quantile(1e7) * math.sqrt(2.0 * float((pixel_noise**2).sum()) + 4.0 * crossed) / b2.size
    return Parts(Estimate(value, value - width, value + width), float(variance.mean()))


def reference_spread(reference_variance: np.ndarray, blocks: float) -> float:
    """Variance that the reference's noise gives to every MSE alike.

    After subtraction of its mean what is left of the reference's squared noise is
    2 sigma^4 for a pixel, and as much over the degrees of freedom of the variance's estimate.

    Parameters
    ----------
    reference_variance : ndarray, shape (h, w, 3)
    blocks : float
        Independent pictures that the reference and its variance come from.
    """
    pixel = np.asarray(reference_variance, np.float64).sum(axis=2)
    doubled = 2.0 * (1.0 + 1.0 / max(blocks - 1.0, 1.0))
    return doubled * float((pixel**2).sum()) / np.asarray(reference_variance).size ** 2
