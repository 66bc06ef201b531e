"""Symmetric mean absolute percentage error, a figure that a single firefly cannot dominate.

    SMAPE = mean over pixels and channels of |a - b| / (|a| + |b| + epsilon)

In [0, 1], as in Vogels et al. 2018, "Denoising with kernel prediction and asymmetric loss
functions", section 4.2.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.metrics.model import Metric, Pair

#: Keeps black pixels from counting by their last bits.
EPSILON = 0.01


def smape(image: np.ndarray, reference: np.ndarray, epsilon: float = EPSILON) -> float:
    """Symmetric mean absolute percentage error of two linear pictures, 0 to 1.

    Parameters
    ----------
    image, reference : ndarray, shape (h, w, 3)
    epsilon : float, default 0.01
        > 0.

    Raises
    ------
    ValueError
        If the shapes differ or epsilon is not positive.
    """
    a, b = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    if a.shape != b.shape:
        raise ValueError(f"pictures must have one shape, got {a.shape} and {b.shape}")
    if not epsilon > 0.0:
        raise ValueError(f"epsilon must be > 0, got {epsilon}")
    return float(np.mean(np.abs(a - b) / (np.abs(a) + np.abs(b) + epsilon)))


class Smape(Metric):
    """Symmetric mean absolute percentage error."""

    type: Literal["smape"] = "smape"


EXAMPLES = (Smape(),)

LABEL, BOUNDED = "SMAPE", True


def evaluate(spec, pair: Pair) -> float:
    """`smape`."""
    return smape(pair.image, pair.reference)
