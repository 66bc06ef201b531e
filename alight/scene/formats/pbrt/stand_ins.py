"""What takes the place of pbrt's materials that alight has no model for.

Hair: a matte surface of the colour that light gets by going round between many hairs. Measured
surfaces: grey plastic, since their files are tables that alight does not read.
"""

from __future__ import annotations

from collections.abc import Callable

from alight.scene.formats import hair
from alight.scene.formats.pbrt.context import Data
from alight.scene.formats.pbrt.materials import COVERED, Making, coat, two_sided

_MIDDLE = [0.3] * 3
_GREY, _GREY_ALPHA = [0.5] * 3, 0.3


def _hair(m: Making) -> Data:
    p = m.p
    beta_n = m.plain_number("beta_n", hair.USUAL_BETA_N)
    p.ignore("a matte surface is taken", "beta_m", "alpha", "eta")
    color = m.color("color" if p.has("color") else "reflectance", None)
    absorbed = m.color("sigma_a", None, "index")
    eumelanin = m.plain_number("eumelanin", 0.0)
    pheomelanin = m.plain_number("pheomelanin", 0.0)
    if color is None and not isinstance(absorbed, list):
        if not p.has("eumelanin") and not p.has("pheomelanin"):
            eumelanin = hair.USUAL_EUMELANIN
        absorbed = hair.absorption(eumelanin, pheomelanin)
    if color is None and isinstance(absorbed, list):
        color = hair.color(absorbed, beta_n)
    m.warn("is not covered: a matte surface of the colour of much such hair is taken")
    return two_sided({"type": "diffuse", "reflectance": color or _MIDDLE})


def _measured(m: Making) -> Data:
    m.p.leave_out("tables of measurements are not read", "filename", "bsdffile")
    m.warn("is not covered: grey plastic is taken")
    return two_sided(coat(m, _GREY_ALPHA, _GREY, 1.5, None))


STAND_INS: dict[str, Callable[[Making], Data]] = {
    "fourier": _measured,
    "hair": _hair,
    "measured": _measured,
}
COVERED |= STAND_INS
#: Those of pbrt 3 alone.
ONLY_IN_3 = ("fourier",)
