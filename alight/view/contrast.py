"""Two pictures side by side in one: where, and how much, they differ."""

from __future__ import annotations

import numpy as np

from alight.metrics.model import METRICS, Pair
from alight.view.layers import DARKEST

#: Ways to compare: a divider between both, their relative difference; then metrics with a map.
DIVIDER, DIFFERENCE = "divider", "difference"


def ways() -> tuple[str, ...]:
    """Those that this installation has: a metric may take a package of its own."""
    mapped = (n for n, one in METRICS.items() if one.error_map is not None and not one.missing())
    return (DIVIDER, DIFFERENCE, *mapped)


def label_of_way(way: str) -> str:
    """What the page calls it."""
    ours = {DIVIDER: "a divider", DIFFERENCE: "the difference"}
    return ours.get(way) or METRICS[way].LABEL


def waits(way: str) -> str:
    """Why a way has to wait until the picture rests; empty if it need not."""
    metric = METRICS.get(way)
    return f"{metric.LABEL} is worked out when the picture rests" if metric and metric.SLOW else ""


def contrast(way: str, image: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, float]:
    """How a picture differs from another one.

    Parameters
    ----------
    way : str
        One of `ways`, but for the divider.
    image, other : ndarray, shape (h, w, 3)
        Linear sRGB.

    Returns
    -------
    plane : ndarray, shape (h, w, 1)
        Mean absolute difference of the channels over the other's mean, very dark pixels counted as
        a tenth of its picture's mean; or the map of a metric.
    mean : float
        The root of relMSE of the same kind, or the metric.
    """
    if way != DIFFERENCE:
        metric, pair = METRICS[way], Pair(image, other)
        assert metric.error_map is not None
        plane = metric.error_map(metric.example, pair)
        return plane[..., None], float(plane.mean(dtype=np.float64))
    grey = np.maximum(other, 0.0).mean(axis=-1, keepdims=True)
    scale = np.maximum(grey, DARKEST * float(grey.mean()))
    off = np.abs(image.astype(np.float64) - other)
    share = np.divide(off, scale, out=np.full_like(off, np.nan), where=scale > 0.0)
    known = share[np.isfinite(share)]
    mean = float(np.sqrt(np.square(known).mean())) if known.size else 0.0
    return share.mean(axis=-1, keepdims=True), mean
