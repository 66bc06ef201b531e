"""Metrics: how far two pictures are apart, and whether that is more than noise."""

from alight.metrics.comparison import Comparison, PictureStatistics, compare_pictures
from alight.metrics.relmse import ErrorEstimate, Estimate, relmse, relrmse
from alight.metrics.smape import smape

__all__ = [
    "Comparison",
    "ErrorEstimate",
    "Estimate",
    "PictureStatistics",
    "compare_pictures",
    "relmse",
    "relrmse",
    "smape",
]
