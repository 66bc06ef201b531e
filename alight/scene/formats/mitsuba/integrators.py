"""``<integrator>`` -> integrators of the native format."""

from __future__ import annotations

from alight.scene.formats.mitsuba.context import Context, Data
from alight.scene.formats.mitsuba.draft import Draft
from alight.scene.formats.mitsuba.elements import Element
from alight.scene.formats.mitsuba.interiors import SEEING

#: Integrators that hold another one, and why nothing is lost without them.
WRAPPERS = {
    "moment": "is taken off: the variance of every pixel is part of every film",
    "aov": "is taken off: layers are asked for with --aov",
}
#: Integrators that follow paths; without media they agree.
PATHS = ("path", *SEEING)
COVERED = (*PATHS, "direct", *WRAPPERS)


def convert(context: Context, element: Element) -> Data | None:
    """Convert an integrator; None for the default."""
    kind = element.type
    if kind in WRAPPERS:
        return _unwrapped(context, element)
    if kind not in COVERED:
        context.report.unknown(element, "integrator", COVERED, "path is taken")
        return {"type": "path"}
    draft = Draft(context, element, "integrator", "direct" if kind == "direct" else "path")
    p = draft.properties
    if p.flag("hide_emitters"):
        draft.put("hide_emitters", True)
    p.ignore("it is an option of the command line", "block_size", "samples_per_pass", "timeout")
    if kind == "direct":
        _direct(draft)
    else:
        depth = p.integer("max_depth", -1)
        draft.put("max_depth", None if depth == -1 else depth)
        draft.put("rr_depth", p.integer("rr_depth", 5))
        if draft.element.old:
            p.only("strict_normals", False, "shading normals are taken as they are")
    p.finish()
    return draft.data


def sees_media(elements: list[Element]) -> bool:
    """Whether the integrator of a file, perhaps inside another one, knows of media."""
    for element in elements[:1]:
        inner = [child for child in element.children if child.tag == "integrator"]
        return element.type in SEEING or (element.type in WRAPPERS and sees_media(inner))
    return False


def for_media(description: Data | None) -> Data:
    """The integrator of a scene in which there are media."""
    return {**(description or {}), "type": "volpath"}


def _unwrapped(context: Context, element: Element) -> Data | None:
    draft = Draft(context, element, "integrator")
    p = draft.properties
    context.report.note(element, WRAPPERS[element.type])
    p.ignore("layers are asked for with --aov", "aovs")
    p.only("hide_emitters", False, "lights are seen")
    inner = p.take("integrator")
    p.finish()
    if len(inner) != 1:
        text = f"must hold one integrator, got {len(inner)}"
        context.report.not_covered(element, text, "path is taken")
        return {"type": "path"}
    return convert(context, inner[0])


def _direct(draft: Draft) -> None:
    """Choose the way to find light that Mitsuba's numbers of samples stand for."""
    p, report = draft.properties, draft.context.report
    shading = p.integer("shading_samples", 1)
    light = p.integer("emitter_samples", shading)
    bsdf = p.integer("bsdf_samples", shading)
    if not light and not bsdf:
        report.error(draft.element, "needs emitter_samples or bsdf_samples > 0")
    elif max(light or 0, bsdf or 0) > 1:
        report.note(draft.element, "takes one sample of each kind: the same picture, other noise")
    if light and not bsdf:
        draft.put("light_sampling", "emitter", "bsdf_samples")
    elif bsdf and not light:
        draft.put("light_sampling", "bsdf", "emitter_samples")
