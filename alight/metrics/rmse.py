"""Root of the mean squared error, in units of radiance."""

from __future__ import annotations

import math
from typing import Literal

from alight.metrics.model import Metric, Pair
from alight.metrics.mse import mse


class Rmse(Metric):
    """Root of the mean squared error."""

    type: Literal["rmse"] = "rmse"


EXAMPLES = (Rmse(),)

LABEL, IN_STUDIES = "RMSE", False


def evaluate(spec, pair: Pair) -> float:
    """Root of `mse`."""
    return math.sqrt(mse(pair.image, pair.reference))
