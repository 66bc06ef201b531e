"""Metrics: how much two pictures differ, one model per file; and whether that is more than noise.

A new metric is one file and one line here.
"""

from alight.metrics import (
    dssim,
    flip,
    relmse_literature,
    rmse,
)

# Underscored where a function of the same name is exported.
from alight.metrics import mse as _mse
from alight.metrics import relmse as _relmse
from alight.metrics import smape as _smape
from alight.metrics.agreement import Agreement, compare_measured
from alight.metrics.block_sums import Measured
from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from alight.metrics.error_estimate import ErrorEstimate
from alight.metrics.estimate import Estimate
from alight.metrics.mse import mse
from alight.metrics.relmse import relmse, relrmse
from alight.metrics.smape import smape
from alight.metrics.ssim import ssim

MODELS = (
    _mse,
    rmse,
    _relmse,
    relmse_literature,
    _smape,
    dssim,
    flip,
)

#: By which arms of studies are judged, since it has parts: bias and variance; and which is shown
#: where one figure must do.
JUDGED, SHOWN = _mse.EXAMPLES[0].type_name(), _relmse.EXAMPLES[0].type_name()

__all__ = [
    "Agreement",
    "Comparison",
    "ErrorEstimate",
    "Estimate",
    "Measured",
    "PictureStatistics",
    "compare_measured",
    "compare_pictures",
    "mse",
    "relmse",
    "relrmse",
    "smape",
    "ssim",
]
