"""Primaries of pictures that are not those of sRGB.

Sources: OpenEXR's standard attribute ``chromaticities``, which is that of Rec. 709 where it is
missing; SMPTE ST 2065-1:2021 and the ACES document S-2014-004 for AP0 and AP1; ITU-R BT.2020-2;
SMPTE EG 432-1:2010 for P3.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from alight.outputs import exr

#: x and y of red, green, blue; the white is not looked at.
_KNOWN = {
    "sRGB": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06),
    "ACES2065-1": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770),
    "ACEScg": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044),
    "Rec. 2020": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046),
    "P3": (0.680, 0.320, 0.265, 0.690, 0.150, 0.060),
}

#: Files round to three digits.
_CLOSE = 2e-3


def foreign_primaries(path: Path) -> str:
    """The name or the numbers of an OpenEXR file's primaries; empty for sRGB, and if not said."""
    try:
        said = exr.read_header(path).get("chromaticities")
        values = np.asarray(said, np.float64)[:6] if said is not None else None
    except (OSError, TypeError, ValueError):
        # Who reads the pixels tells of files that are broken.
        return ""
    if values is None or values.shape != (6,):
        return ""
    for name, known in _KNOWN.items():
        if np.abs(values - known).max() < _CLOSE:
            return "" if name == "sRGB" else name
    return "xy " + ", ".join(f"{x:.3g} {y:.3g}" for x, y in values.reshape(3, 2))
