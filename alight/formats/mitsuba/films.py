"""``<film>``, ``<rfilter>`` and ``<sampler>`` -> settings of the native format."""

from __future__ import annotations

import math

from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.reading.xml import Element

FILMS = ("hdrfilm", "ldrfilm")
#: Films that differ in the files that they write.
OTHER_FILMS = ("mfilm", "tiledhdrfilm", "specfilm")
SIZE = (768, 576)
SAMPLE_COUNT = 4
#: Parameters about files, not about the picture.
_OF_FILES = (
    "file_format",
    "pixel_format",
    "component_format",
    "channel_names",
    "metadata",
    "attach_log",
    "banner",
    "gamma",
    "exposure",
    "tonemap_method",
    "label",
)

_OF_BORDERS = ("sample_border", "high_quality_edges", "compensate")

#: Our samplers, and whether they are made of squares of strata.
SAMPLERS = {
    "independent": ("independent", False),
    "stratified": ("stratified", True),
    "multijitter": ("multijittered", True),
    "halton": ("halton", False),
    "sobol": ("sobol", False),
    "ldsampler": ("sobol", False),
    "orthogonal": ("sobol", False),
    "hammersley": ("halton", False),
}
_SAME = ("independent", "stratified", "multijitter", "halton", "sobol")


def film(context: Context, element: Element | None) -> Data:
    """Convert a film; Mitsuba's default without one."""
    if element is None:
        return {"size": list(SIZE), "filter": _filter(context, None)}
    if element.type in OTHER_FILMS:
        context.report.note(element, "is about files, see the options of the command line")
    elif element.type not in FILMS:
        context.report.unknown(element, "film", element.type, FILMS, "hdrfilm is taken")
    draft = Draft(context, element, "film")
    p = draft.properties
    p.ignore("it is about files, see the options of the command line", *_OF_FILES)
    p.ignore(
        "samples count for one pixel each", "sample_border", "high_quality_edges", "compensate"
    )
    size = [p.integer("width", SIZE[0]), p.integer("height", SIZE[1])]
    draft.put("size", size, "width")
    crop = [
        p.integer("crop_offset_x", 0),
        p.integer("crop_offset_y", 0),
        p.integer("crop_width", size[0]),
        p.integer("crop_height", size[1]),
    ]
    if crop != [0, 0, *size]:
        draft.put("crop", crop, "crop_width")
    filters = p.take("rfilter")
    for surplus in filters[1:]:
        context.report.error(surplus, "a film has one filter at most")
    draft.put("filter", _filter(context, filters[0] if filters else None))
    p.finish()
    return draft.data


def _filter(context: Context, element: Element | None) -> Data:
    gaussian: Data = {"type": "gaussian", "stddev": 0.5, "radius": 2.0}
    if element is None:
        return gaussian
    known = ("box", "tent", "gaussian", "mitchell", "catmullrom")
    kind = element.type
    if kind not in known:
        context.report.unknown(element, "filter", element.type, known, "gaussian is taken")
        return gaussian
    native = "mitchell" if kind == "catmullrom" else kind
    draft = Draft(context, element, "film.filter", native)
    p = draft.properties
    if kind == "box" and element.old:
        draft.number("radius")
    elif kind == "tent":
        draft.number("radius", 1.0)
    elif kind == "gaussian":
        stddev = p.number("stddev", 0.5)
        draft.put("stddev", stddev)
        draft.put("radius", 4.0 * stddev, "stddev")
    elif kind == "mitchell":
        # Spelt in capitals in Mitsuba 3.
        draft.number("b", 1.0 / 3.0, "b" if element.old else "B")
        draft.number("c", 1.0 / 3.0, "c" if element.old else "C")
    elif kind == "catmullrom":
        draft.data |= {"b": 0.0, "c": 0.5}
    p.finish()
    return draft.data


def sampler(context: Context, element: Element | None) -> tuple[int | None, Data]:
    """Convert a sampler.

    Returns
    -------
    spp : int or None
        Samples per pixel.
    sampler : dict
    """
    if element is None:
        return SAMPLE_COUNT, {"type": "independent"}
    kind = element.type
    if kind not in SAMPLERS:
        context.report.unknown(element, "sampler", element.type, SAMPLERS, "independent is taken")
    native, has_strata = SAMPLERS.get(kind, ("independent", False))
    draft = Draft(context, element, "sampler", native)
    p = draft.properties
    if kind in SAMPLERS and kind not in _SAME:
        context.report.note(element, f"becomes {native}: the same picture, other noise")
    count = p.integer("sample_count", SAMPLE_COUNT)
    if count is not None and not 1 <= count < 2**31:
        source = p.named["sample_count"]
        context.report.error(source, f"must be in [1, {2**31 - 1}], got {count}")
        count = SAMPLE_COUNT
    p.ignore("it is an option of the command line", "seed")
    p.ignore("dimensions have no limit", "dimension", "scramble", "strength", "subdivisions")
    if has_strata:
        p.only("jitter", True, "samples are always jittered")
        draft.put("strata", max(1, min(1024, round(math.sqrt(count or 1)))), "sample_count")
    else:
        p.ignore("samples are always jittered", "jitter")
    p.finish()
    return count, draft.data
