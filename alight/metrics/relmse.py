"""Relative mean squared error of a picture against a reference.

    relMSE = mean over pixels and channels of (x - ref)^2 / (ref^2 + epsilon)

epsilon = (0.1 mean of ref)^2 by default, so that the figure does not depend on the exposure; papers
use 0.01 (Rousselle, Knaus and Zwicker 2011, "Adaptive sampling and reconstruction using greedy
error minimization"). relRMSE is the square root. `own_error` estimates a picture's own.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from alight.metrics.epsilon import default_epsilon
from alight.metrics.model import Metric, Pair


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


class RelMse(Metric):
    """Relative mean squared error, whatever the exposure."""

    type: Literal["relmse"] = "relmse"


EXAMPLES = (RelMse(),)

LABEL = "relMSE"


def evaluate(spec, pair: Pair) -> float:
    """`relmse`; NaN of a black reference."""
    if default_epsilon(pair.reference) == 0.0:
        return math.nan
    return relmse(pair.image, pair.reference)


def weight(spec, reference: np.ndarray) -> np.ndarray:
    """1 / (ref^2 + epsilon); a black picture has no relative error, any epsilon will do."""
    return 1.0 / (reference**2 + np.float32(default_epsilon(reference) or 1.0))


def label(spec, pair: Pair) -> str:
    """Its epsilon is the reference's."""
    return f"relMSE, ε = {default_epsilon(pair.reference):.3g}"
