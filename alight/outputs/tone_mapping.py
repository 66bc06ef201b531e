"""From scene light to a display: exposure, a tone curve, and the sRGB transfer function.

===========  =====================================================================================
``none``     clip at 1
``reinhard`` L / (1 + L) of the luminance, hue kept. Reinhard, Stark, Shirley and Ferwerda 2002,
             "Photographic tone reproduction for digital images", equation 3
``aces``     Narkowicz's fit of the ACES film curve, per channel. Narkowicz 2016, "ACES filmic tone
             mapping curve", knarkowicz.wordpress.com
``hable``    Hable's curve of "Uncharted 2", white at 11.2, per channel. Hable 2010, "Filmic
             tonemapping operators", filmicworlds.com
===========  =====================================================================================

Only display formats (PNG, JPEG) are tone mapped; EXR, HDR, PFM and NPY keep the scene's own values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from alight.core.errors import OptionError, unknown_name
from alight.core.srgb import encode_srgb

#: Luminance of linear sRGB (Rec. 709 primaries, D65).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def clip(rgb: np.ndarray) -> np.ndarray:
    """Keep the values themselves, cut at 1."""
    return np.minimum(rgb, 1.0)


def reinhard(rgb: np.ndarray) -> np.ndarray:
    """Luminance L becomes L / (1 + L); the ratios of the channels stay."""
    return rgb / (1.0 + (rgb @ LUMINANCE))[..., None]


def aces(rgb: np.ndarray) -> np.ndarray:
    """Narkowicz's rational fit of the ACES reference curve."""
    return (rgb * (2.51 * rgb + 0.03)) / (rgb * (2.43 * rgb + 0.59) + 0.14)


def hable(rgb: np.ndarray) -> np.ndarray:
    """Hable's curve, scaled so that 11.2 becomes white, after his exposure bias of 2."""

    def curve(x: np.ndarray) -> np.ndarray:
        shoulder, linear, angle, toe, numerator, denominator = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30
        top = x * (shoulder * x + angle * linear) + toe * numerator
        bottom = x * (shoulder * x + linear) + toe * denominator
        return top / bottom - numerator / denominator

    return curve(2.0 * rgb) / curve(np.array(11.2))


#: Tone curves by name: linear values >= 0 in, display-linear values out (cut to [0, 1] afterwards).
TONE_MAPS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "none": clip,
    "reinhard": reinhard,
    "aces": aces,
    "hable": hable,
}


@dataclass(frozen=True)
class Display:
    """How linear values become display values.

    Parameters
    ----------
    exposure : float, default 0
        Stops: values are multiplied by 2^exposure before the tone curve. In [-100, 100].
    tone_map : str, default "none"
        A key of `TONE_MAPS`.
    bits : int, default 8
        8, or 16 in PNG.

    Raises
    ------
    OptionError
        For an unknown tone map, an exposure out of range or another number of bits.
    """

    exposure: float = 0.0
    tone_map: str = "none"
    bits: int = 8

    def __post_init__(self) -> None:
        """Check the values."""
        if self.tone_map not in TONE_MAPS:
            raise OptionError(unknown_name("tone map", self.tone_map, TONE_MAPS))
        if not (math.isfinite(self.exposure) and abs(self.exposure) <= 100.0):
            raise OptionError(f"exposure must lie in [-100, 100] stops, got {self.exposure:g}")
        if self.bits not in (8, 16):
            raise OptionError(f"bits per channel must be 8 or 16, got {self.bits}")

    def apply(self, linear: np.ndarray) -> np.ndarray:
        """Encode as sRGB in [0, 1].

        Parameters
        ----------
        linear : ndarray, shape (h, w, 3)
            Negative values and NaN become black, infinity white.

        Returns
        -------
        ndarray of float64, shape (h, w, 3)
        """
        # The bound keeps the squares inside the curves finite; every curve is flat long before.
        bounded = np.nan_to_num(linear.astype(np.float64), nan=0.0, posinf=1e30, neginf=0.0)
        rgb = np.clip(bounded * 2.0**self.exposure, 0.0, 1e30)
        return encode_srgb(np.clip(TONE_MAPS[self.tone_map](rgb), 0.0, 1.0))
