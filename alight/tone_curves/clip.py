"""Clipping: values are shown as they are, and nothing is brighter than white."""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.spec import ToneCurve


class Clip(ToneCurve):
    """No tone curve: pictures can be compared."""

    type: Literal["none"] = "none"


EXAMPLES = (Clip(),)


def apply(spec, rgb):
    """Keep the values themselves, cut at 1."""
    return np.minimum(rgb, 1.0)


def invert(spec, shown):
    """Below white, the values themselves."""
    return shown
