"""UsdPreviewSurface -> `principled`.

Source: Pixar, "UsdPreviewSurface specification", version 2.6.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from alight.core.errors import quote
from alight.formats.geometry.displacement import Heights
from alight.formats.materials.surfaces import LARGEST_IOR, Surface, is_metal, reflection
from alight.formats.materials.textures import cut, normal_color
from alight.formats.materialx.displacement import heights_of
from alight.formats.materialx.scene import surface_of
from alight.formats.materialx.shaders import SHADERS, read_shader
from alight.formats.reading.report import did_you_mean
from alight.formats.usd.modules import UsdGeom, UsdShade
from alight.formats.usd.networks import StageHost, network_of
from alight.formats.usd.stage import Stage
from alight.formats.usd.textures import Textures

Data = dict[str, Any]
#: Inputs with their defaults.
INPUTS: dict[str, Any] = {
    "diffuseColor": (0.18, 0.18, 0.18), "emissiveColor": (0.0, 0.0, 0.0),
    "useSpecularWorkflow": 0, "specularColor": (0.0, 0.0, 0.0), "metallic": 0.0, "roughness": 0.5,
    "clearcoat": 0.0, "clearcoatRoughness": 0.01, "opacity": 1.0, "opacityMode": "transparent",
    "opacityThreshold": 0.0, "ior": 1.5, "normal": (0.0, 0.0, 1.0), "displacement": 0.0,
    "occlusion": 1.0,
}  # fmt: skip
_PREVIEW = "UsdPreviewSurface"
#: Render context of networks of MaterialX.
_MATERIALX = "mtlx"


def plain_material(stage: Stage, prim: Any) -> Surface:
    """The material of a prim that has none: its displayColor, or grey."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    color: Any = [0.18] * 3
    if primvar and primvar.HasValue():
        table = stage.table(primvar)
        if table is not None and primvar.GetInterpolation() == UsdGeom.Tokens.constant:
            if table.shape[1:] == (3,) and len(table):
                color = [min(max(float(c), 0.0), 1.0) for c in table[0]]
        elif table is not None:
            color = {"type": "vertex_color", "fallback": 0.18}
    return Surface({"type": "diffuse", "reflectance": color}, opacity=_display_opacity(stage, prim))


def _display_opacity(stage: Stage, prim: Any) -> float:
    """The displayOpacity of a prim; its mean where it varies."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayOpacity")
    table = stage.table(primvar) if primvar and primvar.HasValue() else None
    if table is None or table.shape[1:] != (1,) or not len(table):
        return 1.0
    table = table.clip(0.0, 1.0)
    if table.max() > table.min():
        stage.report.approximate(f"{prim.GetPath()}: displayOpacity varies: its mean is shown")
    return float(table.mean())


def read_material(stage: Stage, material: Any, prim: Any) -> Surface:
    """Read a material as it looks on a prim, whose primvars it may use.

    Parameters
    ----------
    stage : Stage
    material : UsdShade.Material
    prim : Usd.Prim
    """
    name = str(material.GetPath())
    written = stage.documents.material(material.GetPrim())
    if written is not None:
        if material.GetPrim().GetAllChildren() or material.GetInputs():
            text = "what the stage changes in a material of a MaterialX document is left out"
            stage.report.approximate(f"{name}: {text}")
        return surface_of(written, StageHost(stage, prim))
    source = material.ComputeSurfaceSource(_MATERIALX)
    shader = source[0] if source else None
    if shader and shader.GetPrim().IsValid() and shader.GetIdAttr().Get() != _PREVIEW:
        found = _of_network(stage, material, shader, prim)
        if found is not None:
            return found
        source = material.ComputeSurfaceSource()
        shader = source[0] if source else None
    if not shader or not shader.GetPrim().IsValid():
        stage.report.approximate(f"{name}: it has no surface shader; grey is shown")
        return plain_material(stage, prim)
    identifier = shader.GetIdAttr().Get()
    if identifier != _PREVIEW:
        listed = ", ".join(sorted(SHADERS))
        text = f"shader {quote(str(identifier))} is not covered  (covered: {listed})"
        stage.report.approximate(f"{name}: {text}; the colour of the prim is shown")
        return plain_material(stage, prim)
    return _Preview(stage, shader, prim).material()


def _of_network(stage: Stage, material: Any, shader: Any, prim: Any) -> Surface | None:
    """What a network of MaterialX says; None where its shader is not covered."""
    host = StageHost(stage, prim)
    found = read_shader(network_of(stage, shader), host)
    name = str(material.GetPath())
    displaced = material.ComputeDisplacementSource(_MATERIALX)
    if found is not None and displaced and displaced[0]:
        heights, sets = heights_of(network_of(stage, displaced[0]), host, found.sets)
        found = replace(found, heights=heights, sets=sets)
    if found is None and material.GetSurfaceOutput(_MATERIALX):
        identifier = quote(str(shader.GetIdAttr().Get()))
        stage.report.approximate(f"{name}: shader {identifier} of MaterialX is not covered")
    return found


class _Preview:
    """One UsdPreviewSurface on one prim."""

    def __init__(self, stage: Stage, shader: Any, prim: Any) -> None:
        self.stage = stage
        self.shader = shader
        self.textures = Textures(stage, prim)
        self._check_names()

    def material(self) -> Surface:
        """What it becomes."""
        # Tangents follow from the own coordinates of a mesh: the picture of normals comes first.
        normals = self._normals()
        # Some exporters write everything that a mirror shows as its diffuse colour, too.
        core: Data = {
            "type": "principled",
            "base_color": self._color("diffuseColor"),
            "roughness": self._number("roughness"),
        }
        if int(self._plain("useSpecularWorkflow")):
            core |= self._specular(core["base_color"])
        else:
            core["metallic"] = self._number("metallic")
            core["ior"] = self._ior()
        coat = self._number("clearcoat")
        if coat != 0.0:
            core |= {"clearcoat": coat, "clearcoat_roughness": self._number("clearcoatRoughness")}
        emission = self._color("emissiveColor", bounded=False)
        shines = isinstance(emission, dict) or max(emission) > 0.0
        self._say_what_is_left_out()
        opacity = self._opacity()
        heights = self._heights()
        sets, glow = tuple(self.textures.sets), emission if shines else None
        return Surface(core, normals, opacity, glow, sets=sets, heights=heights)

    def _specular(self, diffuse: Any) -> Data:
        """The workflow with a colour of what is reflected straight on: dielectric or metal."""
        color = self._color("specularColor")
        if isinstance(color, dict):
            self._approximate("specularColor is a texture: taken for the colour of reflection")
            return {"ior": 1.5, "specular_color": color}
        if max(color) <= 0.0:
            return {"specular": 0.0}
        if is_metal(diffuse, color):
            return {"metallic": 1.0, "base_color": color}
        found = reflection(color)
        if found.is_weaker:
            self._approximate(
                f"specularColor: at most {found.strength:.3g} is reflected straight on"
            )
        return {"ior": found.ior, "specular_color": [min(part, 1.0) for part in found.tint]}

    def _ior(self) -> float:
        ior = float(self._plain("ior"))
        if not 1.0 <= ior <= LARGEST_IOR:
            # Indices below 1 are seen from inside the denser side.
            inverse = 1.0 / ior if 0.0 < ior < 1.0 else ior
            nearest = min(inverse, LARGEST_IOR) if inverse >= 1.0 else 1.5
            self._approximate(f"ior {ior:g} became {nearest:g}")
            return nearest
        return ior

    def _normals(self) -> Data | None:
        """The wrapper that bends normals, without what it wraps."""
        source = self.textures.source_of(self.shader, "normal")
        if source is None:
            plain = tuple(float(c) for c in self._plain("normal"))
            if plain == INPUTS["normal"]:
                return None
            return {"type": "normal_map", "texture": normal_color(plain)}
        identifier = str(source[0].GetIdAttr().Get())
        if identifier != "UsdUVTexture":
            self._approximate(f'normal comes from a "{identifier}", which is left out')
            return None
        picture = self.textures.normals(source[0])
        return None if picture is None else {"type": "normal_map", "texture": picture}

    def _opacity(self) -> Any:
        opacity = self._number("opacity")
        if opacity == 1.0:
            return opacity
        threshold = float(self._plain("opacityThreshold"))
        if threshold > 0.0:
            return cut(opacity, threshold)
        if self._plain("opacityMode") == "transparent":
            self._approximate("opacity: rays pass straight through, reflections included")
        return opacity

    def _say_what_is_left_out(self) -> None:
        if self.textures.source_of(self.shader, "occlusion") is not None:
            self.stage.report.drop("occlusion: the light itself is traced")

    def _heights(self) -> Heights | None:
        """What displaces the surface: a number, or one channel of a picture."""
        source = self.textures.source_of(self.shader, "displacement")
        if source is None:
            plain = float(self._plain("displacement"))
            return Heights(1.0, plain) if plain != 0.0 else None
        found = self.textures.heights(*source)
        if found is None:
            self._approximate("displacement is left out")
        return found

    def _approximate(self, text: str) -> None:
        self.stage.report.approximate(f"{self.shader.GetPath()}: {text}")

    def _check_names(self) -> None:
        for entry in self.shader.GetInputs():
            name = entry.GetBaseName()
            if name not in INPUTS:
                hint = did_you_mean(name, INPUTS)
                self._approximate(f"unknown input {quote(name)} is left out{hint}")

    def _plain(self, name: str) -> Any:
        """Value of an input that is no texture; the default beside textures too."""
        entry = self.shader.GetInput(name)
        if not entry:
            return INPUTS[name]
        attributes = UsdShade.Utils.GetValueProducingAttributes(entry)
        value = self.stage.value(attributes[0]) if attributes else None
        return INPUTS[name] if value is None or not _alike(value, INPUTS[name]) else value

    def _color(self, name: str, *, bounded: bool = True) -> Any:
        source = self.textures.source_of(self.shader, name)
        if source is not None:
            high = 1.0 if bounded else math.inf
            found = self.textures.value(*source, is_color=True, fallback=INPUTS[name], high=high)
            if found is not None:
                return found
        color = [float(c) for c in self._plain(name)]
        limited = [min(max(c, 0.0), 1.0 if bounded else 1e30) for c in color]
        if limited != color:
            self._approximate(f"{name} was cut to {'[0, 1]' if bounded else 'at least 0'}")
        return limited

    def _number(self, name: str) -> Any:
        source = self.textures.source_of(self.shader, name)
        if source is not None:
            found = self.textures.value(*source, is_color=False, fallback=INPUTS[name])
            if found is not None:
                return found
        number = float(self._plain(name))
        limited = min(max(number, 0.0), 1.0)
        if limited != number:
            self._approximate(f"{name} was cut to [0, 1]")
        return limited


def _alike(value: Any, default: Any) -> bool:
    """Whether a value of a file has the kind that it must have."""
    if isinstance(default, str):
        return isinstance(value, str)
    if isinstance(default, tuple):
        return hasattr(value, "__len__") and len(value) == len(default)
    return isinstance(value, int | float)
