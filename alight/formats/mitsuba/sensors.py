"""``<sensor>`` with film, filter and sampler -> camera, film and sampler of the native format."""

from __future__ import annotations

import math
import re

from alight.core.errors import quote
from alight.formats.mitsuba import interiors
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.elements import Element
from alight.formats.mitsuba.films import film, sampler
from alight.formats.mitsuba.transforms import motion_of
from alight.formats.mitsuba.values import NotNumbersError, parse_number

#: Our names of the cameras.
COVERED = {"perspective": "pinhole", "thinlens": "thin_lens", "orthographic": "orthographic"}
AXES = ("x", "y", "diagonal", "smaller", "larger")
#: Diagonal of a 35 mm film, mm.
FILM_DIAGONAL = math.hypot(36.0, 24.0)


def convert(context: Context, element: Element, data: Data) -> int | None:
    """Put camera, film and sampler into the description of a scene.

    Returns
    -------
    int or None
        Samples per pixel.
    """
    kind = element.type
    if kind not in COVERED:
        context.report.unknown(element, "sensor", COVERED, "a perspective camera is taken")
        kind = "perspective"
    draft = Draft(context, element, "camera", COVERED[kind])
    p = draft.properties
    films, samplers = p.take("film"), p.take("sampler")
    interiors.of_camera(draft)
    for surplus in (*films[1:], *samplers[1:]):
        context.report.error(surplus, "a sensor has one film and one sampler at most")
    data["film"] = film(context, films[0] if films else None)
    p.ignore("the camera sees things at any distance", "near_clip", "far_clip")
    p.ignore("textures are not prefiltered", "cone_scale")
    p.ignore("samples are always jittered", "jitter")
    for name in ("rolling_shutter_type", "rolling_shutter_duration"):
        rolling = p.find(name)
        if rolling is not None and context.moves:
            text = "is left out: all rows are exposed at the same time"
            context.report.warn(rolling, text)
    _shutter(draft)
    _centred(draft)
    _, transform = motion_of(p, of_camera=True)
    if kind == "orthographic":
        width, height = data["film"]["size"]
        draft.put("height", 2.0 * height / width)
    else:
        _field_of_view(draft)
    if kind == "thinlens":
        draft.number("aperture_radius")
        if "aperture_radius" not in draft.data:
            context.report.error(element, 'needs <float name="aperture_radius" .../>')
        draft.number("focus_distance", 1.0)
    else:
        p.ignore("without a lens everything is sharp", "focus_distance", "aperture_radius")
    draft.put("transform", transform, "to_world")
    p.finish()
    data["camera"] = draft.data
    spp, data["sampler"] = sampler(context, samplers[0] if samplers else None)
    return spp


def _shutter(draft: Draft) -> None:
    """When the shutter opens and closes; at once, unless the file says."""
    p, report = draft.properties, draft.context.report
    if not draft.context.moves:
        p.ignore("nothing moves", "shutter_open", "shutter_close")
        return
    begin, end = p.number("shutter_open", 0.0), p.number("shutter_close", 0.0)
    assert begin is not None
    assert end is not None
    if end < begin:
        element = p.named.get("shutter_close", draft.element)
        report.error(element, f"must not be before shutter_open, {begin:g}, got {end:g}")
        return
    draft.put("shutter", [begin, end], "shutter_close")
    if end == begin:
        report.warn(draft.element, "its shutter closes as it opens: what moves is sharp")


def _centred(draft: Draft) -> None:
    """Refuse a picture whose middle is not where the camera looks."""
    for axis in "xy":
        name = f"principal_point_offset_{axis}"
        if draft.properties.number(name):
            element = draft.properties.named[name]
            text = "is not covered: the camera looks at the middle of the film"
            draft.context.report.not_covered(element, text, "0 is taken")


def _field_of_view(draft: Draft) -> None:
    p, report = draft.properties, draft.context.report
    focal = p.value("focal_length", "string")
    if p.has("fov"):
        draft.number("fov")
        draft.put("fov_axis", p.text("fov_axis", "x", AXES))
        if focal is not None:
            report.error(draft.element, "takes either fov or focal_length, got both")
        return
    millimetres = 50.0
    if focal is not None:
        try:
            millimetres = _millimetres(focal[1])
        except NotNumbersError as error:
            report.error(focal[0], str(error))
    fov = 2.0 * math.degrees(math.atan(FILM_DIAGONAL / (2.0 * millimetres)))
    draft.put("fov", fov, "focal_length")
    draft.put("fov_axis", "diagonal", "focal_length")


def _millimetres(text: str) -> float:
    found = re.fullmatch(r"\s*(\S+?)\s*(?:mm)?\s*", text)
    number = parse_number(found[1]) if found else 0.0
    if not 1e-3 <= number <= 1e6:
        raise NotNumbersError(f"must be a length in mm as 50mm, got {quote(text)}")
    return number
