"""Two pictures side by side in one: where, and how much, they differ."""

from __future__ import annotations

import numpy as np

from alight.metrics.flip import flip, is_available
from alight.view.layers import DARKEST

#: Ways to compare: a divider between both, their relative difference, what an eye sees of it.
DIVIDER, DIFFERENCE, FLIP = WAYS = ("divider", "difference", "flip")


def ways() -> tuple[str, ...]:
    """Those that this installation has: FLIP takes a package of its own."""
    return WAYS if is_available() else WAYS[:2]


def contrast(way: str, image: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, float]:
    """How a picture differs from another one.

    Parameters
    ----------
    way : {"difference", "flip"}
    image, other : ndarray, shape (h, w, 3)
        Linear sRGB.

    Returns
    -------
    plane : ndarray, shape (h, w, 1)
        Mean absolute difference of the channels over the other's mean, very dark pixels counted as
        a tenth of its picture's mean; or FLIP (`alight.metrics.flip`).
    mean : float
        The root of relMSE of the same kind, or the mean FLIP.
    """
    if way == FLIP:
        found = flip(image, other)
        return found.error[..., None], found.mean
    grey = np.maximum(other, 0.0).mean(axis=-1, keepdims=True)
    scale = np.maximum(grey, DARKEST * float(grey.mean()))
    off = np.abs(image.astype(np.float64) - other)
    share = np.divide(off, scale, out=np.full_like(off, np.nan), where=scale > 0.0)
    known = share[np.isfinite(share)]
    mean = float(np.sqrt(np.square(known).mean())) if known.size else 0.0
    return share.mean(axis=-1, keepdims=True), mean
