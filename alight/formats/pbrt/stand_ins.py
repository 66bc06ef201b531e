"""What takes the place of pbrt's materials that alight has no model for.

Hair: a matte surface of the colour that light gets by going round between many hairs. Measured
surfaces: grey plastic, since their files are tables that alight does not read.
"""

from __future__ import annotations

from collections.abc import Callable

from alight.formats import hair
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.making import Making
from alight.formats.pbrt.materials import coat
from alight.formats.surfaces import two_sided

_MIDDLE = [0.3] * 3
_GREY, _GREY_ALPHA = [0.5] * 3, 0.3


def _hair(m: Making) -> Data:
    p = m.p
    beta_n = _hairy(m, "beta_n", hair.USUAL_BETA_N, 1.0)
    p.ignore("a matte surface is taken", "beta_m", "alpha", "eta")
    color = m.color("color" if p.has("color") else "reflectance", None)
    absorbed = m.color("sigma_a", None, "index")
    if isinstance(absorbed, str):
        p.report.warn(p.named["sigma_a"], "is a texture: the usual hair is taken")
    elif isinstance(absorbed, list) and min(absorbed) < 0.0:
        p.report.error(p.named["sigma_a"], "must be >= 0 in each channel")
    eumelanin = _hairy(m, "eumelanin", 0.0, hair.MOST)
    pheomelanin = _hairy(m, "pheomelanin", 0.0, hair.MOST)
    if color is None and not isinstance(absorbed, list):
        if not p.has("eumelanin") and not p.has("pheomelanin"):
            eumelanin = hair.USUAL_EUMELANIN
        absorbed = hair.absorption(eumelanin, pheomelanin)
    if color is None and isinstance(absorbed, list):
        color = hair.color(absorbed, beta_n)
    m.warn("is not covered: a matte surface of the colour of much such hair is taken")
    return two_sided({"type": "diffuse", "reflectance": color or _MIDDLE})


def _hairy(m: Making, name: str, default: float, most: float) -> float:
    """A parameter of hair, which lies between 0 and `most`."""
    found = m.plain_number(name, default)
    if 0.0 <= found <= most:
        return found
    m.p.report.error(m.p.named[name], f"must be in [0, {most:g}], got {found:g}")
    return default


def _measured(m: Making) -> Data:
    m.p.leave_out("tables of measurements are not read", "filename", "bsdffile")
    m.warn("is not covered: grey plastic is taken")
    return two_sided(coat(m, _GREY_ALPHA, _GREY, 1.5, None))


STAND_INS: dict[str, Callable[[Making], Data]] = {
    "fourier": _measured,
    "hair": _hair,
    "measured": _measured,
}
#: Those of pbrt 3 alone.
ONLY_IN_3 = ("fourier",)
