"""``<integrator>`` -> integrators of the native format."""

from __future__ import annotations

from contextlib import suppress

from alight.core.errors import quote
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.interiors import SEEING
from alight.formats.reading.numbers import NotNumbersError, parse_integer
from alight.formats.reading.xml import Element

#: Integrators that hold another one, and why nothing is lost without them.
WRAPPERS = {
    "moment": "is taken off: the variance of every pixel is part of every film",
    "aov": "is taken off: layers are asked for with --aov",
    "multichannel": "is taken off: layers are asked for with --aov",
    "stokes": "is taken off: nothing is polarized",
    "adaptive": "is taken off: --error does the same",
    "irrcache": "is taken off: nothing is cached",
}
#: Integrators that start at lights too, and so find caustics of lights without a size.
FROM_LIGHTS = (
    "bdpt", "erpt", "mlt", "photonmapper", "ppm", "pssmlt", "ptracer", "sppm", "vpl",
)  # fmt: skip
#: Integrators that show one layer and no light.
LAYERS = ("depth", "field")
#: Other names of paths: 0.6's, and those of Mitsuba 3 for derivatives.
ALIASES = {
    "volpath_simple": "volpath", "prb": "path", "prb_basic": "path", "prb_projective": "path",
    "prbvolpath": "volpath", "direct_projective": "direct", "emission": "direct",
}  # fmt: skip
#: Integrators that follow paths; without media they agree.
PATHS = ("path", *SEEING)
#: Edges of the longest path that the native format can ask for.
LONGEST = 4000
COVERED = (*PATHS, "direct", *WRAPPERS, *FROM_LIGHTS, *LAYERS, *ALIASES)


def convert(context: Context, element: Element) -> Data | None:
    """Convert an integrator; None for the default."""
    kind = ALIASES.get(element.type, element.type)
    if kind in WRAPPERS:
        return _unwrapped(context, element)
    if kind in LAYERS:
        context.report.warn(element, "shows a layer: path is taken, and --aov asks for layers")
        return {"type": "path"}
    if kind not in COVERED:
        text = "path is taken, with its max_depth and rr_depth"
        context.report.unknown(element, "integrator", element.type, COVERED, text)
    draft = Draft(context, element, "integrator", "direct" if kind == "direct" else "path")
    p = draft.properties
    if kind not in COVERED:
        _read_unknown(draft)
        return draft.data
    if p.flag("hide_emitters"):
        draft.put("hide_emitters", True)
    p.ignore("it is an option of the command line", "block_size", "samples_per_pass", "timeout")
    if kind in FROM_LIGHTS:
        text = "becomes path, which finds no caustics of lights without a size (point, spot, ...)"
        context.report.warn(element, text)
        known = ("max_depth", "rr_depth", *p.asked)
        others = [name for name in p.named if name not in known]
        p.ignore("path has no such parameter", *others)
    if kind == "direct":
        _direct(draft)
    else:
        depth = p.integer("max_depth", -1)
        draft.put("max_depth", None if depth == -1 else depth)
        draft.put("rr_depth", p.integer("rr_depth", 5))
        if draft.element.old and p.flag("strict_normals"):
            text = "is left out: shading normals are taken as they are"
            context.report.warn(p.named["strict_normals"], text)
    p.finish()
    return draft.data


def _read_unknown(draft: Draft) -> None:
    """Keep what a program that is derived from Mitsuba says as Mitsuba does; it may mean more."""
    named = draft.properties.named
    hidden = named.get("hide_emitters")
    if hidden is not None and hidden.attributes.get("value") == "true":
        draft.put("hide_emitters", True)
    draft.put("rr_depth", 5)
    for name in ("max_depth", "rr_depth"):
        text = named[name].attributes.get("value", "") if name in named else "-1"
        depth = 0
        with suppress(NotNumbersError):
            depth = parse_integer(text)
        if 1 <= depth <= LONGEST:
            draft.put(name, depth)
        elif depth != -1:
            wanted = f"is left out: must be in [1, {LONGEST}], got {quote(text)}"
            draft.context.report.warn(named[name], wanted)


#: Wrappers whose parameters do not change the picture.
_BLIND = ("adaptive", "irrcache", "stokes")


def sees_media(elements: list[Element]) -> bool:
    """Whether the integrator of a file, perhaps inside another one, knows of media."""
    for element in elements[:1]:
        inner = [child for child in element.children if child.tag == "integrator"]
        return ALIASES.get(element.type, element.type) in SEEING or (
            element.type in WRAPPERS and sees_media(inner)
        )
    return False


def for_media(description: Data | None) -> Data:
    """The integrator of a scene in which there are media."""
    return {**(description or {}), "type": "volpath"}


def _unwrapped(context: Context, element: Element) -> Data | None:
    draft = Draft(context, element, "integrator")
    p = draft.properties
    context.report.note(element, WRAPPERS[element.type])
    p.ignore("layers are asked for with --aov", "aovs")
    p.ignore(WRAPPERS[element.type], *(name for name in p.named if element.type in _BLIND))
    p.only("hide_emitters", False, "lights are seen")
    inner = p.take("integrator")
    p.finish()
    if not inner and element.type == "aov":
        context.report.warn(element, "shows layers alone: path is taken, and --aov asks for layers")
        return {"type": "path"}
    if len(inner) != 1 and not (inner and element.type == "multichannel"):
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
