"""``Texture`` -> textures of the native format.

Coordinates are the same in both: (0, 0) is the lower left corner of a picture. What is constant is
folded to numbers here; products and mixtures of pictures become nodes ``multiply`` and ``mix``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.errors import SceneError, join_path, quote, unknown_name
from alight.formats.materials.textures import CHECKERED, FLAT, MISSING
from alight.formats.pbrt.colors import KINDS, Role
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.single_numbers import numbers_in
from alight.formats.reading.reach import OutOfReachError
from alight.scene import images

#: A colour, or the name of a texture.
Value = list[float] | str
MOST_LEVELS = 24
GREY = [0.5] * 3
_WHITE, _BLACK = [1.0] * 3, [0.0] * 3
#: What is above 0 as float32 counts them.
_ABOVE_ZERO = 1e-30


@dataclass(eq=False)
class TextureItem:
    """A texture of the file, with those that it refers to.

    Attributes
    ----------
    directive : Directive
    defaults : list of Parameter
        Of ``Attribute``.
    bound : dict of str to TextureItem
        By the name of the parameter.
    space : str
        Colour space of its RGB values.
    matrix : (4, 4) float64
        From the space in which it is defined to the world.
    levels : int
        Textures in a row that it is made of.
    is_read : bool
        Whether anything uses it.
    """

    directive: Directive
    defaults: list[Parameter]
    bound: dict[str, TextureItem]
    space: str = "srgb"
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))
    levels: int = 1
    value: Value | None = None
    is_read: bool = False


Textures = Mapping[tuple[str, str], TextureItem]


@dataclass
class Source:
    """Parameters of an object that may be textures.

    Attributes
    ----------
    context : Context
    p : Parameters
    bound : dict of str to TextureItem
        By the name of the parameter.
    path : str
        Key path of what is made of it.
    matrix : (4, 4) float64
        From the space in which it is defined to the world.
    """

    context: Context
    p: Parameters
    bound: Mapping[str, TextureItem]
    path: str = ""
    matrix: np.ndarray = field(default_factory=lambda: np.eye(4))

    def color(self, name: str, default: Value | None, role: Role = "reflectance") -> Value | None:
        """Ask for a colour that may be a texture."""
        found = self.p.find(name)
        if found is None:
            return default
        if found.kind == "texture":
            return self._texture(found, default)
        if found.kind == "float" and self.p.directive.name != "Texture":
            self.p.report.error(found, f"must be a colour ({', '.join(KINDS)}), got float")
            return default
        return self.context.colors.read(found, role) or default

    def number(self, name: str, default: float | None) -> float | str | None:
        """Ask for a number that may be a texture."""
        found = self.p.find(name)
        if found is None:
            return default
        if found.kind != "texture":
            return self.p.number(name, default or 0.0)
        value = self._texture(found, None)
        return sum(value) / 3.0 if isinstance(value, list) else value or default

    def opacity(self) -> float | str | Data | None:
        """Ask for the ``alpha`` of a shape; in pbrt 3 what is not 0 is opaque."""
        alpha = self.number("alpha", None)
        if not self.context.old or alpha is None:
            return alpha
        if isinstance(alpha, str):
            return {"type": "threshold", "texture": alpha, "cutoff": _ABOVE_ZERO}
        return float(alpha != 0.0)

    def share(self, name: str) -> float | str:
        """Ask for a share; pbrt 3 also has colours, of which alight takes one share for all."""
        given = self.p.named.get(name)
        if not self.context.old or given is None or given.kind in ("float", "integer", "texture"):
            amount = self.number(name, 0.5)
            return 0.5 if amount is None else amount
        color = self.color(name, [0.5] * 3)
        if not isinstance(color, list):
            return 0.5
        if min(color) != max(color):
            text = "mixes each colour by a share of its own: their luminance is taken for all"
            self.p.report.warn(self.p.directive, text)
        return sum(part * weight for part, weight in zip(color, LUMINANCE, strict=True))

    def plain_number(self, name: str, default: float) -> float:
        """Ask for a number where ours cannot be a texture."""
        value = self.number(name, default)
        if isinstance(value, str):
            text = f"is a texture, which this cannot be here: {default:g} is taken"
            self.p.report.warn(self.p.named[name], text)
            return default
        return default if value is None else value

    def _texture(self, found: Parameter, default: Value | None) -> Value | None:
        item = self.bound.get(found.name)
        return default if item is None else texture_value(self.context, item)


def bind(
    context: Context, parameters: list[Parameter], textures: Textures, numbers: bool | None = None
) -> dict[str, TextureItem]:
    """Find the textures that parameters refer to, as they are defined here and now.

    Parameters
    ----------
    numbers : bool, optional
        Whether textures of numbers are wanted; either kind by default.
    """
    bound = {}
    for parameter in parameters:
        if parameter.kind != "texture":
            continue
        if len(parameter.values) != 1:
            text = f"must name one texture, got {len(parameter.values)}"
            context.report.error(parameter, text)
            continue
        name = parameter.values[0]
        found = [
            textures[key] for kind in ("spectrum", "float") if (key := (kind, name)) in textures
        ]
        if numbers:
            found = found[::-1]
        if found:
            bound[parameter.name] = found[0]
        else:
            known = [known for _, known in textures]
            message = unknown_name("texture", name, known, listed_as="textures")
            context.report.error(parameter, message)
    return bound


def define(
    context: Context,
    directive: Directive,
    defaults: list[Parameter],
    textures: Textures,
    matrix: np.ndarray,
) -> tuple[tuple[str, str], TextureItem] | None:
    """Read ``Texture "name" "type" "class"``: its key, and what it is.

    Parameters
    ----------
    matrix : (4, 4) float64
        From the space in which it stands to the world.
    """
    name, kind, _ = directive.texts
    kind = {"color": "spectrum"}.get(kind, kind)
    if kind not in ("float", "spectrum"):
        message = unknown_name("type of texture", kind, ("float", "spectrum"))
        context.report.error(directive, message)
        return None
    parameters = [*directive.parameters, *defaults]
    bound = bind(context, parameters, textures, numbers=kind == "float")
    levels = 1 + max((item.levels for item in bound.values()), default=0)
    if levels > MOST_LEVELS:
        context.report.error(directive, f"is made of more than {MOST_LEVELS} textures in a row")
        return None
    item = TextureItem(directive, defaults, bound, context.colors.space, matrix, levels)
    return (kind, name), item


def texture_value(context: Context, item: TextureItem) -> Value:
    """A texture as a colour, or as the name of an entry of the table ``textures``."""
    item.is_read = True
    if item.value is None:
        value: Value = list(GREY)
        kind = item.directive.type
        space, context.colors.space = context.colors.space, item.space
        known = context.textures
        if kind in known:
            p = Parameters(item.directive, context.report, item.defaults)
            value = known[kind](Source(context, p, item.bound, matrix=item.matrix))
            p.finish()
        else:
            context.report.unknown(item.directive, "texture", kind, known, "grey 0.5 is taken")
        context.colors.space = space
        item.value = value
    return item.value


def entry(source: Source, data: Data) -> str:
    """Put a description into the table of textures."""
    context, directive = source.context, source.p.directive
    wanted = directive.texts[0] if directive.name == "Texture" else directive.type
    name = context.free_name("textures", wanted)
    context.tables["textures"][name] = data
    context.places[join_path("textures", name)] = directive.place
    return name


def product(source: Source, a: Value, b: Value) -> Value:
    """The product of two textures."""
    if isinstance(a, list) and isinstance(b, list):
        return [x * y for x, y in zip(a, b, strict=True)]
    if _WHITE in (a, b):
        return a if b == _WHITE else b
    return entry(source, {"type": "multiply", "a": a, "b": b})


def mixture(source: Source, a: Value, b: Value, weight: float | str) -> Value:
    """The mixture (1 - weight) a + weight b."""
    if isinstance(weight, str):
        return entry(source, {"type": "mix", "a": a, "b": b, "weight": weight})
    if isinstance(a, list) and isinstance(b, list):
        return [x + weight * (y - x) for x, y in zip(a, b, strict=True)]
    return entry(source, {"type": "mix", "a": a, "b": b, "weight": min(max(weight, 0.0), 1.0)})


def part(source: Source, name: str, default: list[float]) -> Value:
    """Ask for a part of a texture: a colour or a number, whichever it is made of."""
    value = source.color(name, default)
    return default if value is None else value


def _constant(source: Source) -> Value:
    return part(source, "value", _WHITE)


def _scale(source: Source) -> Value:
    if source.p.has("tex1") or source.p.has("tex2"):
        return product(source, part(source, "tex1", _WHITE), part(source, "tex2", _WHITE))
    return product(source, part(source, "tex", _WHITE), part(source, "scale", _WHITE))


def _mix(source: Source) -> Value:
    amount = source.number("amount", 0.5)
    a, b = part(source, "tex1", _BLACK), part(source, "tex2", _WHITE)
    return mixture(source, a, b, 0.5 if amount is None else amount)


def _direction_mix(source: Source) -> Value:
    source.p.leave_out("the mean of both is taken", "dir")
    a, b = part(source, "tex1", _BLACK), part(source, "tex2", _WHITE)
    text = "depends on the direction of the normal: the mean of both is taken"
    source.p.report.warn(source.p.directive, text)
    return mixture(source, a, b, 0.5)


def _checkerboard(source: Source) -> Value:
    p = source.p
    if p.integer("dimension", 2) != 2:
        p.report.warn(p.directive, "is made of cubes: squares of (u, v) are taken")
    p.ignore("many samples smooth the edges", "aamode")
    a, b = part(source, "tex1", _WHITE), part(source, "tex2", _BLACK)
    board: Data = {"type": "checkerboard", **mapping(source)}
    if isinstance(a, list) and isinstance(b, list) and max(*a, *b) <= 1.0 and min(*a, *b) >= 0.0:
        return entry(source, {**board, "color0": a, "color1": b})
    weight = entry(source, {**board, "color0": _BLACK, "color1": _WHITE})
    return mixture(source, a, b, weight)


def bitmap(source: Source, data: Data) -> str | None:
    """Put a bitmap with the picture ``filename`` into the table; None after a problem."""
    p, context = source.p, source.context
    found = p.values("filename", "string", count=1)
    if found is None:
        if not p.has("filename"):
            p.report.error(p.directive, 'needs "string filename"')
        return None
    try:
        file = context.reach.name_of(context.reach.find(found.values[0]))
    except OutOfReachError as error:
        is_color = data.get("color_space") != "linear" and p.directive.texts[1:2] != ["float"]
        p.report.lacks(found, error, CHECKERED if is_color else FLAT)
        if not (is_color and p.report.can_do_without(error)):
            return None
        return entry(source, {**data, "pixels": MISSING})
    return entry(source, {**data, "file": file})


def _imagemap(source: Source) -> Value:
    p = source.p
    data: Data = {"type": "bitmap"}
    p.ignore("there is no prefiltering", "maxanisotropy", "trilinear")
    kind = p.text("filter", "bilinear", ("point", "bilinear", "trilinear", "ewa", "EWA"))
    if kind == "point":
        data["interpolation"] = "nearest"
    wrap = p.text("wrap", "repeat", ("repeat", "clamp", "black", "octahedralsphere"))
    if wrap not in ("repeat", "clamp"):
        p.report.warn(p.named["wrap"], f"{quote(wrap)} is not covered: clamp is taken")
    if wrap != "repeat":
        data["wrap"] = "clamp"
    encoding = p.text("encoding", "sRGB")
    if p.has("gamma") and not p.flag("gamma", True):
        encoding = "linear"
    if encoding.startswith("gamma"):
        p.report.warn(p.named["encoding"], "is a power: the curve of sRGB is taken")
    elif encoding not in ("sRGB", "linear"):
        message = unknown_name("encoding", encoding, ("sRGB", "linear", "gamma 2.2"))
        p.report.error(p.named["encoding"], message)
    if encoding == "linear":
        data["color_space"] = "linear"
    scale = p.number("scale", 1.0)
    inverted = p.flag("invert", False)
    data |= mapping(source)
    picture = bitmap(source, data)
    if picture is None:
        return list(GREY)
    if p.directive.texts[1] == "float":
        _take_numbers(source.context, source.context.tables["textures"][picture], kind)
    value = product(source, picture, [scale] * 3)
    return mixture(source, _WHITE, _BLACK, value) if inverted and isinstance(value, str) else value


def _take_numbers(context: Context, data: Data, kind: str) -> None:
    """Put the numbers of a coloured picture into its place."""
    space = data.get("color_space", "auto")
    if "file" not in data:
        return
    try:
        image = images.picture(data["file"], context.reach.files, data=space == "linear")
    except SceneError:
        # Compiling the scene reports it.
        return
    found = numbers_in(image, data["file"], space, kind, context.old)
    if found is not None:
        del data["file"]
        data["pixels"] = found


def mapping(source: Source) -> Data:
    """The key ``to_uv``, if coordinates are changed."""
    p = source.p
    kind = p.text("mapping", "uv")
    p.ignore("coordinates are (u, v)", "v1", "v2")
    if kind != "uv":
        p.report.warn(p.named["mapping"], f"{quote(kind)} is not covered: uv is taken")
    scale = [p.number("uscale", 1.0), p.number("vscale", 1.0)]
    shift = [p.number("udelta", 0.0), p.number("vdelta", 0.0)]
    steps: list[Data] = [{"scale": scale}] if scale != [1.0, 1.0] else []
    steps += [{"translate": shift}] if any(shift) else []
    return {"to_uv": steps} if steps else {}


#: Textures of pbrt that alight has models for; those that are computed are in `patterns`.
COVERED: dict[str, Callable[[Source], Value]] = {
    "checkerboard": _checkerboard,
    "constant": _constant,
    "directionmix": _direction_mix,
    "imagemap": _imagemap,
    "mix": _mix,
    "scale": _scale,
}
