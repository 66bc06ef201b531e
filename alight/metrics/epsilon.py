"""What keeps the relative error of black pixels finite."""

from __future__ import annotations

import numpy as np

#: The epsilon of the literature, for comparisons with other renderers.
LITERATURE_EPSILON = 0.01


def default_epsilon(reference: np.ndarray) -> float:
    """(0.1 times the mean of the reference over pixels and channels) squared."""
    return (0.1 * float(np.mean(reference, dtype=np.float64))) ** 2
