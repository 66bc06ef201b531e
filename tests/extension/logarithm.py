r"""A user's tone curve, one file: logarithmic compression of the luminance.

.. math:: L_d = \frac{\ln(1 + L / w)}{\ln(1 + 1 / w)}

A luminance of 1 becomes white, and the smaller `width` is, the more of the darkness is shown.

Source: Drago, Myszkowski, Annen and Chiba 2003, "Adaptive logarithmic mapping for displaying high
contrast scenes", equation 3, with one base.
"""

from typing import Literal

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.field_types import Positive
from alight.core.spec import ToneCurve


class Logarithm(ToneCurve):
    """Steps of brightness by ratios of luminance.

    Parameters
    ----------
    width : float > 0, default 0.1
        Luminance below which it is linear.
    """

    type: Literal["logarithm"] = "logarithm"
    width: Positive = 0.1


EXAMPLES = (Logarithm(), Logarithm(width=1e-3), Logarithm(width=10.0))


def apply(spec, rgb):
    """Compress the luminance, keep the hue."""
    light = (rgb @ LUMINANCE)[..., None]
    shown = np.log1p(light / spec.width) / np.log1p(1.0 / spec.width)
    return rgb * (shown / np.maximum(light, 1e-300))


def invert(spec, shown):
    """Expand it again."""
    dark = (shown @ LUMINANCE)[..., None]
    light = spec.width * np.expm1(dark * np.log1p(1.0 / spec.width))
    return shown * (light / np.maximum(dark, 1e-300))
