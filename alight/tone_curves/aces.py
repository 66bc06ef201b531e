r"""Narkowicz's fit of the ACES film curve, per channel.

.. math:: f(x) = \frac{x (2.51 x + 0.03)}{x (2.43 x + 0.59) + 0.14}

Source: Narkowicz 2016, "ACES filmic tone mapping curve", knarkowicz.wordpress.com.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.spec import ToneCurve


class Aces(ToneCurve):
    """Look of film, with strong contrast."""

    type: Literal["aces"] = "aces"


EXAMPLES = (Aces(),)


def apply(spec, rgb):
    """Narkowicz's rational fit of the ACES reference curve."""
    return (rgb * (2.51 * rgb + 0.03)) / (rgb * (2.43 * rgb + 0.59) + 0.14)


def invert(spec, shown):
    """The root >= 0 of (2.43 y - 2.51) x^2 + (0.59 y - 0.03) x + 0.14 y = 0."""
    a, b, c = 2.51 - 2.43 * shown, 0.03 - 0.59 * shown, 0.14 * shown
    return (np.sqrt(b * b + 4.0 * a * c) - b) / (2.0 * a)
