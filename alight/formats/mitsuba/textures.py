"""``<texture>`` -> textures of the native format.

Texture coordinates are Mitsuba's throughout: pictures hang with v downwards, and so meshes of OBJ
files have theirs turned over when they are read. Our bitmaps have v upwards, which a last step of
``to_uv`` mends.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.formats.materials.textures import CHECKERED, FLAT, LEVEL, MISSING
from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.properties import COLORS
from alight.formats.mitsuba.transforms import matrix_of, steps_of
from alight.formats.reading.reach import OutOfReachError
from alight.formats.reading.xml import Element

#: What takes the place of a texture that is not covered.
GREY = [0.5, 0.5, 0.5]
NUMBERS = ("float", "integer")
#: The attribute of meshes that alight knows.
VERTEX_COLOR = "vertex_color"
Value = str | Data | list[float] | None


def color_or_texture(
    draft: Draft, key: str, default: float | None = None, name: str | None = None
) -> None:
    """Set a key to a reflectance that may vary over the surface."""
    element = draft.properties.find(name or key)
    value: Value = None
    if element is not None:
        value = texture_value(draft.context, element, f"{draft.path}.{key}")
    if value is None and default is not None:
        value = [default] * 3
    draft.put(key, value, name)


def normals(draft: Draft, key: str, name: str) -> None:
    """Set a key to a normal map, a flat one where its picture is missing."""
    element, context = draft.properties.named.get(name), draft.context
    target = None
    if element is not None and element.tag in ("texture", "ref") and context.report.lenient:
        target = context.target(element, "texture")
    pictures = [child for child in target.children if child.name == "filename"] if target else []
    if target is not None and target.type == "bitmap" and pictures:
        try:
            context.reach.find(pictures[0].attributes.get("value", ""))
        except OutOfReachError as error:
            context.report.lacks(pictures[0], error, FLAT)
            draft.properties.find(name)
            draft.put(key, {"type": "constant", "color": LEVEL}, name)
            return
    color_or_texture(draft, key, name=name)


def number_or_texture(
    draft: Draft,
    key: str,
    default: float | None = None,
    name: str | None = None,
    scale: float = 1.0,
) -> None:
    """Set a key to a number that may vary over the surface, times a scale."""
    element = draft.properties.find(name or key)
    if element is None or element.tag in NUMBERS:
        number = draft.properties.number(name or key, default)
        draft.put(key, None if number is None else scale * number, name)
        return
    path = f"{draft.path}.{key}"
    value = texture_value(draft.context, element, path, as_number=True, scale=scale)
    if isinstance(value, list):
        if len(set(value)) > 1:
            draft.context.report.error(element, "must be one number, got a colour")
        value = value[0]  # pyright: ignore[reportAssignmentType]
    draft.put(key, default if value is None else value, name)


def texture_value(
    context: Context, element: Element, path: str, as_number: bool = False, scale: float = 1.0
) -> Value:
    """Read what gives a colour on a surface: numbers, a texture, or a reference to one.

    Parameters
    ----------
    as_number : bool, default False
        Whether a number is wanted, for which Mitsuba looks textures up in another way.
    scale : float, default 1
        Factor of checkerboards; other textures must do without.
    """
    if element.tag in (*COLORS, *NUMBERS):
        return context.colors.read(element, "reflectance")
    if element.tag not in ("texture", "ref"):
        wanted = "a colour or a <texture>"
        context.report.error(element, f"must be {wanted}, got <{element.tag}>")
        return None
    target = context.target(element, "texture")
    if target is None:
        return None
    if target.type not in COVERED:
        context.report.unknown(target, "texture", target.type, COVERED, "grey 0.5 is taken")
        return GREY
    swapped = as_number and target.type == "checkerboard"

    def build(path: str) -> Data:
        data = _build(context, target, path)
        # Mitsuba 3's checkerboard has its colours the other way round where it gives a number.
        if swapped:
            data = {**data, "color0": data["color1"], "color1": data["color0"]}
        if scale != 1.0:
            colors = {key: data[key] for key in ("color0", "color1", "color") if key in data}
            if not colors:
                text = f"is not covered: only checkerboards can be multiplied by {scale:g}"
                context.report.not_covered(target, text, "taken as it is")
            data |= {key: [scale * channel for channel in c] for key, c in colors.items()}
        return data

    if "id" in target:
        variant = (" as number" if swapped else "") + (f" times {scale:g}" if scale != 1.0 else "")
        return context.named("textures", target, build, variant)
    return build(path)


def _build(context: Context, element: Element, path: str) -> Data:
    if not context.enter(element):
        return {"type": "constant"}
    data = COVERED[element.type](context, element, path)
    context.leave()
    return data


def _bitmap(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "bitmap")
    p = draft.properties
    # Some filters blur what is far away; many samples do the same.
    blurred = ("ewa", "trilinear", "anisotropic")
    filters = {"bilinear": "bilinear", "nearest": "nearest", **dict.fromkeys(blurred, "bilinear")}
    p.ignore("there is no prefiltering", "max_anisotropy", "cache")
    channel, is_linear = "", False
    if element.old:
        is_linear = _is_linear(draft)
        channel = p.text("channel", "", ("r", "g", "b", "a", ""))
    p.ignore("texels keep the precision of the file", "format")
    found = p.value("filename", "string")
    if found is None:
        if not p.has("filename"):
            context.report.error(element, 'needs <string name="filename" .../>')
        draft.data = {"type": "constant"}
    else:
        try:
            draft.put("file", context.reach.name_of(context.reach.find(found[1])), "filename")
        except OutOfReachError as error:
            is_color = not p.flag("raw", is_linear)
            context.report.lacks(found[0], error, CHECKERED if is_color else FLAT)
            draft.data = {"type": "constant", "color": LEVEL}
            if is_color:
                draft.data = {"type": "bitmap", "pixels": MISSING}
    raw = p.flag("raw", is_linear)
    kind = filters[p.text("filter_type", "bilinear", tuple(filters))]
    wrap = p.text("wrap_mode", "repeat", ("repeat", "mirror", "clamp"))
    steps = _uv_steps(draft)
    p.finish()
    if draft.data["type"] == "constant":
        return draft.data
    draft.put("color_space", "linear" if raw else None, "raw")
    draft.put("interpolation", kind if kind != "bilinear" else None, "filter_type")
    draft.put("wrap", wrap if wrap != "repeat" else None, "wrap_mode")
    draft.put("to_uv", [*steps, {"scale": [1.0, -1.0]}, {"translate": [0.0, 1.0]}])
    if channel:
        return {"type": "channel", "texture": draft.data, "channel": channel}
    return draft.data


def _is_linear(draft: Draft) -> bool:
    """Whether a picture of version 0.6 is linear: `gamma` is 1 then, and -1 for the curve of sRGB.

    Other exponents, 2.2 most of all, are nearly that curve.
    """
    p = draft.properties
    gamma = p.number("gamma", 0.0)
    if gamma not in (0.0, 1.0, -1.0) and (found := p.find("gamma")) is not None:
        draft.context.report.warn(found, "is a power: the curve of sRGB is taken")
    return gamma == 1.0


def _checkerboard(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "checkerboard")
    draft.color("color0", 0.4, role="reflectance")
    draft.color("color1", 0.2, role="reflectance")
    # Two squares of Mitsuba's share a unit of u, one of ours.
    draft.put("scale", 2.0)
    draft.put("to_uv", _uv_steps(draft) or None)
    draft.properties.finish()
    return draft.data


def _scaled(context: Context, element: Element, path: str) -> Data:
    """``scale`` of 0.6: a texture times a number or a colour."""
    draft = Draft(context, element, path, "multiply")
    p = draft.properties
    inner = [*p.take("texture"), *filter(None, (p.find("value"), p.find("texture")))]
    factor = p.find("scale")
    value: Value = [1.0] * 3
    if len(inner) == 1:
        value = texture_value(context, inner[0], f"{path}.a")
    else:
        context.report.error(element, f"must hold one texture, got {len(inner)}")
    draft.data["a"] = [1.0] * 3 if value is None else value
    found = None if factor is None else context.colors.read(factor, "index")
    draft.data["b"] = [1.0] * 3 if found is None else found
    p.finish()
    return draft.data


def _grid_lines(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "constant")
    draft.color("color", 0.2, "color0", "reflectance")
    draft.properties.find("color1")
    draft.properties.ignore("there are no lines", "line_width", "uscale", "vscale")
    draft.properties.ignore("there are no lines", "uoffset", "voffset")
    context.report.warn(element, "is not covered: the colour between its lines is taken")
    draft.properties.finish()
    return draft.data


def _vertex_colors(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "vertex_color")
    draft.properties.finish()
    return draft.data


def _raw_constant(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "constant")
    p = draft.properties
    if p.has("value") and p.named["value"].tag == "vector":
        draft.put("color", p.triple("value"), "value")
    else:
        draft.put("color", [p.number("value", 0.0)] * 3, "value")
    p.finish()
    return draft.data


def _mesh_attribute(context: Context, element: Element, path: str) -> Data:
    draft = Draft(context, element, path, "vertex_color")
    p = draft.properties
    p.text("name", VERTEX_COLOR, (VERTEX_COLOR,))
    if not p.has("name"):
        context.report.error(element, 'needs <string name="name" .../>')
    if p.number("scale", 1.0) != 1.0:
        text = "is not covered: vertex colours are shown as they are"
        context.report.not_covered(p.named["scale"], text, "1 is taken")
    p.finish()
    return draft.data


def _uv_steps(draft: Draft) -> list[Data]:
    """Steps from the surface's coordinates to the texture's, one matrix at most."""
    p = draft.properties
    matrix = np.eye(3)
    steps = steps_of(p, "to_uv")
    if steps:
        whole = matrix_of(steps)
        matrix[:2, :2], matrix[:2, 2] = whole[:2, :2], whole[:2, 3]
    if draft.element.old:
        scale, offset = np.eye(3), np.eye(3)
        for i, axis in enumerate("uv"):
            scale[i, i] = p.number(f"{axis}scale", 1.0) or 0.0
            offset[i, 2] = p.number(f"{axis}offset", 0.0) or 0.0
        # As Mitsuba 3 reads such files: the offset is scaled too.
        matrix = scale @ offset @ matrix
    if (matrix == np.eye(3)).all():
        return []
    if matrix[0, 1] == matrix[1, 0] == 0.0:
        found: list[Data] = [{"scale": [matrix[0, 0], matrix[1, 1]]}]
        return found + ([{"translate": matrix[:2, 2].tolist()}] if matrix[:2, 2].any() else [])
    return [{"matrix": matrix[:2].tolist()}]


#: Textures of Mitsuba that alight has models for.
COVERED: dict[str, Callable[[Context, Element, str], Data]] = {
    "bitmap": _bitmap,
    "checkerboard": _checkerboard,
    "gridtexture": _grid_lines,
    "mesh_attribute": _mesh_attribute,
    "rawconstant": _raw_constant,
    "scale": _scaled,
    "vertexcolors": _vertex_colors,
}
