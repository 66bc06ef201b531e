"""Tone curves: from unbounded scene light to what a display can show.

===========  =====================================================================================
``none``     clip at 1
``reinhard`` L / (1 + L) of the luminance, hue kept. Reinhard, Stark, Shirley and Ferwerda 2002,
             "Photographic tone reproduction for digital images", equation 3
``aces``     Narkowicz's fit of the ACES film curve, per channel. Narkowicz 2016, "ACES filmic tone
             mapping curve", knarkowicz.wordpress.com
``hable``    Hable's curve of "Uncharted 2", white at 11.2, per channel. Hable 2010, "Filmic
             tonemapping operators", filmicworlds.com
``agx``      Sobotka's AgX: bright colours turn paler, as on film, instead of clipping to pure red
             or yellow. Sobotka 2022, github.com/sobotka/AgX; the curve by the polynomial of
             Wrensch 2023, "Minimal AgX implementation", iolite-engine.com
===========  =====================================================================================
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.core.constants import LUMINANCE


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


#: AgX: mixes the channels so that none stays alone, and back (rows act on column vectors).
_AGX_INSET = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
_AGX_OUTSET = np.linalg.inv(_AGX_INSET)

#: AgX: stops, log2 of the linear value, that become 0 and 1.
_AGX_DARKEST, _AGX_BRIGHTEST = -12.47393, 4.026069

#: AgX: the sigmoid over these stops, highest power first.
_AGX_CURVE = np.array([15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232])


def agx(rgb: np.ndarray) -> np.ndarray:
    """Sobotka's AgX without a look; its curve ends in display values of gamma 2.2."""
    stops = np.log2(np.maximum(rgb @ _AGX_INSET.T, 2.0**_AGX_DARKEST))
    position = np.clip((stops - _AGX_DARKEST) / (_AGX_BRIGHTEST - _AGX_DARKEST), 0.0, 1.0)
    display = np.polyval(_AGX_CURVE, position) @ _AGX_OUTSET.T
    return np.maximum(display, 0.0) ** 2.2


#: Tone curves by name: linear values >= 0 in, display-linear values out (cut to [0, 1] afterwards).
TONE_MAPS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "none": clip,
    "reinhard": reinhard,
    "aces": aces,
    "hable": hable,
    "agx": agx,
}
