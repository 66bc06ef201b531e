"""``Material`` and ``MakeNamedMaterial`` -> materials of the native format.

Those of pbrt that reflect look the same from both sides, hence ``two_sided``.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.formats.materials.surfaces import LARGEST_IOR, reflectance, two_sided
from alight.formats.pbrt.colors import DISPERSION, INDICES
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.making import Making
from alight.formats.pbrt.roughness import alphas, facets, is_smooth, one_alpha
from alight.formats.pbrt.textures import Value, product
from alight.formats.pbrt.walks import LEAST_ALPHA, Coat, base_of_walk

SMALLEST_ETA = 1e-6
#: Rougher coats over a matte base are warned of.
LARGEST_ALPHA = 0.15


def coat(m: Making, alpha: float | str, base: Value, eta: float, specular: Value | None) -> Data:
    """A clear coat over a matte base."""
    data: Data = {"diffuse_reflectance": base, "int_ior": eta, "ext_ior": 1.0}
    if specular is not None:
        data["specular_reflectance"] = specular
    if is_smooth(alpha):
        return {"type": "plastic", **data}
    alpha = max(alpha, 1e-4) if isinstance(alpha, float) else alpha
    return {"type": "rough_plastic", "distribution": "ggx", "alpha": alpha, **data}


def index(m: Making, name: str, default: float = 1.5) -> float:
    """Ask for an index of refraction: a number, or the name of a glass."""
    found = m.p.find(name)
    if found is None or found.kind == "float" or found.kind == "texture":
        value = m.plain_number(name, default)
    else:
        color = m.context.colors.read(found, "index") or [default] * 3
        value = color[1]
        if not (found.is_text and found.values[0] in INDICES):
            m.warn("bends all colours alike: there is no dispersion")
    if not 1e-3 < value < 1e3:
        if found is not None:
            m.p.report.error(found, f"must be in [0.001, 1000], got {value:g}")
        return default
    return value


def metal(m: Making, names: tuple[str, str], reflectance: str | None) -> Data:
    """The keys of a conductor: eta and k, or those that reflect a given colour straight on."""
    found = m.color(reflectance, None) if reflectance else None
    if isinstance(found, str):
        m.warn("reflects a texture alike at all angles")
        return {"eta": [SMALLEST_ETA] * 3, "k": [1.0] * 3, "specular_reflectance": found}
    if found is not None:
        # pbrt's choice: eta = 1 and k = 2 sqrt(r / (1 - r)).
        r = [min(max(channel, 0.0), 0.9999) for channel in found]
        return {"eta": [1.0] * 3, "k": [2.0 * math.sqrt(x / (1.0 - x)) for x in r]}
    pair = []
    for name, default in zip(names, ("metal-Cu-eta", "metal-Cu-k"), strict=True):
        value = m.color(name, list(INDICES[default]), "index")
        if isinstance(value, str):
            m.warn(f"has a texture of {name}: copper is taken")
            value = None
        pair.append(list(value or INDICES[default]))
    return {"eta": [max(c, SMALLEST_ETA) for c in pair[0]], "k": pair[1]}


def _diffuse(m: Making) -> Data:
    return two_sided({"type": "diffuse", "reflectance": m.color("reflectance", [0.5] * 3)})


def _coated_diffuse(m: Making) -> Data:
    alpha = one_alpha(m, *alphas(m, 0.0))
    base = m.color("reflectance", [0.5] * 3) or [0.5] * 3
    walk = _walk(m)
    eta = index(m, "eta")
    if isinstance(alpha, float):
        base = _base_of_walk(m, base, Coat(alpha, eta, *walk))
    else:
        m.warn("has a texture of roughness: the coat is clear, and light goes round without end")
    # Light goes round between the layers, tinted each time.
    return two_sided({**coat(m, alpha, base, eta, None), "nonlinear": True})


def _base_of_walk(m: Making, base: Value, coat: Coat) -> Value:
    """The base that looks as pbrt's does under its coat; see `alight.formats.pbrt.walks`."""
    if coat.alpha > LARGEST_ALPHA:
        m.warn(
            "has a rough coat over a matte base: as bright as in pbrt within 0.01 up to 70 degrees"
            " for roughnesses up to 0.25, and too dark towards the rim (0.04 at 84 degrees for 0.1)"
        )
    if isinstance(base, str):
        m.warn(
            "has a texture below a coat: right where its albedo is 0.7, too bright by up to 0.05"
            " where it is white"
        )
        return product(m, base, [base_of_walk([0.7], coat)[0] / 0.7] * 3)
    return base_of_walk(base, coat)


def _walk(m: Making) -> tuple[float, int]:
    """Optical thickness of what lies between the layers, and how often light meets the base."""
    thickness = min(max(m.plain_number("thickness", 0.01), 0.0), 1e3)
    depth = m.p.integer("maxdepth", 10)
    m.p.ignore("the layers are solved without random walks", "nsamples", "twosided")
    m.p.leave_out("nothing scatters between the layers", "albedo", "g")
    # Each second event of pbrt's walk is one at the base.
    return thickness, min(max((depth + 1) // 2, 1), 1000)


def _conductor(m: Making) -> Data:
    keys = metal(m, ("eta", "k"), "reflectance")
    u, v = alphas(m, 0.0)
    if is_smooth(u, v):
        return two_sided({"type": "conductor", **keys})
    return two_sided({"type": "rough_conductor", **keys, **facets(u, v)})


def _coated_conductor(m: Making) -> Data:
    outer = one_alpha(m, *alphas(m, 0.0, "interface."))
    inner = one_alpha(m, *alphas(m, 0.0, "conductor."))
    eta = index(m, "interface.eta")
    keys = metal(m, ("conductor.eta", "conductor.k"), "reflectance")
    thickness, bounces = _walk(m)
    tint = keys.pop("specular_reflectance", None)
    if tint is not None or isinstance(outer, str) or isinstance(inner, str):
        return two_sided(_principled_layers(m, keys, (outer, inner), eta, tint))
    ior = min(max(eta, 1.01), LARGEST_IOR)
    if ior != eta:
        m.warn(f"has a coat of index {eta:g}, which is taken as {ior:g}")
    m.warn(
        "reflects as much as in pbrt within 0.01 of the light, all rounds between the layers"
        " summed up; how a rough coat spreads it at grazing angles differs"
    )
    layers = {"int_ior": ior, "ext_ior": 1.0, "thickness": thickness, "bounces": bounces}
    rough = {"alpha": max(inner, LEAST_ALPHA), "coat_alpha": max(outer, LEAST_ALPHA)}
    return two_sided({"type": "coated_conductor", **keys, **layers, **rough})


def _principled_layers(
    m: Making, keys: Data, rough: tuple[float | str, float | str], eta: float, tint: Value | None
) -> Data:
    """A coated metal with textures: the albedo of its layers cannot be tabulated."""
    m.warn(
        "has textures, so it becomes a principled metal under a clear coat of index 1.5, in which"
        " no light is lost: too bright, by up to 0.5 where both layers are rough"
    )
    eta_k = zip(keys["eta"], keys["k"], strict=True)
    color = [reflectance(e / eta, k / eta) for e, k in eta_k] if tint is None else tint
    return {
        "type": "principled",
        "base_color": color,
        "metallic": 1.0,
        "roughness": root(rough[1]),
        "clearcoat": 1.0,
        "clearcoat_roughness": root(rough[0]),
    }


def root(alpha: float | str) -> float | str:
    """The roughness of which alpha is the square."""
    return math.sqrt(alpha) if isinstance(alpha, float) else alpha


def _dielectric(m: Making) -> Data:
    u, v = alphas(m, 0.0)
    found = m.p.find("eta")
    glass = DISPERSION.get(str(found.values[0])) if found is not None and found.is_text else None
    if found is not None and glass is not None:
        data: Data = {"dispersion": glass, "ext_ior": 1.0}
    else:
        data = {"int_ior": index(m, "eta"), "ext_ior": 1.0}
    if is_smooth(u, v):
        return {"type": "dielectric", **data}
    return {"type": "rough_dielectric", **data, **facets(u, v)}


def _thin_dielectric(m: Making) -> Data:
    return {"type": "thin_dielectric", "int_ior": index(m, "eta"), "ext_ior": 1.0}


def _diffuse_transmission(m: Making) -> Data:
    scale = m.p.number("scale", 1.0)
    found = {}
    for key in ("reflectance", "transmittance"):
        value = m.color(key, [0.25] * 3) or [0.25] * 3
        if isinstance(value, list):
            value = [scale * channel for channel in value]
        elif scale != 1.0:
            m.warn(f"has a texture of {key}, which is not scaled")
        found[key] = value
    return {"type": "diffuse_transmission", **found}


def _interface(m: Making) -> Data:
    return {"type": "null"}


def _mix(m: Making) -> Data:
    amount = m.share("amount")
    if m.context.old or m.p.has("namedmaterial1"):
        parameters = [m.p.values(f"namedmaterial{i}", "string", count=1) for i in (2, 1)]
        names = [(str(p.values[0]), p) for p in parameters if p is not None]
    else:
        found = m.p.values("materials", "string", count=2)
        names = [(str(name), found) for name in found.values] if found is not None else []
    if len(names) != 2:
        m.p.report.error(m.p.directive, "must name two materials")
        return two_sided({"type": "diffuse"})
    if isinstance(amount, float) and not 0.0 <= amount <= 1.0:
        m.p.report.error(m.p.named["amount"], f"must be in [0, 1], got {amount:g}")
        amount = 0.5
    # Of pbrt 4's materials the second one has the amount, of pbrt 3's the first.
    return {
        "type": "blend",
        "weight": amount,
        "bsdfs": [m.nested(name, parameter) for name, parameter in names],
    }


#: Materials of pbrt that alight has models for, but for most of those that only pbrt 3 has.
COVERED: dict[str, Callable[[Making], Data]] = {
    "": _interface,
    "coatedconductor": _coated_conductor,
    "coateddiffuse": _coated_diffuse,
    "conductor": _conductor,
    "dielectric": _dielectric,
    "diffuse": _diffuse,
    "diffusetransmission": _diffuse_transmission,
    "interface": _interface,
    "mix": _mix,
    "none": _interface,
    "thindielectric": _thin_dielectric,
}
