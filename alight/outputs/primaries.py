"""Primaries of pictures that are not those of sRGB.

Sources: OpenEXR's standard attribute ``chromaticities``, which is that of Rec. 709 where it is
missing; SMPTE ST 2065-1:2021 and the ACES document S-2014-004 for AP0 and AP1; ITU-R BT.2020-2;
SMPTE EG 432-1:2010 for P3. Lam 1985, Metamerism and colour constancy, for Bradford's adaptation.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.outputs import exr

#: x and y of red, green, blue.
_KNOWN = {
    "sRGB": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06),
    "ACES2065-1": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770),
    "ACEScg": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044),
    "Rec. 2020": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046),
    "P3": (0.680, 0.320, 0.265, 0.690, 0.150, 0.060),
}
_D65 = (0.3127, 0.3290)
#: Responses of the eye by which one white becomes another.
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)

#: Entries of a matrix are a few ones; of primaries on nearly one line they are large.
_LARGEST = 100.0
#: Files round to three digits.
_CLOSE = 2e-3


class Primaries(NamedTuple):
    """Colours that the numbers of a picture are amounts of.

    Attributes
    ----------
    name : str
        Of a known space, with its white where that is another one, or the numbers.
    to_srgb : (3, 3) float64, optional
        To linear sRGB, white to white; None where the primaries span no space.
    """

    name: str
    to_srgb: NDArray[np.float64] | None


def foreign_primaries(path: Path) -> Primaries | None:
    """The primaries of an OpenEXR file; None for sRGB with its own white, and without any."""
    try:
        said = exr.read_header(path).get("chromaticities")
        values = np.asarray(said, np.float64).ravel() if said is not None else None
    except (OSError, TypeError, ValueError):
        # Reading the pixels reports broken files.
        return None
    if values is None or values.size < 6:
        return None
    white = tuple(values[6:8]) if values.size >= 8 else _D65
    for name, known in _KNOWN.items():
        if np.abs(values[:6] - known).max() < _CLOSE:
            if name != "sRGB":
                return Primaries(name, _to_srgb(values[:6], white))
            if np.abs(np.subtract(white, _D65)).max() < _CLOSE:
                return None
            said = f"sRGB with the white xy {white[0]:.3g} {white[1]:.3g}"
            return Primaries(said, _to_srgb(values[:6], white))
    name = "xy " + ", ".join(f"{x:.3g} {y:.3g}" for x, y in values[:6].reshape(3, 2))
    return Primaries(name, _to_srgb(values[:6], white))


def _to_srgb(
    primaries: NDArray[np.float64], white: tuple[float, ...]
) -> NDArray[np.float64] | None:
    with np.errstate(all="ignore"):
        try:
            file = _to_xyz(primaries, white)
        except np.linalg.LinAlgError:
            return None
        ratio = _BRADFORD @ _xyz(*_D65) / (_BRADFORD @ _xyz(*white))
        adapted = np.linalg.inv(_BRADFORD) @ np.diag(ratio) @ _BRADFORD
        found = np.linalg.inv(_to_xyz(np.array(_KNOWN["sRGB"]), _D65)) @ adapted @ file
    return found if np.abs(found).max() < _LARGEST else None


def _xyz(x: float, y: float) -> NDArray[np.float64]:
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


def _to_xyz(primaries: NDArray[np.float64], white: tuple[float, ...]) -> NDArray[np.float64]:
    """The matrix from linear RGB: primaries so bright that they add up to white."""
    columns = np.stack([_xyz(x, y) for x, y in primaries.reshape(3, 2)], axis=1)
    return columns * np.linalg.solve(columns, _xyz(*white))
