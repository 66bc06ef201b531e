"""Mean squared error, the plain one: in squared units of radiance.

MSE = mean over pixels and channels of (x - ref)^2
"""

from __future__ import annotations

import numpy as np


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
