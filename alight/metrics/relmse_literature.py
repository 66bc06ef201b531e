"""relMSE with the epsilon of the literature, for comparisons with other renderers.

See `relmse`; 0.01 suits pictures whose brightness is about 1.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.metrics.epsilon import LITERATURE_EPSILON
from alight.metrics.model import Metric, Pair
from alight.metrics.relmse import relmse


class RelMseLiterature(Metric):
    """Relative mean squared error with an epsilon of 0.01."""

    type: Literal["relmse_literature"] = "relmse_literature"


EXAMPLES = (RelMseLiterature(),)

LABEL = f"relMSE, ε = {LITERATURE_EPSILON:g}"


def evaluate(spec, pair: Pair) -> float:
    """`relmse` with this epsilon."""
    return relmse(pair.image, pair.reference, epsilon=LITERATURE_EPSILON)


def weight(spec, reference: np.ndarray) -> np.ndarray:
    """1 / (ref^2 + epsilon)."""
    return 1.0 / (reference**2 + np.float32(LITERATURE_EPSILON))
