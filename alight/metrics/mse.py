"""Mean squared error, the plain one: in squared units of radiance.

MSE = mean over pixels and channels of (x - ref)^2
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.metrics.model import Metric, Pair


def mse(image: np.ndarray, reference: np.ndarray) -> float:
    """Mean squared difference of two linear pictures.

    Parameters
    ----------
    image, reference : ndarray, shape (h, w, 3)

    Raises
    ------
    ValueError
        If the shapes differ.
    """
    x, ref = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    if x.shape != ref.shape:
        raise ValueError(f"pictures must have one shape, got {x.shape} and {ref.shape}")
    return float(np.mean((x - ref) ** 2))


class Mse(Metric):
    """Mean squared error, in squared units of radiance."""

    type: Literal["mse"] = "mse"


EXAMPLES = (Mse(),)

LABEL = "MSE"


def evaluate(spec, pair: Pair) -> float:
    """`mse`."""
    return mse(pair.image, pair.reference)


def weight(spec, reference: np.ndarray) -> np.ndarray:
    """All errors count alike."""
    return np.ones((), np.float32)
