"""``<emitter>`` -> lights of the native format."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from alight.core.errors import join_path
from alight.formats.materials.textures import DARK, GREY_SKY
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.daylight import sky_and_sun
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.projectors import projector, steps_of_cone, textured_spot
from alight.formats.mitsuba.properties import COLORS
from alight.formats.mitsuba.textures import NUMBERS, texture_value
from alight.formats.mitsuba.transforms import Step, steps_of
from alight.formats.reading.reach import OutOfReachError
from alight.formats.reading.xml import Element

#: How lights are chosen is not the file's business; the picture is the same.
_UNUSED = ("sampling_weight",)
#: Why a light need not know where it stands.
LIT_MEDIUM = "shadow rays find the media on their way by the borders that they cross"


def area_light(context: Context, element: Element, path: str) -> Data | None:
    """Convert the emitter of a shape."""
    if element.type != "area":
        text = f"a shape takes an area emitter, got {element.label}"
        context.report.not_covered(element, text, "left out")
        return None
    draft = Draft(context, element, path, "area")
    p = draft.properties
    p.ignore("lights are chosen by their power", *_UNUSED)
    radiance = p.find("radiance")
    if radiance is not None and radiance.tag not in (*COLORS, *NUMBERS):
        draft.put("radiance", texture_value(context, radiance, join_path(path, "radiance")))
    else:
        draft.color("radiance", 1.0)
    p.finish()
    return draft.data


def node_light(context: Context, element: Element, path: str) -> Data | None:
    """Convert an emitter with a place of its own to a node."""
    draft = Draft(context, element, path)
    p = draft.properties
    p.ignore("lights are chosen by their power", *_UNUSED)
    light = Draft(context, element, join_path(path, "light"), element.type)
    light.properties = p
    steps = NODES[element.type](light)
    for medium in p.take("medium"):
        context.report.note(medium, LIT_MEDIUM)
    p.ignore(LIT_MEDIUM, "medium")
    p.finish()
    draft.put("transform", steps or None, "to_world")
    draft.put("light", light.data)
    return draft.data


def _point(light: Draft) -> list[Step]:
    steps = _steps_or(light, "position")
    position = light.properties.triple("position")
    light.color("intensity", 1.0)
    return steps if position is None else [{"translate": position}]


def _directional(light: Draft) -> list[Step]:
    steps = _steps_or(light, "direction")
    direction = light.properties.triple("direction")
    light.color("irradiance", 1.0)
    if direction is None:
        return steps
    if not any(direction):
        element = light.properties.named["direction"]
        light.context.report.error(element, "must not have length 0")
        return []
    return [_turned_to(direction)]


def _spot(light: Draft) -> list[Step]:
    steps = steps_of_cone(light)
    light.color("intensity", 1.0)
    light.number("cutoff_angle", 20.0)
    light.number("beam_width")
    texture = light.properties.find("texture")
    return steps if texture is None else textured_spot(light, texture, steps)


def _steps_or(light: Draft, name: str) -> list[Step]:
    """Ask for the transform, which must not stand beside the parameter `name`."""
    p = light.properties
    if p.has(name) and p.has("to_world"):
        light.context.report.error(light.element, f"takes either {name} or to_world, got both")
    return steps_of(p)


def _turned_to(direction: list[float]) -> Step:
    """A rotation that takes +z, along which the light travels, to a direction."""
    view = np.array(direction) / math.hypot(*direction)
    # Our look_at turns -z to the target. Any axis that is not parallel will do as up.
    up = np.eye(3)[int(np.argmin(np.abs(view)))]
    return {"look_at": {"origin": [0.0] * 3, "target": (-view).tolist(), "up": up.tolist()}}


def constant(context: Context, element: Element) -> Data:
    """Convert the same light from everywhere."""
    draft = Draft(context, element, "environment", "constant")
    draft.properties.ignore("lights are chosen by their power", *_UNUSED)
    draft.color("radiance", 1.0)
    draft.properties.finish()
    return draft.data


def _map(light: Draft) -> list[Step]:
    p, report = light.properties, light.context.report
    light.data["type"] = "environment"
    p.ignore("it does not change the picture", "mis_compensation", "cache", "gamma")
    steps = steps_of(p)
    light.number("scale")
    found = p.value("filename", "string")
    try:
        if found is not None:
            reach = light.context.reach
            light.put("file", reach.name_of(reach.find(found[1])), "filename")
        elif not p.has("filename"):
            report.error(light.element, 'needs <string name="filename" .../>')
    except OutOfReachError as error:
        assert found is not None
        report.lacks(found[0], error, DARK)
    if "file" not in light.data:
        light.data = {"type": "constant", "radiance": GREY_SKY}
    return steps


def unknown(context: Context, element: Element) -> None:
    """Report an emitter that is not covered, unless shapes refer to it."""
    if element.type == "area" and "id" in element:
        context.report.note(element, "shines where a shape refers to it")
        return
    known = (*NODES, "constant", "area (on a shape)")
    context.report.unknown(element, "emitter", element.type, known, "left out")


#: Emitters with a node of their own.
NODES: dict[str, Callable[[Draft], list[Step]]] = {
    "point": _point,
    "directional": _directional,
    "spot": _spot,
    "envmap": _map,
    "projector": projector,
    "sunsky": sky_and_sun,
    "sky": sky_and_sun,
    "sun": sky_and_sun,
}
