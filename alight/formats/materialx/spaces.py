"""Colour spaces of MaterialX -> linear Rec. 709.

Source: MaterialX specification 1.39, "Color spaces and color management systems"; primaries of
ACES AP1 (S-2014-004), Adobe RGB (1998) and Display P3 (SMPTE EG 432-1), adapted to D65 by
Bradford's matrix, as the library cmlib has them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from alight.core.srgb import decode_srgb

Rows = NDArray[np.float64]
#: Name -> how alight reads such a picture, or the key of `_CONVERSIONS`.
SPACES: dict[str, str] = {
    "": "linear", "auto": "auto", "data": "linear", "lin_rec709": "linear", "lin_rec709_scene":
    "linear", "lin_srgb": "linear", "linear": "linear", "none": "linear", "raw": "linear",
    "Raw": "linear", "sRGB": "srgb", "srgb": "srgb", "srgb_rec709_scene": "srgb",
    "srgb_texture": "srgb", "sRGB - Texture": "srgb", "Utility - sRGB - Texture": "srgb",
    "ACEScg": "lin_ap1", "acescg": "lin_ap1", "adobergb": "adobergb", "g18_rec709": "g18_rec709",
    "g22_ap1": "g22_ap1", "g22_rec709": "g22_rec709", "lin_adobergb": "lin_adobergb",
    "lin_ap1": "lin_ap1", "lin_ap1_scene": "lin_ap1", "lin_displayp3": "lin_displayp3",
    "rec709_display": "g24_rec709", "srgb_displayp3": "srgb_displayp3",
}  # fmt: skip
_AP1 = np.array([
    [1.705050993, -0.621792121, -0.083258872],
    [-0.130256418, 1.140804737, -0.010548319],
    [-0.024003357, -0.128968976, 1.152972333],
])  # fmt: skip
_ADOBE = np.array([
    [1.39835574, -0.39835574, 0.0], [0.0, 1.0, 0.0], [0.0, -0.0429289893, 1.0429289893],
])  # fmt: skip
_P3 = np.array([
    [1.2249401763, -0.2249401763, 0.0], [-0.0420569547, 1.0420569547, 0.0],
    [-0.0196375546, -0.0786360456, 1.0982736001],
])  # fmt: skip


def _gamma(exponent: float) -> Callable[[Rows], Rows]:
    return lambda x: np.maximum(x, 0.0) ** exponent


def _srgb(x: Rows) -> Rows:
    return np.asarray(decode_srgb(np.maximum(x, 0.0)), np.float64)


def _same(x: Rows) -> Rows:
    return x


#: Space -> its curve, and the matrix of its primaries.
_CONVERSIONS: dict[str, tuple[Callable[[Rows], Rows], Rows]] = {
    "adobergb": (_gamma(563.0 / 256.0), _ADOBE),
    "g18_rec709": (_gamma(1.8), np.eye(3)),
    "g22_ap1": (_gamma(2.2), _AP1),
    "g22_rec709": (_gamma(2.2), np.eye(3)),
    "g24_rec709": (_gamma(2.4), np.eye(3)),
    "lin_adobergb": (_same, _ADOBE),
    "lin_ap1": (_same, _AP1),
    "lin_displayp3": (_same, _P3),
    "srgb": (_srgb, np.eye(3)),
    "srgb_displayp3": (_srgb, _P3),
}


def to_linear(colors: Rows, space: str) -> Rows:
    """Linear Rec. 709 of colours (n, 3) in a space of `SPACES`; what lies outside of it is cut."""
    name = SPACES.get(space, space)
    if name not in _CONVERSIONS:
        return colors
    curve, matrix = _CONVERSIONS[name]
    return np.maximum(curve(colors[:, :3]) @ matrix.T, 0.0)
