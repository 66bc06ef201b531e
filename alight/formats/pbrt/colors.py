"""Parameters that are colours: RGB, temperatures, spectra of every kind -> linear sRGB.

pbrt 4 renders with spectra and shows them as seen by the CIE's observer; a light given as RGB
shines as D65 of that colour, so that 1 1 1 is white, and any other spectrum of a light is scaled to
the luminance 1 before ``scale`` or ``power`` count. Spectra of surfaces are reduced as seen in
daylight (see `alight.core.spectra`). pbrt 3 renders in RGB and scales nothing, but
the largest value of a ``blackbody`` to 1.
"""

from __future__ import annotations

import numpy as np

from alight.core.errors import unknown_name
from alight.core.spectra import TO_SRGB, blackbody, to_linear_srgb
from alight.formats.materials.colors import (
    Color,
    ColorReader,
    NoColorError,
    Pairs,
    Role,
    pairs_of,
    reduced,
)
from alight.formats.materials.metals import METALS
from alight.formats.pbrt.directives import Parameter
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report

KINDS = ("rgb", "spectrum", "blackbody", "xyz")

#: Indices of refraction of glasses at 587.6 nm (catalogue of Schott).
GLASSES = {
    "glass-BK7": 1.5168, "glass-BAF10": 1.6700, "glass-FK51A": 1.4866, "glass-LASF9": 1.8503,
    "glass-SF5": 1.6727, "glass-SF10": 1.7283, "glass-SF11": 1.7847,
    "glass-F5": 1.6727, "glass-F10": 1.7283, "glass-F11": 1.7847,
}  # fmt: skip
#: The same with dispersion, by our names (`alight.bsdfs.dielectrics.dispersion`).
DISPERSION = {
    "glass-BK7": "bk7", "glass-BAF10": "baf10", "glass-FK51A": "fk51a", "glass-LASF9": "lasf9",
    "glass-SF5": "sf5", "glass-SF10": "sf10", "glass-SF11": "sf11",
    "glass-F5": "sf5", "glass-F10": "sf10", "glass-F11": "sf11",
}  # fmt: skip
#: Metals by pbrt's names; brass is Querry's, reduced likewise.
_BRASS = ([0.444, 0.527, 1.094], [3.695, 2.765, 1.829])
_CONDUCTORS = {name: METALS[name] for name in ("Ag", "Al", "Au", "Cu", "MgO", "TiO2")}
_CONDUCTORS["CuZn"] = _BRASS
INDICES: dict[str, Color] = {
    f"metal-{name}-{part}": pair[i]
    for name, pair in _CONDUCTORS.items()
    for i, part in enumerate(("eta", "k"))
} | {name: [index] * 3 for name, index in GLASSES.items()}
#: Chromaticities of illuminants for the observer of 1931. Source: CIE 15:2004, tables T.3 and T.8;
#: of ACES: SMPTE ST 2065-1.
_LAMPS = {
    "stdillum-A": (0.44758, 0.40745), "stdillum-D50": (0.34567, 0.35851),
    "stdillum-D65": (0.31272, 0.32903), "illum-acesD60": (0.32168, 0.33767),
    "stdillum-F1": (0.3131, 0.3371), "stdillum-F2": (0.3721, 0.3751),
    "stdillum-F3": (0.4091, 0.3941), "stdillum-F4": (0.4402, 0.4031),
    "stdillum-F5": (0.3138, 0.3452), "stdillum-F6": (0.3779, 0.3882),
    "stdillum-F7": (0.3129, 0.3292), "stdillum-F8": (0.3458, 0.3586),
    "stdillum-F9": (0.3741, 0.3727), "stdillum-F10": (0.3458, 0.3588),
    "stdillum-F11": (0.3805, 0.3769), "stdillum-F12": (0.4370, 0.4042),
}  # fmt: skip

# From the primaries of a colour space to those of sRGB, white kept (Bradford from ACES' white).
_SPACES = {
    "srgb": np.eye(3),
    "rec2020": np.array(
        [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
    ),
    "dci-p3": np.array(
        [[1.2249, -0.2247, -0.0002], [-0.0420, 1.0419, 0.0001], [-0.0196, -0.0786, 1.0982]]
    ),
    "aces2065-1": np.array(
        [[2.5217, -1.1341, -0.3876], [-0.2765, 1.3727, -0.0962], [-0.0154, -0.1530, 1.1684]]
    ),
}
SPACES = tuple(_SPACES)


class Colors(ColorReader[Parameter]):
    """Reads colours.

    Parameters
    ----------
    report : Report
    reach : Reach
        Finds files with spectra.

    Attributes
    ----------
    space : str
        Of RGB values, one of `SPACES`.
    old : bool
        Whether the scene is one of pbrt 3.
    """

    def __init__(self, report: Report, reach: Reach) -> None:
        super().__init__(report, reach)
        self.space = "srgb"
        self.old = False

    def _read(self, item: Parameter, role: Role) -> Color:
        values, kind = item.values, item.kind
        if kind in ("rgb", "xyz"):
            if len(values) != 3:
                raise NoColorError(f"must hold 3 numbers, got {len(values)}")
            matrix = TO_SRGB if kind == "xyz" else _SPACES[self.space]
            # Colours that sRGB cannot show lose what is negative, here as in spectra.
            found = (matrix @ values).tolist()
            return found if min(values) < 0.0 else [max(0.0, channel) for channel in found]
        if kind == "float" and len(values) == 1:
            return [float(values[0])] * 3
        if kind == "blackbody":
            return self._hot(values)
        if kind != "spectrum":
            raise NoColorError(f"must be a colour (rgb, spectrum, blackbody), got {kind}")
        return self._spectrum(item, role)

    def _hot(self, values: np.ndarray) -> Color:
        if not 1 <= len(values) <= 2:
            text = "must hold a temperature in K (and in pbrt 3 a scale)"
            raise NoColorError(f"{text}, got {len(values)} numbers")
        if not 100.0 <= values[0] <= 1e6:
            raise NoColorError(f"temperature must be in [100, 1e+06] K, got {values[0]:g}")
        wavelengths, radiance = blackbody(float(values[0]))
        if self.old:
            scale = float(values[1]) if len(values) == 2 else 1.0
            return to_linear_srgb(wavelengths, scale * radiance / radiance.max(), shines=True)
        return _of_luminance_one((wavelengths, radiance))

    def _spectrum(self, parameter: Parameter, role: Role) -> Color:
        if not parameter.is_text:
            return self._reduced(parameter, pairs_of(np.asarray(parameter.values)), role)
        if len(parameter.values) != 1:
            raise NoColorError(f"must name one spectrum, got {len(parameter.values)}")
        name = parameter.values[0]
        if name in INDICES and role != "light":
            return list(INDICES[name])
        if name in _LAMPS and role == "light":
            x, y = _LAMPS[name]
            # White is D65: exactly, not to five digits.
            white = name == "stdillum-D65"
            return [1.0] * 3 if white else (TO_SRGB @ [x / y, 1.0, (1.0 - x - y) / y]).tolist()
        if name in INDICES or name in _LAMPS or "." not in name:
            known = _LAMPS if role == "light" else INDICES
            raise NoColorError(unknown_name("spectrum", name, known, listed_as="spectra"))
        return self._reduced(parameter, self._pairs_of_file(name), role)

    def _reduced(self, parameter: Parameter, pairs: Pairs, role: Role) -> Color:
        if not self.old:  # pbrt 3 reduces spectra as well.
            self._tell_error(parameter, pairs, role)
        if role == "light" and not self.old:
            return _of_luminance_one(pairs)
        return reduced(pairs, role)


def _of_luminance_one(pairs: Pairs) -> Color:
    color = to_linear_srgb(*pairs, shines=True)
    luminance = float(np.linalg.inv(TO_SRGB)[1] @ color)
    return [channel / luminance for channel in color] if luminance > 0.0 else [0.0] * 3
