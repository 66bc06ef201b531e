"""What a display takes from the file of a tone curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.registry import Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class ToneCurveModel(Record):
    """A tone curve.

    Attributes
    ----------
    apply : (spec, (..., 3) float64) -> (..., 3) float64
        Linear sRGB of a display from that of the scene, in [0, 1e30]; what leaves [0, 1] is cut
        afterwards.
    invert : (spec, (..., 3) float64) -> (..., 3) float64
        Its inverse, where one is known.
    """

    apply: Callable[[Any, np.ndarray], np.ndarray]
    invert: Callable[[Any, np.ndarray], np.ndarray] | None = None


#: All tone curves, by name.
TONE_CURVES = Records("tone_curves", ToneCurveModel)
