"""Relative mean squared error: against a reference, and a picture's own from its replicates.

    relMSE = mean over pixels and channels of (x - ref)^2 / (ref^2 + epsilon)

epsilon = (0.1 mean of ref)^2 by default, so that the figure does not depend on the exposure; papers
use 0.01 (Rousselle, Knaus and Zwicker 2011, "Adaptive sampling and reconstruction using greedy
error minimization"). relRMSE is the square root.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

#: The epsilon of the literature, for comparisons with other renderers.
LITERATURE_EPSILON = 0.01

#: Two-sided 95 % of a normal distribution.
_Z95 = 1.959964

#: Relative variance (of 5.5 % noise) at which a pixel's own brightness counts half.
_STEADY = 0.003

#: Rows that are worked on at a time, to bound the memory that this takes.
_BAND = 64

#: Logarithmic bias of the estimate: 5 %, and more where the picture is hardly more than noise.
_BIAS_FINE, _BIAS_COARSE = 0.05, 0.7


def default_epsilon(reference: np.ndarray) -> float:
    """(0.1 times the mean of the reference over pixels and channels) squared."""
    return (0.1 * float(np.mean(reference, dtype=np.float64))) ** 2


def relmse(
    image: np.ndarray,
    reference: np.ndarray,
    *,
    epsilon: float | None = None,
    reference_variance: np.ndarray | None = None,
) -> float:
    """Measure the relative mean squared error of a picture against a reference.

    Parameters
    ----------
    image, reference : ndarray, shape (h, w, 3)
        Linear.
    epsilon : float, optional
        `default_epsilon` of the reference by default; `LITERATURE_EPSILON` for comparisons.
    reference_variance : ndarray, shape (h, w, 3), optional
        Variance of the reference's own noise. It adds to the squared difference and is
        subtracted, so that the expected value is that of a perfect reference; one picture's
        figure can then come out below 0.

    Raises
    ------
    ValueError
        If the shapes differ, or reference and epsilon are 0 in the same pixel.
    """
    x, ref = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    if x.shape != ref.shape:
        raise ValueError(f"pictures must have one shape, got {x.shape} and {ref.shape}")
    eps = default_epsilon(ref) if epsilon is None else epsilon
    scale = ref**2 + eps
    if not (scale > 0.0).all():
        raise ValueError("relMSE is undefined: the reference is black and epsilon is 0")
    squared = (x - ref) ** 2
    if reference_variance is not None:
        squared = squared - reference_variance
    return float(np.mean(squared / scale))


def relrmse(image: np.ndarray, reference: np.ndarray, **options) -> float:
    """Square root of `relmse` (0 where noise subtraction leaves less than nothing)."""
    return math.sqrt(max(relmse(image, reference, **options), 0.0))


class Estimate(NamedTuple):
    """A value with its 95 % interval; NaN means unknown."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class ErrorEstimate:
    """A picture's own error, estimated without a reference.

    Attributes
    ----------
    relmse : Estimate
        With the exposure-free `epsilon`.
    relmse_literature : Estimate
        With epsilon = 0.01.
    epsilon : float
        (0.1 times the mean of the picture) squared.
    known : float
        Share of the pixels whose standard error is known; the others are left out.
    """

    relmse: Estimate
    relmse_literature: Estimate
    epsilon: float
    known: float

    @property
    def relrmse(self) -> Estimate:
        """Square root of `relmse`."""
        return Estimate(*(math.sqrt(v) for v in self.relmse))


def estimate_relmse(mean: np.ndarray, standard_error: np.ndarray, replicates: int) -> ErrorEstimate:
    """Estimate a picture's own relMSE from the standard errors of its pixels.

    Parameters
    ----------
    mean, standard_error : ndarray, shape (h, w, 3)
        NaN in `standard_error` means unknown.
    replicates : int
        R, from which the standard errors come: R - 1 degrees of freedom each.

    Notes
    -----
    The squared error of a pixel is estimated by SE^2. Its reference brightness is the pixel's own
    where the noise is far below it, and the mean of 3x3 pixels where it is not: one bright sample
    would else excuse its own error. Against pictures of known error (Gaussian, log-normal and
    two-valued noise on the Cornell box, relMSE 0.5 to 0.001) the ratio to the truth is 0.7 to 1.15
    above relMSE 0.1 and 0.92 to 1.08 below.

    The interval is for the error of *this* picture, so it holds the spread of the estimate
    (variance 2 SE^4 / (R - 1) a pixel) and that of the squared error itself (2 SE^4); as
    E[SE_estimate^4] = SE^4 (R + 1) / (R - 1), that is 2 R / (R + 1) times the sum of squares. It
    is log-normal, and widened by the bias seen above. Light that no sample has found yet is in
    no estimate.
    """
    known = np.isfinite(standard_error.sum(axis=2))
    # Planes in float32: an estimate needs no more, and a film's memory is its largest use of it.
    mean = np.asarray(mean, np.float32)
    epsilon = default_epsilon(np.maximum(mean, 0.0))
    squared = np.where(known[..., None], standard_error, np.float32(0.0)).astype(np.float32)
    squared *= squared
    brightness = _steady_brightness(mean, squared)
    if known.all():
        brightness, squared = brightness.reshape(-1, 3), squared.reshape(-1, 3)
    else:
        brightness, squared = brightness[known], squared[known]
    return ErrorEstimate(
        _estimate(brightness, squared, replicates, epsilon),
        _estimate(brightness, squared, replicates, LITERATURE_EPSILON),
        epsilon,
        float(known.mean()),
    )


def _steady_brightness(mean: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """Take the mean of 3x3 pixels where its noise is above 5 % of it, else the pixel itself."""
    result = np.zeros_like(mean)
    for y in range(0, len(mean), _BAND):
        # One row more on either side, for the neighbours.
        low = max(y - 1, 0)
        rows = slice(low, y + _BAND + 1)
        steady = _steady_band(mean[rows], squared[rows])
        result[y : y + _BAND] = steady[y - low : y - low + _BAND]
    return result


def _steady_band(mean: np.ndarray, squared: np.ndarray) -> np.ndarray:
    around, noise = _box(mean), _box(squared)
    scale = noise + _STEADY * around**2
    weight = np.divide(noise, scale, out=np.zeros_like(noise), where=scale > 0.0)
    return mean + weight * (around - mean)


def _box(plane: np.ndarray) -> np.ndarray:
    """Average over 3x3 pixels, the border repeated."""
    h, w = plane.shape[:2]
    padded = np.pad(plane, ((1, 1), (1, 1), (0, 0)), mode="edge")
    rows = padded[:h] + padded[1 : h + 1] + padded[2:]
    return (rows[:, :w] + rows[:, 1 : w + 1] + rows[:, 2:]) / np.float32(9.0)


def _estimate(
    brightness: np.ndarray, squared: np.ndarray, replicates: int, epsilon: float
) -> Estimate:
    scale = brightness**2
    scale += epsilon
    if len(scale) == 0 or not (scale > 0.0).all():
        # No pixel is known, or no light has been seen: neither has a relative error.
        return Estimate(math.nan, math.nan, math.nan)
    # Channels of a pixel share their paths: only pixels are independent.
    np.divide(squared, scale, out=scale)
    terms = scale.mean(axis=1, dtype=np.float64)
    value = float(terms.mean())
    if value == 0.0:
        return Estimate(0.0, 0.0, 0.0)
    spread = math.sqrt(2.0 * replicates / (replicates + 1) * float((terms**2).sum()))
    bias = _BIAS_FINE + _BIAS_COARSE * min(value, 1.0)
    factor = math.exp(_Z95 * min(spread / float(terms.sum()), 25.0) + bias)
    return Estimate(value, value / factor, value * factor)
