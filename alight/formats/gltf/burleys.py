r"""Burley's materials as `principled`.

Colour, metal, glass, roughness and index have the same meaning in both. Burley's coat of strength c
reflects c/4 of what a coat of glTF does, and its lobe has the alpha of its gloss g,
:math:`0.1 + g\,(0.001 - 0.1)`; stretched facets have :math:`\alpha / a` and :math:`\alpha\, a` with
:math:`a = \sqrt{1 - 0.9\, \text{anisotropic}}`; his glass takes the root of the colour at each of
its two sides, glTF's the colour.

Source: Burley 2012 and 2015, Physically Based Shading at Disney; KHR_materials_anisotropy.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from alight.bsdfs.disney.burley import Burley
from alight.bsdfs.disney.burley_thin import BurleyThin
from alight.bsdfs.disney.principled import Principled
from alight.core.spec import Texture


def burley_as_principled(bsdf: Burley | BurleyThin, lost: list[str]) -> Principled:
    """The nearest `principled`.

    Parameters
    ----------
    bsdf : Burley or BurleyThin
    lost : list of str
        Takes what differs.
    """
    kind, fields = bsdf.type_name(), dict(bsdf)
    lost.append(f"{kind}: what is reflected on top is taken from what is below, rims are darker")
    more = ("spec_tint", "flatness", "through")
    lost.extend(f"{kind}: its {name}" for name in more if fields.get(name, 0.0) != 0.0)
    return Principled(
        base_color=_color(fields, kind, lost),
        metallic=fields.get("metallic", 0.0),
        transmission=fields["spec_trans"],
        thin=isinstance(bsdf, BurleyThin),
        ior=fields["ior"],
        **_facets(fields, kind, lost),
        **_coat(fields, kind, lost),
        **_sheen(fields, kind, lost),
    )


def _color(fields: dict[str, Any], kind: str, lost: list[str]) -> Any:
    """The colour; where all is glass, its root."""
    color, share = fields["base_color"], fields["spec_trans"]
    if share == 1.0 and fields.get("metallic", 0.0) == 0.0 and not isinstance(color, Texture):
        return tuple(math.sqrt(channel) for channel in color)
    if share != 0.0:
        lost.append(f"{kind}: its glass takes the whole colour at each side, not the root")
    return color


def _facets(fields: dict[str, Any], kind: str, lost: list[str]) -> dict[str, Any]:
    rough, stretched = fields["roughness"], fields["anisotropic"]
    if stretched == 0.0:
        return {"roughness": rough}
    if isinstance(rough, Texture) or isinstance(stretched, Texture):
        lost.append(f"{kind}: its anisotropic, which varies")
        return {"roughness": rough}
    aspect = math.sqrt(1.0 - 0.9 * stretched)
    low, high = rough**2 * aspect, min(rough**2 / aspect, 1.0)
    strength = math.sqrt((high - low) / max(1.0 - low, 1e-9))
    return {"roughness": math.sqrt(low), "anisotropy": min(strength, 1.0)}


def _coat(fields: dict[str, Any], kind: str, lost: list[str]) -> dict[str, Any]:
    coat = fields.get("clearcoat", 0.0)
    if coat == 0.0:
        return {}
    lost.append(f"{kind}: the lobe of its coat became that of GGX")
    strength, gloss = (_mean(fields, name, kind, lost) for name in ("clearcoat", "clearcoat_gloss"))
    alpha = 0.1 + gloss * (0.001 - 0.1)
    return {"clearcoat": 0.25 * strength, "clearcoat_roughness": math.sqrt(alpha)}


def _sheen(fields: dict[str, Any], kind: str, lost: list[str]) -> dict[str, Any]:
    if fields["sheen"] == 0.0:
        return {}
    lost.append(f"{kind}: its sheen became one of fibres")
    strength, tint = (_mean(fields, name, kind, lost) for name in ("sheen", "sheen_tint"))
    color = fields["base_color"]
    base = np.array(color.mean() if isinstance(color, Texture) else color)
    hue = base / max(float(base.max()), 1e-9)
    return {"sheen_color": tuple((strength * (1.0 - tint + tint * hue)).tolist())}


def _mean(fields: dict[str, Any], name: str, kind: str, lost: list[str]) -> float:
    value = fields[name]
    if not isinstance(value, Texture):
        return float(value)
    lost.append(f"{kind}: the texture of its {name} became the mean")
    return float(value.mean()[1])
