"""Plug-ins for materials that become others: layers, mixtures, measured and polarizing ones.

Source: the documentation of Mitsuba 0.6 and 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.bsdfs.microfacets.albedo_rows import LEAST_ALPHA
from alight.formats.materials import hair
from alight.formats.materials.surfaces import LARGEST_IOR, reflectance
from alight.formats.mitsuba.bsdfs import convert, medium_index, rough_plastic, roughness
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.textures import color_or_texture
from alight.formats.reading.numbers import NotNumbersError, parse_numbers
from alight.formats.reading.reach import OutOfReachError

_BLACK: Data = {"type": "diffuse", "reflectance": [0.0] * 3}
MOST_PARTS = 16
#: Of facets, where a file gives none.
_USUAL_ALPHA = 0.1


#: What takes the place of measurements.
_GREY_PLASTIC: Data = {
    "type": "rough_plastic", "diffuse_reflectance": [0.5] * 3, "alpha": 0.3, "distribution": "ggx",
}  # fmt: skip


def _warn(draft: Draft, text: str) -> None:
    draft.context.report.warn(draft.element, text)


def _polarized_plastic(draft: Draft) -> None:
    rough_plastic(draft)
    _warn(draft, "becomes a rough plastic: nothing is polarized")


def _measured(draft: Draft) -> None:
    p, report, reach = draft.properties, draft.context.report, draft.context.reach
    found = p.value("filename", "string")
    if found is None:
        if not p.has("filename"):
            report.error(draft.element, 'needs <string name="filename" .../>')
        draft.data = dict(_GREY_PLASTIC)
        return
    try:
        draft.put("file", reach.name_of(reach.find(found[1])), "filename")
    except OutOfReachError as error:
        report.lacks(found[0], error, "grey plastic is taken")
        draft.data = dict(_GREY_PLASTIC)


def _measured_polarized(draft: Draft) -> None:
    draft.properties.ignore("its table is not read", "filename", "alpha_sample")
    draft.properties.ignore("nothing is polarized", "wavelength")
    _warn(draft, "is not covered: grey plastic is taken")
    draft.data = dict(_GREY_PLASTIC)


def _radio(draft: Draft) -> None:
    for name in draft.properties.named:
        draft.properties.find(name)
    _warn(draft, "is a material for radio waves: grey 0.5 is taken")
    draft.data["reflectance"] = [0.5] * 3


def _hair(draft: Draft) -> None:
    p = draft.properties
    draft.color("sigma_a", role="index")
    absorbed = draft.data.get("sigma_a")
    if absorbed is None:
        for name, usual in (("eumelanin", 1.3), ("pheomelanin", 0.2)):
            draft.data[name] = _hairy(draft, name, usual, hair.MOST)
    elif min(absorbed) < 0.0:
        draft.context.report.error(p.named["sigma_a"], "must be >= 0 in each channel")
    draft.data["beta_m"] = hair.roughness(_hairy(draft, "longitudinal_roughness", hair.BETA, 1.0))
    draft.data["beta_n"] = hair.roughness(_hairy(draft, "azimuthal_roughness", hair.BETA, 1.0))
    draft.data["alpha"] = _hairy(draft, "scale_tilt", hair.TILT, hair.MOST_TILT)
    outside = medium_index(draft, "ext_ior", "air")
    ior = medium_index(draft, "int_ior", "amber") / outside
    draft.data["ior"] = min(max(ior, 1.0), LARGEST_IOR)


def _hairy(draft: Draft, name: str, default: float, most: float) -> float:
    """A parameter of hair, which lies between 0 and `most`."""
    found = draft.properties.number(name, default)
    if found is None or 0.0 <= found <= most:
        return default if found is None else found
    text = f"must be in [0, {most:g}], got {found:g}"
    draft.context.report.error(draft.properties.named[name], text)
    return default


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
    alpha = draft.properties.number("alpha", 0.2)
    draft.properties.ignore("the whole model is taken", "use_fast_approx")
    # The plug-in's own conversion to Oren and Nayar's angle, in radians.
    sigma = math.degrees(alpha / math.sqrt(2.0))
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
    kept = [pair for pair in zip(built, weights, strict=True) if pair[1] > 0.0]
    draft.data = _blended([part for part, _ in kept], [weight for _, weight in kept])


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
    alpha, facets = 0.0, "ggx"
    if is_rough:
        roughness(draft, anisotropic=False)
        alpha, facets = draft.data.get("alpha", 0.1), draft.data["distribution"]
        if not isinstance(alpha, float):
            report.warn(p.named["alpha"], f"is not a number: {_USUAL_ALPHA:g} is taken")
            alpha = _USUAL_ALPHA
    draft.color("sigma_a", role="index")
    absorbed = draft.data.get("sigma_a", [0.0] * 3)
    thickness = p.number("thickness", 1.0)
    depth = [max(channel, 0.0) * max(thickness, 0.0) for channel in absorbed]
    tint = [math.exp(-2.0 * channel) for channel in depth]
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
        draft.data = _over_matte(base, tint, ior)
        if is_rough:
            rough = {"alpha": max(alpha, LEAST_ALPHA), "distribution": facets}
            draft.data |= {"type": "rough_plastic", **rough}
        _warn(draft, "becomes plastic, which takes all rounds of the light between its layers")
    elif base["type"] in ("conductor", "rough_conductor") and _is_even(base, depth, ior):
        draft.data = _lacquered(base, depth[0], ior, alpha)
        _say_ggx(draft, facets, base)
        if is_rough:
            _warn(draft, "becomes coated metal: how its coat spreads light below differs")
    elif base["type"] in ("conductor", "rough_conductor", "mirror"):
        draft.data = _over_metal(draft, base, tint, alpha)
        _say_ggx(draft, facets, base)
        _warn(draft, "becomes a principled metal under a clear coat")
    else:
        draft.data = {"type": "mask", "opacity": 1.0, "bsdf": inner}
        _warn(draft, f"is left out: over {base['type']} there is no coat here")


def _plain(context: Context, data: Data | str) -> Data:
    """A material without its name and its second side."""
    while isinstance(data, str) or data.get("type") == "two_sided":
        data = context.tables["bsdfs"][data] if isinstance(data, str) else data.get("bsdf", _BLACK)
    return data


def _say_ggx(draft: Draft, facets: str, base: Data) -> None:
    """Coats over metal have one kind of facets, as their metal."""
    if "beckmann" in (facets, base.get("distribution")):
        _warn(draft, "has facets of GGX, in the coat and below")


def _over_matte(base: Data, tint: list[float], ior: Data) -> Data:
    color = base.get("reflectance", [0.5] * 3)
    if isinstance(color, list):
        color = [a * b for a, b in zip(color, tint, strict=True)]
    elif min(tint) < 1.0:
        color = {"type": "multiply", "a": color, "b": tint}
    return {"type": "plastic", "diffuse_reflectance": color, "nonlinear": True, **ior}


def _is_even(base: Data, depth: list[float], ior: Data) -> bool:
    """Whether our coated metal can stand for it: of one roughness and without colours."""
    one_alpha = isinstance(base.get("alpha", 0.0), float) and "alpha_u" not in base
    plain = base.get("specular_reflectance", [1.0] * 3) == [1.0] * 3
    grey = len(set(depth)) == 1 and depth[0] <= 1e3
    return one_alpha and plain and grey and 1.01 <= ior["int_ior"] / ior["ext_ior"] <= LARGEST_IOR


def _lacquered(base: Data, thickness: float, ior: Data, alpha: float) -> Data:
    """Coated metal; the plug-ins let light meet the metal once."""
    rough = {
        "alpha": min(max(base.get("alpha", 0.0), LEAST_ALPHA), 1.0),
        "coat_alpha": min(max(alpha, LEAST_ALPHA), 1.0),
    }
    # The plug-ins bend the light towards the metal, which reflects it as if it stood in air.
    metal = {key: [ior["int_ior"] * channel for channel in base[key]] for key in ("eta", "k")}
    return {
        "type": "coated_conductor",
        **metal,
        **ior,
        **rough,
        "thickness": thickness,
        "bounces": 1,
    }


def _over_metal(draft: Draft, base: Data, tint: list[float], alpha: float) -> Data:
    tinted = base.get("reflectance" if base["type"] == "mirror" else "specular_reflectance")
    color = [1.0] * 3
    if base["type"] != "mirror":
        pairs = zip(base["eta"], base["k"], strict=True)
        color = [reflectance(eta, k) for eta, k in pairs]
    if isinstance(tinted, list):
        color = [a * b for a, b in zip(color, tinted, strict=True)]
    elif tinted is not None:
        _warn(draft, "loses the texture of what its metal reflects")
    inner = base.get("alpha", 0.0)
    if "alpha_u" in base:
        inner = base["alpha_u"]
        _warn(draft, "spreads light over its metal alike in all directions, by alpha_u")
    if not isinstance(inner, float):
        _warn(draft, f"loses the texture of its metal's alpha: {_USUAL_ALPHA:g} is taken")
        inner = _USUAL_ALPHA
    return {
        "type": "principled",
        "base_color": [a * b for a, b in zip(color, tint, strict=True)],
        "metallic": 1.0,
        "roughness": math.sqrt(max(inner, 0.0)),
        "clearcoat": 1.0,
        "clearcoat_roughness": math.sqrt(max(alpha, 0.0)),
    }


#: Our names, and what reads the parameters.
STAND_INS: dict[str, tuple[str, Callable[[Draft], None]]] = {
    "circular": ("mask", _polarizer),
    "coating": ("plastic", _coating),
    "difftrans": ("diffuse_transmission", _transmitting),
    "hair": ("hair", _hair),
    "itu-radio-material": ("diffuse", _radio),
    "measured": ("measured", _measured),
    "measured_polarized": ("rough_plastic", _measured_polarized),
    "mixturebsdf": ("blend", _mixture),
    "polarizer": ("mask", _polarizer),
    "pplastic": ("rough_plastic", _polarized_plastic),
    "radio-material": ("diffuse", _radio),
    "retarder": ("null", _retarder),
    "roughcoating": ("rough_plastic", _coating),
    "roughdiffuse": ("oren_nayar", _rough_diffuse),
    "ward": ("phong", _ward),
}
