"""``<emitter type="projector">``, and spots with a texture -> projectors of the native format."""

from __future__ import annotations

import math

import numpy as np

from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.properties import COLORS, Properties
from alight.formats.mitsuba.transforms import Step, matrix_of, steps_of
from alight.formats.reading.reach import OutOfReachError
from alight.formats.reading.xml import Element

#: Lengths of axes that differ by less are the same.
_EVEN = 1.001


def steps_of_cone(light: Draft) -> list[Step]:
    """The steps of a light that shines into a cone, which they move and turn, but do not deform."""
    steps = steps_of(light.properties)
    lengths = np.linalg.norm(matrix_of(steps)[:3, :3], axis=0)
    if lengths.max() > _EVEN * lengths.min():
        light.context.report.warn(
            light.element, "has an uneven scale, which does not deform its cone here"
        )
    return steps


def projector(light: Draft) -> list[Step]:
    """Fill in a projector; the steps of its node."""
    p = light.properties
    steps = steps_of_cone(light)
    light.number("fov", 45.0)
    p.only("fov_axis", p.text("fov_axis", "x") == "x", "the angle is taken across the width")
    # Mitsuba's projector throws pi times its picture on a screen at distance 1.
    light.data["scale"] = [math.pi * p.number("scale", 1.0)] * 3
    _picture(light, p.find("irradiance"))
    return steps


def textured_spot(light: Draft, texture: Element, steps: list[Step]) -> list[Step]:
    """Turn a spot, whose numbers have been read, into a projector with a cutoff."""
    spot = light.data
    cutoff = min(float(spot["cutoff_angle"]), 89.0)
    light.data = {
        "type": "projector",
        "scale": spot["intensity"],
        "fov": 2.0 * cutoff,
        "aspect": 1.0,
        "evenness": "intensity",
        "cutoff_angle": cutoff,
        "beam_width": spot.get("beam_width", 0.75 * cutoff),
    }
    _picture(light, texture)
    # A spot's texture hangs upside down there.
    return [{"rotate": {"axis": "z", "angle": 180.0}}, *steps]


def _picture(light: Draft, element: Element | None) -> None:
    context = light.context
    if element is None or element.tag in (*COLORS, "float"):
        color = None if element is None else context.colors.read(element, "light")
        light.data["pixels"] = [[list(color or [1.0] * 3)]]
        return
    light.data["pixels"] = [[[1.0] * 3]]
    target = context.target(element, "texture")
    if target is None:
        return
    if target.type != "bitmap":
        text = f"a projector takes a bitmap here, got {target.label}"
        context.report.not_covered(target, text, "white is taken")
        return
    p = Properties(target, context.report)
    p.ignore("the picture is interpolated, and dark beyond its edges", "filter_type", "wrap_mode")
    p.ignore("the file says how it is encoded", "raw", "format")
    found = p.value("filename", "string")
    try:
        if found is None:
            context.report.error(target, 'needs <string name="filename" .../>')
        else:
            light.data["file"] = context.reach.name_of(context.reach.find(found[1]))
            del light.data["pixels"]
    except OutOfReachError as error:
        assert found is not None
        context.report.error(found[0], str(error))
    p.finish()
