"""Nodes that show a pattern on a surface: pictures, checkers, ramps, noise, colours of vertices.

Source: MaterialX 1.39, standard library; Pixar, UsdUVTexture. A picture's (0, 0) is its lower left
corner, as ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from alight.core.errors import SceneError, quote
from alight.formats.materials.textures import bitmap, channel, wrapped
from alight.formats.materials.udim import is_tiled, lay_out
from alight.formats.materialx.nodes import WIDTHS, Input, Node
from alight.formats.materialx.placing import NoPlaceError, Place, Places
from alight.formats.materialx.protocols import Evaluates
from alight.formats.materialx.spaces import SPACES, to_linear
from alight.formats.materialx.values import (
    Data,
    Value,
    Varying,
    affine,
    part,
    spread,
    textured,
)
from alight.scene.images import picture
from alight.textures.images import Image

_WRAPS = {"periodic": "repeat", "clamp": "clamp", "mirror": "mirror", "constant": "clamp"}
_USD_WRAPS = {"repeat": "periodic", "useMetadata": "periodic", "black": "constant"}
#: Endings of pictures whose values may exceed 1.
_UNLIMITED = (".exr", ".hdr", ".pfm", ".npy", ".tif", ".tiff")
#: Texels of a ramp: two would show it, but functions of it are computed at the centres of texels.
_STEPS = 1024


def place_of(e: Evaluates, node: Node, find: Callable[[Places, Node], Place]) -> Place:
    """Where a node looks up, or the plain coordinates where that is no affine map."""
    try:
        return find(e.places, node)
    except NoPlaceError as error:
        e.say(node, f"its coordinates {error}: they are taken as they are")
        return Place(e.places.default, np.eye(3))


def image(e: Evaluates, node: Node, find: Callable[[Places, Node], Place] = Places.of) -> Value:
    """``image`` and ``tiledimage``."""
    width = WIDTHS.get(node.kind, 3)
    is_color = node.kind.startswith("color")
    fallback = e.value(node, "default", (0.0,) * width)
    entry = node.inputs.get("file")
    found = None
    if entry is not None and _is_given(entry):
        found = e.host.picture(node, entry, is_color)
    if found is None:
        return spread(fallback, width)
    wraps = [str(node.plain(f"{axis}addressmode", "periodic")) for axis in "uv"]
    if find is not Places.of:
        wraps = ["periodic"] * 2
    nearest = node.plain("filtertype", "linear") == "closest"
    for name in ("layer", "framerange"):
        if node.plain(name, ""):
            e.say(node, f"{name} is left out")
    space = "" if entry is None else entry.space
    return shown(e, node, found, place_of(e, node, find), wraps, nearest, space, width)


def shown(
    e: Evaluates,
    node: Node,
    found: str | Image,
    place: Place,
    wraps: list[str],
    nearest: bool,
    space: str,
    width: int,
) -> Value:
    """A picture at a place."""
    is_color = node.kind.startswith("color") or node.category == "UsdUVTexture"
    if "constant" in wraps:
        e.say(node, "beyond its edges its border goes on, not its default")
    encoding = "linear"
    if is_color:
        encoding = SPACES.get(space or e.host.space, "")
        if not encoding:
            e.say(node, f"colour space {quote(space)} is not covered: taken for linear Rec. 709")
            encoding = "linear"
    matrixed = encoding not in ("auto", "linear", "srgb")
    plain = encoding if not matrixed else "linear"
    data: Data = bitmap(found, plain) | wrapped(*(_WRAPS.get(wrap, "repeat") for wrap in wraps))
    if nearest:
        data["interpolation"] = "nearest"
    data |= place.steps
    number = e.set_number(node, place.name)
    if number:
        data["uv_set"] = number
    lay_out(data, e.host.reach, e.host.report)
    most = _largest(e, found, plain)
    if width == 1:
        return textured(channel(data, "r"), 1, most)
    alpha = textured(channel(data, "a"), 1) if width == 4 else None
    value: Value = textured(data, min(width, 3), most, alpha)
    if matrixed:
        return e.computed(node, lambda x: to_linear(x, encoding), [value], value, width)
    return value


def _largest(e: Evaluates, found: str | Image, space: str) -> float:
    """The largest value of a picture: of whole numbers 1."""
    try:
        if isinstance(found, str):
            if PurePosixPath(found).suffix.lower() not in _UNLIMITED:
                return 1.0
            if is_tiled(found):
                return math.inf
            found = picture(found, e.host.files)
        return 1.0 if found.levels > 1 else max(found.maximum(space))
    except SceneError:
        # Building the scene reports it.
        return 1.0


def _is_given(entry: Input) -> bool:
    """Whether an input names a file."""
    return bool(entry.value) or entry.asset is not None


def tiled_image(e: Evaluates, node: Node) -> Value:
    """``tiledimage``."""
    return image(e, node, Places.tiled)


def usd_texture(e: Evaluates, node: Node) -> Value:
    """``UsdUVTexture``, all of its channels."""
    entry = node.inputs.get("file")
    found = e.host.picture(node, entry, True) if entry is not None and _is_given(entry) else None
    if found is None:
        return spread(e.value(node, "fallback", (0.0, 0.0, 0.0, 1.0)), 4)
    space = str(node.plain("sourceColorSpace", "auto"))
    if space == "auto" and entry is not None:
        space = entry.space or "auto"
    wraps = [str(node.plain(f"wrap{axis}", "useMetadata")) for axis in "ST"]
    wraps = [_USD_WRAPS.get(wrap, wrap) for wrap in wraps]
    place = place_of(e, node, lambda places, one: places.of(one, "st"))
    value = shown(e, node, found, place, wraps, False, space, 4)
    return affine(value, _numbers(e, node, "scale", 1.0), _numbers(e, node, "bias", 0.0))


def _numbers(e: Evaluates, node: Node, name: str, default: float) -> tuple[float, ...]:
    """Four numbers that must not vary."""
    try:
        return e.places.numbers(node, name, (default,) * 4)
    except NoPlaceError:
        e.say(node, f"its {name} varies: {default:g} is taken")
        return (default,) * 4


def checkerboard(e: Evaluates, node: Node) -> Value:
    """``checkerboard``: `color2` holds the square next to the origin."""
    place = place_of(e, node, Places.tiled)
    first = e.value(node, "color2", (0.0,) * 3)
    second = e.value(node, "color1", (1.0,) * 3)
    data: Data = {"type": "checkerboard", "color0": [0.0] * 3, "color1": [1.0] * 3}
    data |= place.steps
    number = e.set_number(node, place.name)
    if number:
        data["uv_set"] = number
    return e.mixed(node, spread(first, 3), spread(second, 3), textured(data, 1))


def ramp(axis: int, low: str, high: str, sharp: bool = False) -> Callable[[Evaluates, Node], Value]:
    """``ramplr``, ``ramptb``, ``splitlr``, ``splittb``: from one value to another along u or v."""

    def read(e: Evaluates, node: Node) -> Value:
        width = WIDTHS.get(node.kind, 3)
        ends = [spread(e.value(node, key, (0.0,) * width), width) for key in (low, high)]
        return e.mixed(node, ends[0], ends[1], _rise(e, node, axis, sharp))

    return read


def _rise(e: Evaluates, node: Node, axis: int, sharp: bool) -> Varying:
    """From 0, where u or v is 0, to 1, where it is 1."""
    place = place_of(e, node, Places.of)
    matrix = np.eye(3)
    if sharp:
        center = 0.5
        try:
            center = e.places.numbers(node, "center", (0.5,))[0]
        except NoPlaceError as error:
            e.say(node, f"its center {error}: 0.5 is taken")
        matrix[axis, 2] = 0.5 - center
    else:
        # From the centre of the first texel to that of the last.
        matrix[axis, axis], matrix[axis, 2] = 1.0 - 1.0 / _STEPS, 0.5 / _STEPS
    texels = np.linspace(0.0, 1.0, 2 if sharp else _STEPS, dtype=np.float32)[None]
    # Rows are counted from the top.
    pixels = Image((texels if axis == 0 else texels[:, ::-1].T.copy())[..., None].copy())
    data: Data = {"type": "bitmap", "pixels": pixels, "color_space": "linear", "wrap": "clamp"}
    if sharp:
        data["interpolation"] = "nearest"
    data |= place.moved(matrix).steps
    number = e.set_number(node, place.name)
    if number:
        data["uv_set"] = number
    return textured(channel(data, "r"), 1)


def ramp4(e: Evaluates, node: Node) -> Value:
    """``ramp4``: between four corners."""
    width = WIDTHS.get(node.kind, 3)
    corners = [
        spread(e.value(node, f"value{key}", (0.0,) * width), width)
        for key in ("bl", "br", "tl", "tr")
    ]
    along = _rise(e, node, 0, sharp=False)
    bottom = e.mixed(node, corners[0], corners[1], along)
    top = e.mixed(node, corners[2], corners[3], along)
    return e.mixed(node, bottom, top, _rise(e, node, 1, sharp=False))


def noise(space: str, octaves: int) -> Callable[[Evaluates, Node], Value]:
    """Gradient noise on the surface or in space, with or without octaves."""

    def read(e: Evaluates, node: Node) -> Value:
        width = WIDTHS.get(node.kind, 3)
        amplitude = e.value(node, "amplitude", (1.0,) * width)
        pivot = e.value(node, "pivot", (0.0,))
        data: Data = {"type": "noise", "space": space, "octaves": octaves}
        if octaves > 1:
            data["octaves"] = min(max(int(node.plain("octaves", 3)), 1), 16)
            data["gain"] = min(max(node.plain("diminish", 0.5), 0.0), 1.0)
            if node.plain("lacunarity", 2.0) != 2.0:
                e.say(node, "lacunarity became 2")
        if space == "uv":
            matrix = place_of(e, node, Places.of).matrix
            data["scale"] = [float(np.hypot(*matrix[0, :2])), float(np.hypot(*matrix[1, :2])), 1.0]
        e.say(node, "becomes a noise of the same size and strength, with another pattern")
        # Ours is in [0, 1], about a half.
        signed = affine(textured(data, 1), (2.0,), (-1.0,))
        sizes = [e.constant(node, v, width) for v in (amplitude, pivot)]
        return affine(spread(signed, width), *(list(s) for s in sizes))

    return read


def vertex_color(e: Evaluates, node: Node) -> Value:
    """``geomcolor``."""
    width = WIDTHS.get(node.kind, 3)
    return spread(textured({"type": "vertex_color", "fallback": 1.0}, 3), width)


def property_value(key: str, default: str) -> Callable[[Evaluates, Node], Value]:
    """``geompropvalue`` and ``UsdPrimvarReader``."""

    def read(e: Evaluates, node: Node) -> Value:
        width = WIDTHS.get(node.kind, 3)
        name = str(node.plain(key, ""))
        found = e.host.primvar(node, name, width)
        return e.value(node, default, (0.0,) * width) if found is None else found

    return read


def constant(e: Evaluates, node: Node) -> Value:
    """``constant``."""
    return e.value(node, "value", (0.0,) * WIDTHS.get(node.kind, 3))


def channel_at(e: Evaluates, node: Node) -> Value:
    """``extract``."""
    return part(e.value(node, "in", (0.0,) * 3), int(node.plain("index", 0)))


def as_plain(value: Any) -> tuple[float, ...]:
    """A value of a file as numbers."""
    if isinstance(value, bool | int | float):
        return (float(value),)
    return tuple(float(x) for x in value)


PATTERNS: dict[str, Callable[[Evaluates, Node], Value]] = {
    "UsdPrimvarReader": property_value("varname", "fallback"),
    "UsdUVTexture": usd_texture,
    "checkerboard": checkerboard,
    "constant": constant,
    "extract": channel_at,
    "fractal2d": noise("uv", 3),
    "fractal3d": noise("world", 3),
    "geomcolor": vertex_color,
    "geompropvalue": property_value("geomprop", "default"),
    "geompropvalueuniform": property_value("geomprop", "default"),
    "image": image,
    "noise2d": noise("uv", 1),
    "noise3d": noise("world", 1),
    "ramp4": ramp4,
    "ramplr": ramp(0, "valuel", "valuer"),
    "ramptb": ramp(1, "valueb", "valuet"),
    "splitlr": ramp(0, "valuel", "valuer", sharp=True),
    "splittb": ramp(1, "valueb", "valuet", sharp=True),
    "tiledimage": tiled_image,
}
