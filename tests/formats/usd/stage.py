"""Stages of OpenUSD as text."""

import numpy as np

from alight.scene.flatten import flatten
from tests.formats.bare import load

#: A triangle with a texture, which has inputs, and other nodes beside it.
TEXTURED = """
def Material "m" {{
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>
        token outputs:surface
    }}
    def Shader "picture" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @{file}@
        {inputs}
        float3 outputs:rgb
    }}
{nodes}
}}
def Mesh "mesh" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0)]
    rel material:binding = </m>
    texCoord2f[] primvars:st = [(0, 0), ({u}, 0), ({u}, {v})] (interpolation = "vertex")
}}
"""


def stage_text(text, up="Y", unit=1):
    """A stage: OpenUSD wants every statement on a line of its own."""
    lines = text.replace("; ", "\n").replace("{ ", "{\n").replace("}", "\n}")
    return HEAD.format(up=up, unit=unit) + lines


HEAD = '#usda 1.0\n(\n    upAxis = "{up}"\n    metersPerUnit = {unit}\n)\n'
SQUARE = """
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
"""


def shapes(scene):
    """Node path -> node of everything that has a shape."""
    return {path: node for path, _, node in scene.walk() if node.shape is not None}


def world_points(scene):
    """Vertices of all meshes in the world, in the order of the file."""
    found = [
        item.to_world[:3, :3] @ item.shape.vertices.T.astype(float) + item.to_world[:3, 3:]
        for item in flatten(scene).shapes
    ]
    return np.concatenate(found, axis=1).T


def usd_loader(folder):
    """A function that loads a stage given as text, from a file in `folder`; without a floor."""

    def run(text, up="Y", unit=1, name="a.usda"):
        (folder / name).write_text(stage_text(text, up, unit))
        return load(folder / name)

    return run


#: A mesh with a material: inputs of its preview surface, and the mesh.
MATERIAL = """
def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        %s
        token outputs:surface
    }
    def Shader "picture" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @p.png@
        token inputs:wrapS = "mirror"
        float4 inputs:scale = (0.5, 0.5, 0.5, 1)
        float2 inputs:st.connect = </m/place.outputs:result>
        float3 outputs:rgb
        float outputs:g
    }
    def Shader "place" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </m/reader.outputs:result>
        float2 inputs:scale = (2, 3)
        float2 outputs:result
    }
    def Shader "reader" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "uv2"
        float2 outputs:result
    }
}
def Mesh "mesh" (prepend apiSchemas = ["MaterialBindingAPI"]) { %s
    rel material:binding = </m>
    texCoord2f[] primvars:uv2 = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
}
"""
