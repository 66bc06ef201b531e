"""Networks of MaterialX in a stage: shaders by the names of their definitions, ``ND_...``.

Source: Pixar, OpenUSD documentation, UsdShade and UsdMtlx; the specification of MaterialX.
"""

from __future__ import annotations

from typing import Any

from alight.formats.materials.textures import CHECKERED, MISSING, WITHOUT
from alight.formats.materialx.nodes import Input, Node, category_of
from alight.formats.materialx.scene import DocumentHost
from alight.formats.materialx.values import Plain, Value, spread, textured
from alight.formats.reading.reach import OutOfReachError
from alight.formats.usd.modules import Sdf, UsdGeom, UsdShade
from alight.formats.usd.stage import Stage
from alight.formats.usd.textures import DEFAULT_COORDINATES, picture_of
from alight.textures.images import Image

#: Types of OpenUSD -> those of MaterialX.
_KINDS = {
    "asset": "filename", "bool": "boolean", "color3d": "color3", "color3f": "color3",
    "color3h": "color3", "color4d": "color4", "color4f": "color4", "color4h": "color4",
    "double": "float", "double2": "vector2", "double3": "vector3", "double4": "vector4",
    "float": "float", "float2": "vector2", "float3": "vector3", "float4": "vector4",
    "half": "float", "int": "integer", "normal3f": "vector3", "point3f": "vector3",
    "string": "string", "texCoord2f": "vector2", "token": "string", "vector3f": "vector3",
}  # fmt: skip


class StageHost(DocumentHost):
    """What an evaluator needs of a stage.

    Parameters
    ----------
    stage : Stage
    prim : Usd.Prim
        Whose primvars are read.
    """

    space = "auto"
    coordinates = DEFAULT_COORDINATES

    def __init__(self, stage: Stage, prim: Any) -> None:
        super().__init__(stage.report, stage.reach)
        self.stage, self.prim = stage, prim
        self.meters = float(UsdGeom.GetStageMetersPerUnit(stage.stage))

    def set_name(self, index: int) -> str:
        """Name of a set of coordinates by its number: st, st1, ..."""
        return f"{DEFAULT_COORDINATES}{index}" if index else DEFAULT_COORDINATES

    def primvar(self, node: Node, name: str, width: int) -> Value | None:
        """A primvar that is the same all over the prim, or the colours of vertices."""
        primvar = UsdGeom.PrimvarsAPI(self.prim).FindPrimvarWithInheritance(name)
        if not primvar or not primvar.HasValue():
            return None
        table = self.stage.table(primvar)
        if table is None or not len(table):
            return None
        if primvar.GetInterpolation() == UsdGeom.Tokens.constant:
            return spread(Plain(tuple(float(x) for x in table[0])), width)
        if name == "displayColor" and width >= 3:
            return spread(textured({"type": "vertex_color", "fallback": 0.18}, 3), width)
        self.report.approximate(f"{node.place}: primvar {name} varies, which only displayColor may")
        return None

    def picture(self, node: Node, entry: Input, is_color: bool) -> str | Image | None:
        """The picture of an asset."""
        if not isinstance(entry.asset, Sdf.AssetPath):
            return super().picture(node, entry, is_color)
        try:
            return picture_of(self.stage, entry.asset)
        except OutOfReachError as error:
            replacement = CHECKERED if is_color else WITHOUT
            self.report.lacks_at(self.stage.name, node.place, error, replacement)
            return MISSING if is_color and self.report.can_do_without(error) else None


def network_of(stage: Stage, shader: Any) -> Node:
    """The network that ends in a shader."""
    nodes: dict[str, Node] = {}
    root = _node(shader)
    nodes[str(shader.GetPath())] = root
    stack = [(shader, root)]
    while stack:
        current, node = stack.pop()
        for entry in current.GetInputs():
            source = _source(entry)
            kind = _KINDS.get(str(entry.GetTypeName()), "")
            if source is None:
                node.inputs[entry.GetBaseName()] = _given(stage, entry, kind)
                continue
            path = str(source.GetPrim().GetPath())
            if path not in nodes:
                below = UsdShade.Shader(source.GetPrim())
                nodes[path] = _node(below)
                stack.append((below, nodes[path]))
            output = source.GetBaseName()
            output = "" if output == "out" else output
            node.inputs[entry.GetBaseName()] = Input(kind, source=nodes[path], output=output)
    return root


def _node(shader: Any) -> Node:
    identifier = str(shader.GetIdAttr().Get() or "")
    category, kind, version = category_of(identifier)
    if identifier.startswith("UsdPrimvarReader"):
        category = "UsdPrimvarReader"
    outputs = shader.GetOutputs()
    if not kind and len(outputs) == 1:
        kind = _KINDS.get(str(outputs[0].GetTypeName()), "")
    path = str(shader.GetPath())
    return Node(shader.GetPrim().GetName(), category or identifier, kind, path, version=version)


def _source(entry: Any) -> Any:
    """The output that an input is connected to, through the interfaces of graphs."""
    for attribute in UsdShade.Utils.GetValueProducingAttributes(entry):
        kind = UsdShade.Utils.GetType(attribute.GetName())
        if kind == UsdShade.AttributeType.Output:
            return UsdShade.Output(attribute)
    return None


def _given(stage: Stage, entry: Any, kind: str) -> Input:
    """What an input is given as such."""
    attributes = UsdShade.Utils.GetValueProducingAttributes(entry)
    if not attributes:
        return Input(kind)
    attribute = attributes[0]
    found = stage.value(attribute)
    space = str(attribute.GetColorSpace() or "") if attribute.HasColorSpace() else ""
    made = Input(kind or _KINDS.get(str(attribute.GetTypeName()), ""), space=space)
    if isinstance(found, Sdf.AssetPath):
        made.asset = found if found.path else None
        made.value = found.path or None
    elif isinstance(found, bool | int | float | str):
        made.value = found
    elif found is not None and hasattr(found, "__len__"):
        made.value = tuple(float(x) for x in found)
    return made
