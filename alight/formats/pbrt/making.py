"""A material of pbrt in the making: its parameters, textures and parts, and its name here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from alight.core.errors import join_path, unknown_name
from alight.formats.materials.surfaces import two_sided
from alight.formats.materials.textures import WITHOUT
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.pbrt.heights import height_of
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.textures import Role, Source, TextureItem, Value, entry
from alight.formats.reading.reach import OutOfReachError

MOST_LEVELS = 12
#: Endings of pictures whose numbers have no limit.
FLOATS = (".exr", ".hdr", ".pfm", ".npy")


@dataclass(eq=False)
class MaterialItem:
    """A material of the file, with the textures that it refers to.

    Attributes
    ----------
    directive : Directive
    kind : str
        What kind of material it is.
    name : str
        How it is called here.
    defaults : list of Parameter
        Of ``Attribute``.
    bound : dict of str to TextureItem
        By the name of the parameter.
    space : str
        Colour space of its RGB values.
    """

    directive: Directive
    kind: str
    name: str
    defaults: list[Parameter] = field(default_factory=list)
    bound: dict[str, TextureItem] = field(default_factory=dict)
    space: str = "srgb"
    native: str | None = None
    is_open: bool = False


#: Keys of a texture that say how bright it may be.
_PARTS = ("a", "b", "texture", "weight", "color0", "color1")


@dataclass
class Making(Source):
    """A material in the making, which may hold others."""

    named: Mapping[str, MaterialItem] = field(default_factory=dict)
    levels: int = 0

    def color(self, name: str, default: Value | None, role: Role = "reflectance") -> Value | None:
        """Ask for a colour; textures of reflectances end at 1, in pbrt 3 numbers too."""
        found = super().color(name, default, role)
        if role != "reflectance" or found is None or found is default:
            return found
        if isinstance(found, list):
            if not self.context.old:
                return found
            if max(found) > 1.0:
                shown = ", ".join(f"{channel:g}" for channel in found)
                text = f"reflects more than it gets, [{shown}]: it is cut at 1"
                self.p.report.warn(self.p.named[name], text)
            return [min(channel, 1.0) for channel in found]
        return self.capped(found)

    def capped(self, name: str) -> str:
        """A texture that ends at 1: itself, unless it may be brighter."""
        if not self._may_exceed(name):
            return name
        return entry(self, {"type": "clamp", "texture": name})

    def _may_exceed(self, name: str) -> bool:
        """Whether a texture may be brighter than 1, as far as is known before files are read."""
        stack, table = [name], self.context.tables["textures"]
        while stack:
            data = table[stack.pop()]
            parts = [data[key] for key in _PARTS if key in data]
            stack += [part for part in parts if isinstance(part, str)]
            bright = any(isinstance(part, list) and max(part) > 1.0 for part in parts)
            if bright or str(data.get("file", "")).lower().endswith(FLOATS):
                return True
        return False

    def warn(self, text: str) -> None:
        """Remark on what is not the same here."""
        self.p.report.warn(self.p.directive, text)

    def nested(self, name: str, parameter: Parameter) -> str:
        """The native name of another material."""
        item = self.named.get(name)
        if item is None:
            message = unknown_name("material", name, self.named, listed_as="named materials")
            self.p.report.error(parameter, message)
        elif item.is_open or self.levels > MOST_LEVELS:
            self.p.report.error(parameter, "contains itself, or is nested too deeply")
        else:
            return material_name(self.context, item, self.named, self.levels + 1)
        return material_name(self.context, default_material(), self.named)


def default_material() -> MaterialItem:
    """What surfaces without a material are made of."""
    return MaterialItem(Directive("Material", "", ["diffuse"]), "diffuse", "default")


def material_name(
    context: Context, item: MaterialItem, named: Mapping[str, MaterialItem], levels: int = 0
) -> str:
    """The name of a material in the table ``bsdfs``, where it is put when it is first used."""
    if item.native is None:
        name = context.free_name("bsdfs", item.name)
        # Its place in the order comes before the parts that it is made of.
        context.tables["bsdfs"][name] = {}
        path = join_path("bsdfs", name)
        if item.directive.place:
            context.places[path] = item.directive.place
        space, context.colors.space = context.colors.space, item.space
        p = Parameters(item.directive, context.report, item.defaults)
        making = Making(context, p, item.bound, path, named=named, levels=levels)
        item.is_open = True
        context.tables["bsdfs"][name] = _converted(making, item)
        item.is_open = False
        item.native = name
        context.colors.space = space
    return item.native


def _converted(m: Making, item: MaterialItem) -> Data:
    materials = m.context.materials
    if item.kind not in materials:
        known = [name for name in materials if name]
        m.p.report.unknown(m.p.directive, "material", item.kind, known, "grey 0.5 is taken")
        return two_sided({"type": "diffuse"})
    # Its own name, in MakeNamedMaterial.
    m.p.find("type")
    data = materials[item.kind](m)
    data = _bumpy(m, data)
    m.p.finish()
    return data


def _bumpy(m: Making, data: Data) -> Data:
    """Put a bump or normal map around a material."""
    name = "displacement" if m.p.has("displacement") else "bumpmap"
    factor, height = height_of(m, name)
    if isinstance(height, str) and factor:
        scale = {"scale": factor} if factor != 1.0 else {}
        data = {"type": "bump_map", "texture": height, **scale, "bsdf": data}
    found = m.p.values("normalmap", "string", count=1)
    if found is None:
        return data
    try:
        file = m.context.reach.name_of(m.context.reach.find(found.values[0]))
    except OutOfReachError as error:
        m.p.report.lacks(found, error, WITHOUT)
        return data
    texture = {"type": "bitmap", "file": file, "color_space": "linear"}
    return {"type": "normal_map", "texture": texture, "bsdf": data}
