r"""What takes the place of pbrt's materials that alight has no model for.

Hair: a matte surface of the colour that light gets by going round between many hairs,

.. math:: c = \exp\bigl(-\sqrt{\sigma_a}\; q(\beta_n)\bigr)

with the polynomial q of Chiang et al. Measured surfaces: grey plastic, since their files are
tables that alight does not read.

Source: Chiang et al., A practical and controllable hair and fur model for production path tracing,
Computer Graphics Forum 35(2), 2016; PBR4 section 9.9.3 for the pigments.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.scene.formats.pbrt.context import Data
from alight.scene.formats.pbrt.materials import COVERED, Making, coat, two_sided

#: What a unit of the two pigments of hair absorbs, in one diameter.
_EUMELANIN, _PHEOMELANIN = (0.419, 0.697, 1.37), (0.187, 0.4, 1.05)
#: pbrt's amount of eumelanin where nothing is said, and its roughness around the hair.
_USUAL, _BETA_N = 1.3, 0.3
_MIDDLE = [0.3] * 3
_GREY, _GREY_ALPHA = [0.5] * 3, 0.3


def hair_color(absorbed: float, beta_n: float) -> float:
    """The colour of much hair whose light is absorbed by `absorbed` a diameter."""
    b = beta_n
    q = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return math.exp(-math.sqrt(max(absorbed, 0.0)) * q)


def _hair(m: Making) -> Data:
    p = m.p
    beta_n = m.plain_number("beta_n", _BETA_N)
    p.ignore("a matte surface is taken", "beta_m", "alpha", "eta")
    color = m.color("color" if p.has("color") else "reflectance", None)
    absorbed = m.color("sigma_a", None, "index")
    eumelanin = m.plain_number("eumelanin", 0.0)
    pheomelanin = m.plain_number("pheomelanin", 0.0)
    if color is None and not isinstance(absorbed, list):
        if not p.has("eumelanin") and not p.has("pheomelanin"):
            eumelanin = _USUAL
        pigments = zip(_EUMELANIN, _PHEOMELANIN, strict=True)
        absorbed = [eumelanin * e + pheomelanin * f for e, f in pigments]
    if color is None and isinstance(absorbed, list):
        color = [hair_color(channel, beta_n) for channel in absorbed]
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
