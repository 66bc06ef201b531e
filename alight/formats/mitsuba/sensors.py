"""``<sensor>`` with film, filter and sampler -> camera, film and sampler of the native format."""

from __future__ import annotations

import math
import re

from alight.core.errors import quote
from alight.formats.mitsuba import interiors
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.films import film, sampler
from alight.formats.mitsuba.transforms import motion_of
from alight.formats.reading.numbers import NotNumbersError, parse_number
from alight.formats.reading.xml import Element
from alight.formats.scenes.cameras import Parallel, Perspective, angle_of

COVERED = ("perspective", "thinlens", "orthographic")
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
        context.report.unknown(
            element, "sensor", element.type, COVERED, "a perspective camera is taken"
        )
        kind = "perspective"
    draft = Draft(context, element, "camera")
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
        # A film without columns is refused where all films are checked.
        seen: Parallel | Perspective = Parallel(2.0 * height / max(width, 1))
    else:
        seen = Perspective(*_field_of_view(draft), *_lens(draft, kind))
    said_by = {} if p.has("fov") else {"fov": "focal_length", "fov_axis": "focal_length"}
    description = seen.data()
    draft.data["type"] = description.pop("type")
    for key, value in description.items():
        draft.put(key, value, said_by.get(key))
    if kind != "thinlens":
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


def _lens(draft: Draft, kind: str) -> tuple[float | None, float | None]:
    """Radius of the lens and the distance that it is focused at."""
    p = draft.properties
    if kind != "thinlens":
        return None, None
    if not p.has("aperture_radius"):
        draft.context.report.error(draft.element, 'needs <float name="aperture_radius" .../>')
    # The planes that cut away are ignored, but for this.
    return p.number("aperture_radius", 0.0), p.number("focus_distance", p.number("far_clip", 1e4))


def _field_of_view(draft: Draft) -> tuple[float, str]:
    """Opening angle in degrees, and the side of the picture that it spans."""
    p, report = draft.properties, draft.context.report
    focal = p.value("focal_length", "string")
    if p.has("fov"):
        if focal is not None:
            report.error(draft.element, "takes either fov or focal_length, got both")
        return p.number("fov", 45.0), p.text("fov_axis", "x", AXES)
    millimetres = 50.0
    if focal is not None:
        try:
            millimetres = _millimetres(focal[1])
        except NotNumbersError as error:
            report.error(focal[0], str(error))
    return angle_of(FILM_DIAGONAL, millimetres), "diagonal"


def _millimetres(text: str) -> float:
    found = re.fullmatch(r"\s*(\S+?)\s*(?:mm)?\s*", text)
    number = parse_number(found[1]) if found else 0.0
    if not 1e-3 <= number <= 1e6:
        raise NotNumbersError(f"must be a length in mm as 50mm, got {quote(text)}")
    return number
