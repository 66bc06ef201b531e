"""Materials that only pbrt 3 has.

``plastic``, ``uber``, ``substrate`` and ``translucent`` are sums of lobes there, of which some let
more light out than came in or lose some between the layers; what takes their places keeps energy.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.formats.materials.surfaces import index_of, reflection, two_sided
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.making import Making
from alight.formats.pbrt.materials import coat, index, metal
from alight.formats.pbrt.roughness import alphas, facets, is_smooth, one_alpha
from alight.formats.pbrt.textures import Value

#: What a coat reflects straight on where its colour is a texture.
_USUAL = 0.04


def _tint(m: Making, name: str, default: float) -> Value:
    return m.color(name, [default] * 3) or [default] * 3


def _eta(m: Making) -> float:
    return index(m, "index" if m.p.has("index") else "eta")


def _matte(m: Making) -> Data:
    color, sigma = _tint(m, "Kd", 0.5), m.plain_number("sigma", 0.0)
    if sigma > 0.0:
        data: Data = {"type": "oren_nayar", "reflectance": color, "sigma": min(sigma, 90.0)}
        return two_sided(data)
    return two_sided({"type": "diffuse", "reflectance": color})


def _plastic(m: Making) -> Data:
    base, specular = _tint(m, "Kd", 0.25), _tint(m, "Ks", 0.25)
    alpha = one_alpha(m, *alphas(m, 0.1))
    m.warn("adds its gloss to its matte part: a coat that keeps energy is taken")
    return two_sided(coat(m, alpha, base, 1.5, specular))


def _mirror(m: Making) -> Data:
    return two_sided({"type": "mirror", "reflectance": _tint(m, "Kr", 0.9)})


def _glass(m: Making) -> Data:
    data: Data = {
        "int_ior": _eta(m),
        "ext_ior": 1.0,
        "specular_reflectance": _tint(m, "Kr", 1.0),
        "specular_transmittance": _tint(m, "Kt", 1.0),
    }
    u, v = alphas(m, 0.0)
    if is_smooth(u, v):
        return {"type": "dielectric", **data}
    return {"type": "rough_dielectric", **data, **facets(u, v)}


def _metal(m: Making) -> Data:
    keys = metal(m, ("eta", "k"), None)
    return two_sided({"type": "rough_conductor", **keys, **facets(*alphas(m, 0.01))})


def _uber(m: Making) -> Data:
    base, specular = _tint(m, "Kd", 0.25), _tint(m, "Ks", 0.25)
    alpha, eta = one_alpha(m, *alphas(m, 0.1)), _eta(m)
    m.p.leave_out("a coat over a matte base is all there is", "Kr", "Kt")
    m.warn("adds its gloss to its matte part: a coat that keeps energy is taken")
    data = two_sided(coat(m, alpha, base, eta, specular))
    opacity = m.color("opacity", None)
    if isinstance(opacity, list):
        if len(set(opacity)) > 1:
            m.warn("has a coloured opacity: its mean is taken")
        opacity = min(max(sum(opacity) / 3.0, 0.0), 1.0)
    return data if opacity in (None, 1.0) else {"type": "mask", "opacity": opacity, "bsdf": data}


def _substrate(m: Making) -> Data:
    base, specular = _tint(m, "Kd", 0.5), _tint(m, "Ks", 0.5)
    alpha = one_alpha(m, *alphas(m, 0.1))
    # The index whose reflectance straight on is that of Ks.
    eta = index_of(_USUAL)
    if isinstance(specular, list):
        found = reflection(specular)
        if found.is_weaker:
            m.warn(f"reflects more than {found.strength:.3g} straight on, which a coat cannot")
        eta, specular = found.ior, [min(part, 1.0) for part in found.tint]
    else:
        m.warn(f"has a texture of Ks: it tints a coat that reflects {_USUAL:g} straight on")
    m.warn("is Ashikhmin and Shirley's model: a coat over a matte base is taken")
    return two_sided(coat(m, alpha, base, eta, specular))


def _translucent(m: Making) -> Data:
    base = _tint(m, "Kd", 0.25)
    if _tint(m, "Ks", 0.25) != [0.0] * 3:
        m.warn("adds its gloss to its matte part, which alone is taken")
    m.p.ignore("only the matte part is taken", "roughness", "remaproughness")
    parts = {}
    for key, name in (("reflectance", "reflect"), ("transmittance", "transmit")):
        share = _tint(m, name, 0.5)
        if isinstance(base, str) or isinstance(share, str):
            m.warn("has textures, of which only one counts")
            parts[key] = base if isinstance(base, str) else share
        else:
            parts[key] = [x * y for x, y in zip(base, share, strict=True)]
    return {"type": "diffuse_transmission", **parts}


def _disney(m: Making) -> Data:
    color = _tint(m, "color", 0.5)
    transmission = m.number("spectrans", 0.0)
    sheen = m.plain_number("sheen", 0.0)
    gloss = m.plain_number("clearcoatgloss", 1.0)
    anisotropy = m.plain_number("anisotropic", 0.0)
    data: Data = {
        "type": "principled",
        "base_color": color,
        "metallic": m.number("metallic", 0.0),
        "roughness": m.number("roughness", 0.5),
        "ior": _eta(m),
        "anisotropy": anisotropy,
        "transmission": transmission,
        "thin": m.p.flag("thin", False),
        "clearcoat": m.number("clearcoat", 0.0),
        # Burley's alpha of the coat lies between 0.1 (dull) and 0.001.
        "clearcoat_roughness": math.sqrt(0.1 + min(max(gloss, 0.0), 1.0) * (0.001 - 0.1)),
        "sheen_color": [sheen] * 3,
    }
    m.p.leave_out(
        "the principled material has no such part",
        "difftrans",
        "flatness",
        "scatterdistance",
        "sheentint",
        "speculartint",
    )
    m.warn("becomes the principled material, whose lobes differ a little")
    return two_sided(data) if transmission == 0.0 and not data["thin"] else data


OF_3: dict[str, Callable[[Making], Data]] = {
    "disney": _disney,
    "glass": _glass,
    "matte": _matte,
    "metal": _metal,
    "mirror": _mirror,
    "plastic": _plastic,
    "substrate": _substrate,
    "translucent": _translucent,
    "uber": _uber,
}
