"""What takes the place of pbrt's materials that alight has no model for.

Hair whose colour is a texture: a matte surface of that colour. Measured
surfaces: grey plastic, since their files are tables that alight does not read.
"""

from __future__ import annotations

from collections.abc import Callable

from alight.formats.materials import hair
from alight.formats.materials.surfaces import LARGEST_IOR, two_sided
from alight.formats.pbrt.below import BELOW
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.making import Making
from alight.formats.pbrt.materials import coat

_GREY, _GREY_ALPHA = [0.5] * 3, 0.3


def _hair(m: Making) -> Data:
    p = m.p
    data: Data = {
        "type": "hair",
        "beta_m": hair.roughness(_hairy(m, "beta_m", hair.BETA, 1.0)),
        "beta_n": hair.roughness(_hairy(m, "beta_n", hair.BETA, 1.0)),
        "alpha": _hairy(m, "alpha", hair.TILT, hair.MOST_TILT),
        "ior": min(max(m.plain_number("eta", 1.55), 1.0), LARGEST_IOR),
    }
    absorbed = m.color("sigma_a", None, "index")
    color = m.color("color" if p.has("color") else "reflectance", None)
    pigments = {n: _hairy(m, n, 0.0, hair.MOST) for n in ("eumelanin", "pheomelanin") if p.has(n)}
    if isinstance(absorbed, str):
        p.report.warn(p.named["sigma_a"], "is a texture: the usual hair is taken")
    elif isinstance(absorbed, list):
        if min(absorbed) < 0.0:
            p.report.error(p.named["sigma_a"], "must be >= 0 in each channel")
        return data | {"sigma_a": absorbed}
    if isinstance(color, str):
        m.warn("has a textured colour: a matte surface of that colour is taken")
        return two_sided({"type": "diffuse", "reflectance": color})
    if isinstance(color, list):
        return data | {"color": [min(max(channel, hair.LEAST_COLOR), 1.0) for channel in color]}
    return data | pigments


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
    **BELOW,
}
#: Those of pbrt 3 alone.
ONLY_IN_3 = ("fourier",)
