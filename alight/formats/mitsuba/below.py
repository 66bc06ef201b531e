"""``<subsurface>`` of Mitsuba 0.6 -> a coat over a matte base of the same colour."""

from __future__ import annotations

from alight.formats.materials.substances import SUBSTANCES, diffuse_reflectance
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.reading.xml import Element

#: The medium of a file that names none.
USUAL = "Skin1"
INDEX = 1.3


def scattering(context: Context, element: Element) -> Data:
    """Convert what is below a surface; it takes the place of the surface's material."""
    draft = Draft(context, element, "")
    p, report = draft.properties, context.report
    by_name = {name.lower(): pair for name, pair in SUBSTANCES.items()}
    name = p.text("material", USUAL).lower()
    if name not in by_name:
        report.warn(p.named["material"], f"is not known: {USUAL} is taken")
    scattered, absorbed = by_name.get(name, SUBSTANCES[USUAL])
    draft.color("sigma_s", role="index")
    draft.color("sigma_a", role="index")
    scattered, absorbed = draft.data.get("sigma_s", scattered), draft.data.get("sigma_a", absorbed)
    if p.has("albedo"):
        draft.color("albedo", role="reflectance")
        albedo = draft.data.get("albedo", [0.5] * 3)
        scattered, absorbed = albedo, [1.0 - channel for channel in albedo]
    p.ignore("light leaves where it enters", "scale", "irr_samples", "sigma_t", "g", "fast")
    p.ignore("light leaves where it enters", "int_ior", "ext_ior", "irr_indirect", "quality")
    p.finish()
    report.warn(element, "scatters below the surface: a coat over a matte base is taken")
    pairs = zip(absorbed, scattered, strict=True)
    color = [diffuse_reflectance(a, s, INDEX) for a, s in pairs]
    coat: Data = {"type": "plastic", "diffuse_reflectance": color, "int_ior": INDEX, "ext_ior": 1.0}
    return {"type": "two_sided", "bsdf": {**coat, "nonlinear": True}}
