"""Structural dissimilarity of what a display shows: (1 - SSIM) / 2, see `ssim`."""

from __future__ import annotations

import math
from typing import Literal

from alight.core.constants import LUMINANCE
from alight.core.srgb import encode_srgb
from alight.metrics.model import Metric, Pair
from alight.metrics.ssim import SMALLEST, ssim


class Dssim(Metric):
    """Structural dissimilarity of the display's luminance, from 0 to 1."""

    type: Literal["dssim"] = "dssim"


EXAMPLES = (Dssim(),)

LABEL, BOUNDED, IN_STUDIES = "SSIM", True, False


def evaluate(spec, pair: Pair) -> float:
    """Of the encoded luminance; NaN of pictures that are smaller than the window."""
    if min(pair.image.shape[:2]) < SMALLEST:
        return math.nan
    seen = pair.shown()
    planes = (encode_srgb(one @ LUMINANCE) for one in (seen.image, seen.reference))
    return (1.0 - ssim(*planes)) / 2.0


def shown(value: float) -> float:
    """SSIM, which readers know."""
    return 1.0 - 2.0 * value
