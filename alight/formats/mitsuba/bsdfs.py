"""``<bsdf>`` -> materials of the native format."""

from __future__ import annotations

import math
from collections.abc import Callable

from alight.core.errors import unknown_name
from alight.formats.materials.metals import METALS
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.media import MEDIA
from alight.formats.mitsuba.textures import (
    color_or_texture,
    normals,
    number_or_texture,
    texture_value,
)
from alight.formats.reading.numbers import NotNumbersError, parse_number
from alight.formats.reading.xml import Element

#: What takes the place of a material that is not covered.
GREY: Data = {"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]}
# A conductor of Mitsuba may have eta = 0; the reflectance changes by less than 1e-6.
SMALLEST_ETA = 1e-6
# The reflector of 100 %, at every angle.
PERFECT = "none"
_DISTRIBUTIONS = ("beckmann", "ggx")
#: Distributions that only Mitsuba 0.6 has.
_OF_06 = ("phong", "as")


def convert(context: Context, element: Element, path: str) -> Data | str:
    """Convert a ``<bsdf>``, or a reference to one.

    Returns
    -------
    dict or str
        Description, or the name of one where the element has an id.
    """
    target = context.target(element, "bsdf")
    if target is None:
        return dict(GREY)
    if "id" in target:
        return context.named("bsdfs", target, lambda path: _build(context, target, path))
    return _build(context, target, path)


def _build(context: Context, element: Element, path: str) -> Data:
    known = context.materials
    if element.type not in known:
        context.report.unknown(element, "bsdf", element.type, known, "grey diffuse 0.5 is taken")
        context.places[path] = element.place
        return dict(GREY)
    if not context.enter(element):
        return dict(GREY)
    native, fill = known[element.type]
    draft = Draft(context, element, path, native)
    fill(draft)
    draft.properties.finish()
    context.leave()
    return draft.data


def _nested(draft: Draft, key: str, count: int = 1) -> None:
    """Set a key to the materials inside."""
    report, parts = draft.context.report, draft.properties.take("bsdf", "ref")
    if len(parts) != count:
        wanted = "one bsdf" if count == 1 else f"{count} bsdfs"
        text = f"must hold {wanted}, got {len(parts)}"
        report.not_covered(draft.element, text, "grey diffuse 0.5 is taken")
        draft.data = dict(GREY)
        return
    paths = [f"{draft.path}.{key}" + (f"[{i}]" if count > 1 else "") for i in range(count)]
    built = [convert(draft.context, part, path) for part, path in zip(parts, paths, strict=True)]
    draft.put(key, built if count > 1 else built[0])


def _diffuse(draft: Draft) -> None:
    old_name = draft.element.old and draft.properties.has("diffuse_reflectance")
    color_or_texture(draft, "reflectance", name="diffuse_reflectance" if old_name else None)


def _conductor(draft: Draft) -> None:
    color_or_texture(draft, "specular_reflectance")
    if _index(draft):
        return
    # Reflects everything, at every angle: a mirror.
    reflectance = draft.data.pop("specular_reflectance", [1.0, 1.0, 1.0])
    draft.data = {"type": "mirror", "reflectance": reflectance}


def _rough_conductor(draft: Draft) -> None:
    color_or_texture(draft, "specular_reflectance")
    if not _index(draft):
        draft.put("eta", [SMALLEST_ETA] * 3, "material")
        draft.put("k", [1.0] * 3, "material")
    roughness(draft, anisotropic=True)


def _index(draft: Draft) -> bool:
    """Set eta and k; False for the perfect reflector, which has none."""
    p, report = draft.properties, draft.context.report
    given = p.has("eta") or p.has("k")
    # Version 0.6 takes copper where a file names no metal, version 3 a perfect mirror.
    unnamed = "Cu" if draft.element.old else PERFECT
    name = p.text("material", unnamed, (PERFECT, *METALS) if p.has("material") else ())
    if given and p.has("material"):
        report.error(draft.element, "takes either material or eta and k, got both")
    if not given and name == PERFECT:
        return False
    if given:
        draft.color("eta", 0.0, role="index")
        draft.color("k", 1.0, role="index")
    else:
        eta, k = METALS[name]
        draft.put("eta", list(eta), "material")
        draft.put("k", list(k), "material")
    outside = _medium(draft, "ext_eta", 1.0) if draft.element.old else 1.0
    draft.data["eta"] = [max(channel / outside, SMALLEST_ETA) for channel in draft.data["eta"]]
    draft.data["k"] = [channel / outside for channel in draft.data["k"]]
    return True


def _medium(draft: Draft, name: str, default: float) -> float:
    """Ask for an index of refraction, given as a number or as a name."""
    p, report = draft.properties, draft.context.report
    found = p.value(name, "float", "integer", "string")
    if found is None:
        return default
    element, text = found
    try:
        if element.tag == "string":
            if text in MEDIA:
                return MEDIA[text]
            report.error(element, unknown_name("medium", text, MEDIA, listed_as="media"))
            return default
        number = parse_number(text)
    except NotNumbersError as error:
        report.error(element, str(error))
        return default
    if number <= 0.0:
        report.error(element, f"must be > 0, got {number:g}")
        return default
    return number


def medium_index(draft: Draft, name: str, default: str) -> float:
    """Ask for an index of refraction, that of a medium by default."""
    return _medium(draft, name, MEDIA[default])


def _media(draft: Draft, inside: str) -> None:
    draft.put("int_ior", _medium(draft, "int_ior", MEDIA[inside]))
    draft.put("ext_ior", _medium(draft, "ext_ior", MEDIA["air"]))


def roughness(draft: Draft, anisotropic: bool) -> None:
    """Read facets and how rough they are."""
    p = draft.properties
    if draft.element.old and p.text("distribution") in _OF_06:
        text = "becomes Beckmann's distribution of the same roughness"
        draft.context.report.warn(p.named["distribution"], text)
        draft.put("distribution", "beckmann")
    else:
        draft.put("distribution", p.text("distribution", "beckmann", _DISTRIBUTIONS))
    p.ignore("visible normals are always sampled", "sample_visible")
    if anisotropic and (p.has("alpha_u") or p.has("alpha_v")):
        number_or_texture(draft, "alpha_u")
        number_or_texture(draft, "alpha_v")
        if p.has("alpha"):
            number_or_texture(draft, "alpha")
    else:
        number_or_texture(draft, "alpha", 0.1)


def _dielectric(draft: Draft) -> None:
    _media(draft, "bk7")
    color_or_texture(draft, "specular_reflectance")
    color_or_texture(draft, "specular_transmittance")


def _rough_dielectric(draft: Draft) -> None:
    _dielectric(draft)
    roughness(draft, anisotropic=True)


def _plastic(draft: Draft) -> None:
    _media(draft, "polypropylene")
    color_or_texture(draft, "diffuse_reflectance", 0.5)
    color_or_texture(draft, "specular_reflectance")
    draft.put("nonlinear", draft.properties.flag("nonlinear") or None)


def rough_plastic(draft: Draft) -> None:
    """Read a rough plastic."""
    _plastic(draft)
    roughness(draft, anisotropic=False)


def _phong(draft: Draft) -> None:
    color_or_texture(draft, "diffuse", 0.5, "diffuse_reflectance")
    color_or_texture(draft, "specular", 0.2, "specular_reflectance")
    draft.number("exponent", 30.0)


def _normal_map(draft: Draft) -> None:
    normals(draft, "texture", "normalmap")
    if not draft.properties.has("normalmap"):
        draft.context.report.error(draft.element, 'needs <texture name="normalmap" ...>')
    _as_mitsuba_bends(draft)
    draft.put("follow_uv", False)
    _nested(draft, "bsdf")


def _bump_map(draft: Draft) -> None:
    p = draft.properties
    # Its texture may have any name.
    names = [name for name, child in p.named.items() if child.tag == "texture"]
    textures = [*p.take("texture"), *filter(None, (p.find(name) for name in names))]
    if len(textures) != 1:
        draft.context.report.error(draft.element, f"must hold one texture, got {len(textures)}")
    else:
        path = f"{draft.path}.texture"
        value = texture_value(draft.context, textures[0], path, as_number=True)
        draft.put("texture", sum(value) / 3.0 if isinstance(value, list) else value)
    draft.number("scale", 1.0)
    _as_mitsuba_bends(draft)
    _nested(draft, "bsdf")


def _as_mitsuba_bends(draft: Draft) -> None:
    """Fold normals that turn away from the viewer, and fade light out, unless told not to."""
    folded = draft.properties.flag("flip_invalid_normals", True)
    draft.put("rims", "folded" if folded else "black", "flip_invalid_normals")
    fading = draft.properties.flag("use_shadowing_function", True)
    draft.put("fading", None if fading else False, "use_shadowing_function")


def _principled(draft: Draft) -> None:
    p = draft.properties
    color_or_texture(draft, "base_color", 0.5)
    for name in ("metallic", "clearcoat", "clearcoat_gloss"):
        number_or_texture(draft, name)
    _burley_lobes(draft)
    if p.has("eta"):
        draft.number("ior", 1.5, "eta")
        if p.has("specular"):
            draft.context.report.error(draft.element, "takes either eta or specular, got both")
    else:
        specular = p.number("specular", 0.5)
        draft.put("ior", 2.0 / (1.0 - math.sqrt(0.08 * max(specular, 0.0))) - 1.0, "specular")
    rates = "main_specular_sampling_rate", "clearcoat_sampling_rate"
    p.ignore(_RATES, *rates, "diffuse_reflectance_sampling_rate")


def _principled_thin(draft: Draft) -> None:
    color_or_texture(draft, "base_color", 0.5)
    # Ours is the share itself.
    number_or_texture(draft, "through", name="diff_trans", scale=0.5)
    _burley_lobes(draft)
    draft.number("ior", 1.5, "eta")
    kinds = [f"{a}_{b}" for a in ("specular", "diffuse") for b in ("reflectance", "transmittance")]
    draft.properties.ignore(_RATES, *(f"{kind}_sampling_rate" for kind in kinds))


#: Why sampling rates play no part.
_RATES = "how often a lobe is sampled does not change the picture"


def _burley_lobes(draft: Draft) -> None:
    number_or_texture(draft, "roughness", 0.5)
    names = "anisotropic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"
    for name in names:
        number_or_texture(draft, name)


def _two_sided(draft: Draft) -> None:
    _nested(draft, "bsdf")


def _mask(draft: Draft) -> None:
    number_or_texture(draft, "opacity", 0.5)
    _nested(draft, "bsdf")


def _blend(draft: Draft) -> None:
    number_or_texture(draft, "weight", 0.5)
    if not draft.properties.has("weight"):
        draft.context.report.error(draft.element, 'needs <float name="weight" .../>')
    _nested(draft, "bsdfs", 2)


def _nothing(draft: Draft) -> None:
    pass


#: Plug-ins of Mitsuba that alight has models for: our name, and what reads the parameters.
COVERED: dict[str, tuple[str, Callable[[Draft], None]]] = {
    "blendbsdf": ("blend", _blend),
    "bumpmap": ("bump_map", _bump_map),
    "conductor": ("conductor", _conductor),
    "dielectric": ("dielectric", _dielectric),
    "diffuse": ("diffuse", _diffuse),
    "mask": ("mask", _mask),
    "normalmap": ("normal_map", _normal_map),
    "null": ("null", _nothing),
    "phong": ("phong", _phong),
    "plastic": ("plastic", _plastic),
    "principled": ("burley", _principled),
    "principledthin": ("burley_thin", _principled_thin),
    "roughconductor": ("rough_conductor", _rough_conductor),
    "roughdielectric": ("rough_dielectric", _rough_dielectric),
    "roughplastic": ("rough_plastic", rough_plastic),
    "thindielectric": ("thin_dielectric", _dielectric),
    "twosided": ("two_sided", _two_sided),
}
