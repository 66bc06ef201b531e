"""Plug-ins for materials that become others: layers, mixtures, measured and polarizing ones.

Source: the documentation of Mitsuba 0.6 and 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.scene.formats import hair
from alight.scene.formats.mitsuba.bsdfs import convert, medium_index, rough_plastic, roughness
from alight.scene.formats.mitsuba.context import Context, Data
from alight.scene.formats.mitsuba.draft import Draft
from alight.scene.formats.mitsuba.textures import color_or_texture
from alight.scene.formats.mitsuba.values import NotNumbersError, parse_numbers

_BLACK: Data = {"type": "diffuse", "reflectance": [0.0] * 3}
MOST_PARTS = 16


def _warn(draft: Draft, text: str) -> None:
    draft.context.report.warn(draft.element, text)


def _polarized_plastic(draft: Draft) -> None:
    rough_plastic(draft)
    _warn(draft, "becomes a rough plastic: nothing is polarized")


def _measured(draft: Draft) -> None:
    draft.properties.ignore("its table is not read", "filename", "alpha_sample")
    draft.properties.ignore("nothing is polarized", "wavelength")
    _warn(draft, "is not covered: grey plastic is taken")
    draft.data |= {"diffuse_reflectance": [0.5] * 3, "alpha": 0.3, "distribution": "ggx"}


def _radio(draft: Draft) -> None:
    for name in draft.properties.named:
        draft.properties.find(name)
    _warn(draft, "is a material for radio waves: grey 0.5 is taken")
    draft.data["reflectance"] = [0.5] * 3


def _hair(draft: Draft) -> None:
    p = draft.properties
    p.ignore(
        "a matte surface is taken", "longitudinal_roughness", "scale_tilt", "int_ior", "ext_ior"
    )
    draft.color("sigma_a", role="index")
    absorbed = draft.data.pop("sigma_a", None)
    if absorbed is None:
        pigments = (p.number("eumelanin", 0.0) or 0.0, p.number("pheomelanin", 0.0) or 0.0)
        absorbed = hair.absorption(*(pigments if any(pigments) else (hair.USUAL_EUMELANIN, 0.0)))
    beta = p.number("azimuthal_roughness", hair.USUAL_BETA_N)
    draft.data["reflectance"] = hair.color(absorbed, hair.USUAL_BETA_N if beta is None else beta)
    _warn(draft, "is not covered: a matte surface of the colour of much such hair is taken")


def _polarizer(draft: Draft) -> None:
    draft.properties.ignore("nothing is polarized", "theta", "transmittance", "polarizing")
    draft.properties.ignore("nothing is polarized", "left_handed")
    _warn(draft, "lets half of the light through: nothing is polarized")
    draft.data |= {"opacity": 0.5, "bsdf": dict(_BLACK)}


def _retarder(draft: Draft) -> None:
    draft.properties.ignore("nothing is polarized", "theta", "delta", "transmittance")
    _warn(draft, "lets all light through: nothing is polarized")


def _rough_diffuse(draft: Draft) -> None:
    old_name = draft.properties.has("diffuse_reflectance")
    color_or_texture(draft, "reflectance", 0.5, "diffuse_reflectance" if old_name else None)
    alpha = draft.properties.number("alpha", 0.2) or 0.0
    draft.properties.ignore("the whole model is taken", "use_fast_approx")
    # The plug-in's own conversion to Oren and Nayar's angle.
    sigma = math.degrees(math.atan(alpha) / math.sqrt(2.0))
    draft.put("sigma", min(max(sigma, 0.0), 90.0), "alpha")


def _transmitting(draft: Draft) -> None:
    color_or_texture(draft, "transmittance", 0.5)
    draft.data["reflectance"] = [0.0] * 3


def _ward(draft: Draft) -> None:
    p = draft.properties
    color_or_texture(draft, "diffuse", 0.5, "diffuse_reflectance")
    color_or_texture(draft, "specular", 0.2, "specular_reflectance")
    p.ignore("Phong's lobe is taken", "variant")
    both = p.number("alpha", 0.1)
    alphas = [p.number(f"alpha_{axis}", both) or 0.1 for axis in "uv"]
    # Half-way vectors turn half as far as mirrored ones.
    exponent = 0.5 / max(alphas[0] * alphas[1], 1e-6)
    draft.data["exponent"] = min(max(exponent, 0.0), 1e4)
    _warn(draft, "becomes Phong's model with a lobe as wide, the same in all directions")


def _mixture(draft: Draft) -> None:
    """(1 - w) a + w b, again and again; what the weights leave is black."""
    p, report = draft.properties, draft.context.report
    parts = p.take("bsdf", "ref")
    try:
        weights = parse_numbers(p.text("weights"), *range(1, MOST_PARTS + 1))
    except NotNumbersError as error:
        report.error(p.named.get("weights", draft.element), str(error))
        weights = []
    p.flag("ensure_energy_conservation", True)
    if len(weights) != len(parts) or not parts or min(weights) < 0.0 or sum(weights) <= 0.0:
        text = f"needs a weight >= 0 for each of its bsdfs, got {len(weights)} for {len(parts)}"
        report.error(draft.element, text)
        draft.data = dict(_BLACK)
        return
    places = [f"{draft.path}.bsdfs[{i}]" for i in range(len(parts))]
    built = [convert(draft.context, e, place) for e, place in zip(parts, places, strict=True)]
    if sum(weights) > 1.0 + 1e-6:
        report.warn(draft.element, f"has weights of {sum(weights):g} in all: they are scaled to 1")
    elif sum(weights) < 1.0 - 1e-6:
        built, weights = [*built, dict(_BLACK)], [*weights, 1.0 - sum(weights)]
    draft.data = _blended(built, weights)


def _blended(parts: list[Data | str], weights: list[float]) -> Data:
    if len(parts) == 1:
        return {"type": "mask", "opacity": 1.0, "bsdf": parts[0]}
    rest = parts[1] if len(parts) == 2 else _blended(parts[1:], weights[1:])
    share = sum(weights[1:]) / sum(weights)
    return {"type": "blend", "weight": share, "bsdfs": [parts[0], rest]}


def _coating(draft: Draft) -> None:
    """A clear coat, over what alight can put one on."""
    p, report = draft.properties, draft.context.report
    is_rough = draft.element.type == "roughcoating"
    inside, outside = medium_index(draft, "int_ior", "bk7"), medium_index(draft, "ext_ior", "air")
    alpha = 0.0
    if is_rough:
        roughness(draft, anisotropic=False)
        alpha = draft.data.get("alpha", 0.1)
        alpha = alpha if isinstance(alpha, float) else 0.1
    draft.color("sigma_a", role="index")
    absorbed = draft.data.get("sigma_a", [0.0] * 3)
    thickness = p.number("thickness", 1.0) or 0.0
    tint = [math.exp(-2.0 * max(channel, 0.0) * max(thickness, 0.0)) for channel in absorbed]
    p.ignore("the coat is clear", "specular_reflectance")
    parts = p.take("bsdf", "ref")
    if len(parts) != 1:
        report.error(draft.element, f"must hold one bsdf, got {len(parts)}")
        draft.data = dict(_BLACK)
        return
    inner = convert(draft.context, parts[0], f"{draft.path}.bsdf")
    base = _plain(draft.context, inner)
    ior = {"int_ior": inside, "ext_ior": outside}
    if base["type"] == "diffuse":
        draft.data = _over_matte(base, tint, ior, alpha if is_rough else None)
        _warn(draft, "becomes plastic, which takes all rounds of the light between its layers")
    elif base["type"] in ("conductor", "rough_conductor", "mirror"):
        draft.data = _over_metal(base, tint, inside / outside, alpha)
        _warn(draft, "becomes a principled metal under a clear coat")
    else:
        draft.data = {"type": "mask", "opacity": 1.0, "bsdf": inner}
        _warn(draft, f"is left out: over {base['type']} there is no coat here")


def _plain(context: Context, data: Data | str) -> Data:
    """A material without its name and its second side."""
    while isinstance(data, str) or data.get("type") == "two_sided":
        data = context.tables["bsdfs"][data] if isinstance(data, str) else data.get("bsdf", _BLACK)
    return data


def _over_matte(base: Data, tint: list[float], ior: Data, alpha: float | None) -> Data:
    color = base.get("reflectance", [0.5] * 3)
    if isinstance(color, list):
        color = [a * b for a, b in zip(color, tint, strict=True)]
    elif min(tint) < 1.0:
        color = {"type": "multiply", "a": color, "b": tint}
    data: Data = {"type": "plastic", "diffuse_reflectance": color, "nonlinear": True, **ior}
    if alpha is not None:
        data |= {"type": "rough_plastic", "alpha": max(alpha, 1e-4), "distribution": "ggx"}
    return data


def _over_metal(base: Data, tint: list[float], ior: float, alpha: float) -> Data:
    tinted = base.get("reflectance" if base["type"] == "mirror" else "specular_reflectance")
    color = [1.0] * 3
    if base["type"] != "mirror":
        pairs = zip(base["eta"], base["k"], strict=True)
        color = [_straight_on(eta / ior, k / ior) for eta, k in pairs]
    if isinstance(tinted, list):
        color = [a * b for a, b in zip(color, tinted, strict=True)]
    inner = base.get("alpha", base.get("alpha_u", 0.0))
    return {
        "type": "principled",
        "base_color": [a * b for a, b in zip(color, tint, strict=True)],
        "metallic": 1.0,
        "roughness": math.sqrt(inner) if isinstance(inner, float) else 0.3,
        "clearcoat": 1.0,
        "clearcoat_roughness": math.sqrt(max(alpha, 0.0)),
    }


def _straight_on(eta: float, k: float) -> float:
    return min(1.0, ((eta - 1.0) ** 2 + k * k) / ((eta + 1.0) ** 2 + k * k))


#: Our names, and what reads the parameters.
STAND_INS: dict[str, tuple[str, Callable[[Draft], None]]] = {
    "circular": ("mask", _polarizer),
    "coating": ("plastic", _coating),
    "difftrans": ("diffuse_transmission", _transmitting),
    "hair": ("diffuse", _hair),
    "itu-radio-material": ("diffuse", _radio),
    "measured": ("rough_plastic", _measured),
    "measured_polarized": ("rough_plastic", _measured),
    "mixturebsdf": ("blend", _mixture),
    "polarizer": ("mask", _polarizer),
    "pplastic": ("rough_plastic", _polarized_plastic),
    "radio-material": ("diffuse", _radio),
    "retarder": ("null", _retarder),
    "roughcoating": ("rough_plastic", _coating),
    "roughdiffuse": ("oren_nayar", _rough_diffuse),
    "ward": ("phong", _ward),
}
