r"""Reinhard's curve: compresses the luminance, keeps the hue.

.. math:: L_d = \frac{L}{1 + L}

Source: Reinhard, Stark, Shirley and Ferwerda 2002, "Photographic tone reproduction for digital
images", equation 3.
"""

from __future__ import annotations

from typing import Literal

from alight.core.constants import LUMINANCE
from alight.core.spec import ToneCurve


class Reinhard(ToneCurve):
    """Luminance L becomes L / (1 + L); the ratios of the channels stay."""

    type: Literal["reinhard"] = "reinhard"


EXAMPLES = (Reinhard(),)


def apply(spec, rgb):
    """Divide by 1 + L."""
    return rgb / (1.0 + (rgb @ LUMINANCE))[..., None]


def invert(spec, shown):
    """L = L_d / (1 - L_d)."""
    return shown / (1.0 - (shown @ LUMINANCE))[..., None]
