"""Texture shaders -> textures of the native format.

Source: Pixar, "UsdPreviewSurface specification", version 2.6: UsdUVTexture, UsdPrimvarReader,
UsdTransform2d. Texture coordinates have (0, 0) at the lower left corner of the picture, as ours.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from typing import Any

from pydantic_core import PydanticCustomError

from alight.core.errors import quote
from alight.core.uv_sets import MOST_SETS
from alight.formats.geometry.displacement import Heights
from alight.formats.materials.textures import (
    CHECKERED,
    MISSING,
    WITHOUT,
    bitmap,
    channel,
    normals,
    packed_picture,
    ranging,
    stretched,
    wrapped,
)
from alight.formats.materials.udim import find_tiles, is_tiled, lay_out
from alight.formats.reading.reach import OutOfReachError, UnreadableError
from alight.formats.usd.modules import Ar, UsdGeom, UsdShade
from alight.formats.usd.stage import Stage
from alight.outputs.wraps import read_wraps
from alight.textures.images import Image
from alight.textures.uv import parse_uv_transform

Data = dict[str, Any]
_WRAPS = {"repeat": "repeat", "clamp": "clamp", "mirror": "mirror"}
#: The wrap where a file says nothing: that of the picture's own metadata.
_OF_PICTURE = "useMetadata"
#: How far beyond its edges a picture may be looked up and not be beyond them.
_ROUNDING = 1e-4
_SPACES = {"raw": "linear", "sRGB": "srgb"}
#: Name of the texture coordinates where a file gives none.
DEFAULT_COORDINATES = "st"
_CHANNELS = ("r", "g", "b", "a")
_MOST_PACKED = 2**28


class Textures:
    """Reads what is connected to the inputs of a shader.

    Parameters
    ----------
    stage : Stage
    prim : Usd.Prim
        Whose primvars are read.

    Attributes
    ----------
    sets : list of str
        Names of the texture coordinates of all textures so far, each once.
    """

    def __init__(self, stage: Stage, prim: Any) -> None:
        self.stage = stage
        self.prim = prim
        self.sets: list[str] = []

    def source_of(self, shader: Any, name: str) -> tuple[Any, str] | None:
        """The shader that an input is connected to, and which of its outputs."""
        entry = shader.GetInput(name)
        if not entry:
            return None
        attributes = UsdShade.Utils.GetValueProducingAttributes(entry)
        for attribute in attributes:
            kind = UsdShade.Utils.GetType(attribute.GetName())
            if kind == UsdShade.AttributeType.Output:
                return UsdShade.Shader(attribute.GetPrim()), attribute.GetBaseName()
        return None

    def value(
        self, shader: Any, output: str, *, is_color: bool, fallback: Any, high: float = 1.0
    ) -> Any:
        """Texture or number of an output, at most `high`; None where there is nothing to read."""
        identifier = str(shader.GetIdAttr().Get())
        if identifier == "UsdUVTexture":
            return self._sampled(shader, output, is_color, high)
        if identifier.startswith("UsdPrimvarReader"):
            return self._primvar(shader, is_color, fallback, high)
        self._approximate(shader, f'shader "{identifier}" is not covered; a plain value is taken')
        return None

    def bitmap(self, shader: Any, *, is_color: bool) -> Data | None:
        """The picture of a UsdUVTexture, without scale and bias."""
        asset = self._input(shader, "file")
        if asset is None or not getattr(asset, "path", ""):
            self._approximate(shader, "names no picture")
            return None
        picture = self._picture(shader, asset, is_color)
        if picture is None:
            return None
        space = str(self._input(shader, "sourceColorSpace") or "auto")
        data = bitmap(picture, _SPACES.get(space, "auto" if is_color else "linear"))
        name, steps = self._coordinates_of(shader)
        data |= wrapped(*self._wraps(shader, picture, name, steps))
        if steps:
            data["to_uv"] = steps
        number = self._set_of(shader, name)
        if number:
            data["uv_set"] = number
        lay_out(data, self.stage.reach, self.stage.report)
        return data

    def normals(self, shader: Any) -> Data | None:
        """The picture of a UsdUVTexture as a normal map takes it."""
        picture = self.bitmap(shader, is_color=False)
        if picture is None:
            return None
        scale, bias = self._range(shader)
        if min(bias[:2]) >= 0.0 <= min(scale[:2]):
            text = "without a bias of -1 its normals lean to +x and +y everywhere, as the file says"
            self._approximate(shader, text)
        return normals(picture, scale[:3], bias[:3])

    def heights(self, shader: Any, output: str) -> Heights | None:
        """One channel of a UsdUVTexture as heights, which its bias may put below the surface."""
        if str(shader.GetIdAttr().Get()) != "UsdUVTexture":
            return None
        picture = self.bitmap(shader, is_color=False)
        if picture is None:
            return None
        name = output if output in _CHANNELS else "r"
        scale, bias = (part[_CHANNELS.index(name)] for part in self._range(shader))
        return Heights.of(channel(picture, name), scale, bias)

    def _range(self, shader: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """What the four channels of a picture are multiplied by, and what is added."""
        scale = tuple(float(c) for c in self._input(shader, "scale", (1.0,) * 4))
        return scale, tuple(float(c) for c in self._input(shader, "bias", (0.0,) * 4))

    def _sampled(self, shader: Any, output: str, is_color: bool, high: float) -> Any:
        picture = self.bitmap(shader, is_color=is_color)
        if picture is None:
            if self._input(shader, "fallback") is None:
                return None
            found = [float(c) for c in self._input(shader, "fallback", (0.0, 0.0, 0.0, 1.0))]
            if output in _CHANNELS or not is_color:
                found = [found[_CHANNELS.index(output) if output in _CHANNELS else 0]]
            return _plain(found, is_color, high)
        scale, bias = self._range(shader)
        which = slice(3)
        if output in _CHANNELS or not is_color:
            name = output if output in _CHANNELS else "r"
            index = _CHANNELS.index(name)
            picture, which = channel(picture, name), slice(index, index + 1)
        ends = [(b, b + s) for s, b in zip(scale[which], bias[which], strict=True)]
        least, most = min(map(min, ends)), max(map(max, ends))
        if least < 0.0:
            self._approximate(shader, f"its values begin at {least:g}: they are moved up to 0")
        starts, stops = ([max(end, 0.0) for end in part] for part in zip(*ends, strict=True))
        if len(ends) == 1:
            found = ranging(picture, starts[0], stops[0])
        else:
            found = stretched(picture, starts, stops)
        if most > high:
            self._approximate(shader, f"its values may reach {most:g}: they are cut at {high:g}")
            found = {"type": "clamp", "texture": found}
        return found

    def _primvar(self, shader: Any, is_color: bool, fallback: Any, high: float) -> Any:
        name = self._varname(shader)
        primvar = UsdGeom.PrimvarsAPI(self.prim).FindPrimvarWithInheritance(name)
        given = self._input(shader, "fallback")
        if not primvar or not primvar.HasValue():
            return _plain(fallback if given is None else given, is_color, high)
        table = self.stage.table(primvar)
        if table is None:
            return _plain(fallback, is_color, high)
        if primvar.GetInterpolation() == UsdGeom.Tokens.constant and len(table):
            return _plain(table[0], is_color, high)
        if name == "displayColor" and is_color:
            return {"type": "vertex_color", "fallback": 0.18}
        self._approximate(shader, f"primvar {name} varies, which only displayColor may")
        return _plain(fallback, is_color, high)

    def _coordinates_of(self, shader: Any) -> tuple[str, list[Data]]:
        """Which texture coordinates are used, and the steps that change them."""
        source, steps, passed = self.source_of(shader, "st"), [], set()
        while source is not None and str(source[0].GetIdAttr().Get()) == "UsdTransform2d":
            node = source[0]
            if node.GetPath() in passed:
                self._approximate(node, "its coordinates come from itself: they are left out")
                return DEFAULT_COORDINATES, []
            passed.add(node.GetPath())
            scale = [float(c) for c in self._input(node, "scale", (1.0, 1.0))]
            angle = float(self._input(node, "rotation", 0.0))
            shift = [float(c) for c in self._input(node, "translation", (0.0, 0.0))]
            steps = [{"scale": scale}, {"rotate": angle}, {"translate": shift}, *steps]
            source = self.source_of(node, "in")
        name = self._varname(source[0]) if source is not None else ""
        neutral = ({"scale": [1.0, 1.0]}, {"rotate": 0.0}, {"translate": [0.0, 0.0]})
        return name or DEFAULT_COORDINATES, [step for step in steps if step not in neutral]

    def _set_of(self, shader: Any, name: str) -> int:
        """The number of the coordinates of a name."""
        if name not in self.sets:
            if len(self.sets) == MOST_SETS:
                text = f"{name} is one set of coordinates too many; {self.sets[0]} is used"
                self._approximate(shader, text)
                return 0
            self.sets.append(name)
        return self.sets.index(name)

    def _varname(self, shader: Any) -> str:
        return str(self._input(shader, "varname") or "")

    def _wraps(self, shader: Any, picture: str | Image, name: str, steps: list[Data]) -> list[str]:
        """What is beyond the edges of a picture along u and v."""
        found = []
        own = _wraps_of(self.stage, picture)
        for axis, key in enumerate(("wrapS", "wrapT")):
            wrap = str(self._input(shader, key) or _OF_PICTURE)
            if wrap == _OF_PICTURE:
                wrap = own[axis]
                if not wrap and self._leaves(name, steps, axis):
                    self._approximate(shader, f"neither it nor its picture has a {key}: it repeats")
                wrap = wrap or "repeat"
            if wrap not in _WRAPS:
                self._approximate(shader, f"{key} {wrap} became clamp")
            found.append(_WRAPS.get(wrap, "clamp"))
        return found

    def _leaves(self, name: str, steps: list[Data], axis: int) -> bool:
        """Whether the shape looks beyond the edges of a picture along u (0) or v (1)."""
        primvar = UsdGeom.PrimvarsAPI(self.prim).FindPrimvarWithInheritance(name)
        table = self.stage.table(primvar) if primvar and primvar.HasValue() else None
        if table is None or not len(table) or table.shape[1] < 2:
            return False
        matrix = parse_uv_transform(steps).matrix
        along = table[:, :2] @ matrix[axis, :2] + matrix[axis, 2]
        return bool(along.min() < -_ROUNDING or along.max() > 1.0 + _ROUNDING)

    def _input(self, shader: Any, name: str, default: Any = None) -> Any:
        """Value of an input; with a default, only one of its kind."""
        entry = shader.GetInput(name)
        if not entry:
            return default
        attributes = UsdShade.Utils.GetValueProducingAttributes(entry)
        if not attributes:
            return default
        if default is None:
            return self.stage.value(attributes[0])
        return self.stage.alike(attributes[0], default)

    def _picture(self, shader: Any, asset: Any, is_color: bool) -> str | Image | None:
        try:
            return picture_of(self.stage, asset)
        except OutOfReachError as error:
            place, report = str(shader.GetPath()), self.stage.report
            report.lacks_at(self.stage.name, place, error, CHECKERED if is_color else WITHOUT)
            return MISSING if is_color and report.can_do_without(error) else None

    def _approximate(self, shader: Any, text: str) -> None:
        self.stage.report.approximate(f"{shader.GetPath()}: {text}")


def picture_of(stage: Stage, asset: Any) -> str | Image:
    """The name of a file beside the stage, or the texels of a picture inside of a package.

    Raises
    ------
    OutOfReachError
        If it is missing, broken, or lies elsewhere.
    """
    if is_tiled(asset.path):
        return _tiles(stage, asset.path)
    resolved = asset.resolvedPath or _member(stage, asset.path)
    path = stage.picture(asset.path, resolved.partition("[")[0])
    if "[" not in resolved:
        return stage.reach.name_of(path)
    try:
        return _packed(resolved, stage.report.approximate)
    except PydanticCustomError as error:
        text = error.message()
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        text = " ".join(str(error).split())[:200]
    raise UnreadableError(f"{quote(asset.path)}: the picture {text or 'is broken'}")


def _wraps_of(stage: Stage, picture: str | Image) -> tuple[str, str]:
    """What a picture beside the stage says of itself beyond its edges along u and v."""
    try:
        return read_wraps(stage.reach.find(picture)) if isinstance(picture, str) else ("", "")
    except OutOfReachError:
        # Many files, one beside the other.
        return "", ""


def _tiles(stage: Stage, authored: str) -> str:
    """The name of a set of tiles beside one of the layers."""
    refused = OutOfReachError(f"no such picture: {quote(authored)}")
    for layer in reversed([layer for layer in stage.stage.GetUsedLayers() if layer.realPath]):
        folder = Path(layer.realPath.partition("[")[0]).parent
        try:
            return find_tiles(authored, stage.reach.from_folder(folder))
        except OutOfReachError as error:
            refused = error
    raise refused


def _member(stage: Stage, authored: str) -> str:
    """Where in a package a picture lies whose path has backslashes, which OpenUSD does not know."""
    if "\\" in authored:
        plain, resolver = authored.replace("\\", "/"), Ar.GetResolver()
        for layer in stage.stage.GetUsedLayers():
            path = layer.ComputeAbsolutePath(plain)
            if "[" in path and resolver.Resolve(path):
                return path
    return ""


def _packed(resolved: str, tell: Callable[[str], None]) -> Image:
    package, _, member = resolved.partition("[")
    name = PurePosixPath(member.rstrip("]")).as_posix()
    with zipfile.ZipFile(package) as archive:
        if archive.getinfo(name).file_size > _MOST_PACKED:
            raise ValueError(f"{name} is larger than {_MOST_PACKED >> 20} MB")
        return packed_picture(archive.read(name), lambda text: tell(f"{quote(name)}: {text}"))


def _plain(value: Any, is_color: bool, high: float) -> Any:
    """A number, or the three of a colour, in [0, high]."""
    numbers = [float(c) for c in value] if hasattr(value, "__len__") else [float(value)]
    numbers = [min(max(c, 0.0), high) for c in numbers]
    if not is_color:
        return numbers[0]
    return numbers[:3] if len(numbers) >= 3 else numbers[:1] * 3
