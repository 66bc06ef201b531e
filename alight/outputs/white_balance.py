r"""White balance: the colour of the light that should look white.

The eye takes the colour of the light around it for white; a screen's white is D65. A picture lit by
a lamp of 2 800 K is therefore adapted: the lamp's white goes to D65 and everything else with it, by
von Kries' rule in the cone space of Bradford:

.. math:: x' = M^{-1}\,\operatorname{diag}(M w_{D65} / M w)\,M\,x

Sources: Lam 1985, "Metamerism and colour constancy" (the Bradford transform, as in CIE 97s and ICC
profiles); Krystek 1985, "An algorithm to calculate correlated colour temperature" (the white of a
black body); Buchsbaum 1980, "A spatial processor model for object colour perception" (grey world).
"""

from __future__ import annotations

import math
import re

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import OptionError, quote

#: XYZ from linear sRGB, IEC 61966-2-1.
XYZ_FROM_RGB = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
_CONES_FROM_XYZ = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
_CONES_FROM_RGB = _CONES_FROM_XYZ @ XYZ_FROM_RGB

#: Kelvin; where Krystek's approximation holds.
COOLEST, HOTTEST = 1000.0, 15000.0

_HELP = (
    "must be none, auto, a temperature in [1000K, 15000K] as 3200K, or the light's colour as "
    "R,G,B in linear sRGB"
)


def parse_white(text: str) -> np.ndarray | str | None:
    """Read which light is to look white.

    Parameters
    ----------
    text : str
        ``none``, ``auto``, a temperature as ``3200K``, or a colour as ``1,0.8,0.6``.

    Returns
    -------
    ndarray of float64, shape (3,), "auto", or None
        Linear sRGB of any brightness; None: no adaptation.

    Raises
    ------
    OptionError
        For anything else.
    """
    text = str(text).strip().lower()
    if text == "none":
        return None
    if text == "auto":
        return text
    if found := re.fullmatch(r"(\d{1,9}(?:\.\d{0,9})?)\s*k", text):
        if COOLEST <= float(found[1]) <= HOTTEST:
            return black_body_white(float(found[1]))
    elif text.count(",") == 2:
        try:
            color = np.array([float(part) for part in text.split(",")])
        except ValueError:
            color = np.full(3, math.nan)
        # Bright enough to be divided by, in cone space too.
        if np.isfinite(color).all() and (color >= 0.0).all():
            cones = _CONES_FROM_RGB @ color
            if cones.min() > 1e-3 * cones.max():
                return color
    raise OptionError(f"white balance {_HELP}; got {quote(text)}")


def black_body_white(temperature: float) -> np.ndarray:
    """Colour of a black body, of luminance 1.

    Parameters
    ----------
    temperature : float
        Kelvin, in [1000, 15000]; the chromaticity is within 0.0001 in u and v (Krystek 1985).

    Returns
    -------
    ndarray of float64, shape (3,)
        Linear sRGB; a channel is negative where the colour lies outside sRGB (below 1900 K).
    """
    t = temperature
    u = (0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) / (
        1.0 + 8.42420235e-4 * t + 7.08145163e-7 * t * t
    )
    v = (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) / (
        1.0 - 2.89741816e-5 * t + 1.61456053e-7 * t * t
    )
    # From CIE 1960 uv to xy, then to XYZ of Y = 1.
    x, y = 3.0 * u / (2.0 * u - 8.0 * v + 4.0), 2.0 * v / (2.0 * u - 8.0 * v + 4.0)
    return np.linalg.solve(XYZ_FROM_RGB, np.array([x / y, 1.0, (1.0 - x - y) / y]))


def adaptation(white: np.ndarray) -> np.ndarray:
    """Matrix that makes a light of this colour neutral, its luminance kept.

    Parameters
    ----------
    white : ndarray of float64, shape (3,)
        Linear sRGB.

    Returns
    -------
    ndarray of float64, shape (3, 3)
        For column vectors of linear sRGB; the identity for a neutral colour.
    """
    luminance = np.dot(LUMINANCE, white)
    gains = (_CONES_FROM_RGB @ np.ones(3)) * luminance / (_CONES_FROM_RGB @ white)
    return np.linalg.solve(_CONES_FROM_RGB, gains[:, None] * _CONES_FROM_RGB)


def grey_world(linear: np.ndarray) -> np.ndarray | None:
    """Guess the colour of the light: the mean colour of the picture.

    Right where the things in it are grey on average; a picture of a lawn becomes too red.

    Parameters
    ----------
    linear : ndarray, shape (h, w, 3)
        Finite values >= 0.

    Returns
    -------
    ndarray of float64, shape (3,), or None
        None for a picture without light, or of one pure colour.
    """
    mean = linear.reshape(-1, 3).mean(axis=0, dtype=np.float64)
    cones = _CONES_FROM_RGB @ mean
    return mean if cones.min() > 1e-3 * cones.max() else None
