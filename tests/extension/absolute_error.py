"""A user's metric, one file: the mean absolute error, with a map."""

from typing import Literal

import numpy as np

from alight.metrics.model import Metric


class AbsoluteError(Metric):
    """Mean absolute difference of the channels."""

    type: Literal["absolute_error"] = "absolute_error"


EXAMPLES = (AbsoluteError(),)

LABEL = "Absolute error"


def error_map(spec, pair):
    """Mean over the channels."""
    return np.abs(pair.image - pair.reference).mean(axis=-1)


def evaluate(spec, pair):
    """Mean over the pixels."""
    return float(error_map(spec, pair).mean(dtype=np.float64))
