"""Metrics: how much two pictures differ, and whether that is more than noise."""

from alight.metrics.agreement import Agreement, compare_measured
from alight.metrics.block_sums import Measured
from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from alight.metrics.error_estimate import ErrorEstimate
from alight.metrics.mse import mse
from alight.metrics.relmse import Estimate, relmse, relrmse
from alight.metrics.smape import smape
from alight.metrics.ssim import ssim

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
