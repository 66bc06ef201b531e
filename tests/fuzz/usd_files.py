"""Mutated stages of OpenUSD, as text: geometry, instances, materials, lights."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from tests.formats.mutate import TEXT_MUTATIONS, Mutation
from tests.formats.usd.stage import SQUARE, stage_text

# fmt: off
WORDS = (
    "0", "-1", "1e30", "1e-30", "1e300", "2000", "nan", "inf", "-inf", "1e999", "99999999999",
    "true", "None", "", "double inputs:exposure = 1e5", "double inputs:radius = 1e200", "\udcff",
    "[]", "()", "{}", "[1, 2]", "(0, 0, 0)", "((1, 0), (0, 1))", '"x"', "</m>", "</p/one>", "<>",
    "@p.png@", "@../x.usda@", "@/etc/passwd@", "int", "float", "token", "point3f[]", "uniform",
    "def", "over", "class", "Mesh", "Sphere", "Xform", "Material", "Camera", "#", "=",
    "timeSamples",
)
# fmt: on

_CAMERA = """
def Camera "eye" {
    double3 xformOp:translate = (0.5, 0.5, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    float focalLength = 40; float horizontalAperture = 20; float verticalAperture = 20
    float fStop = 2; float focusDistance = 5
}
"""
_STAGES = (
    """
def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>
        float inputs:roughness = 0.3; float inputs:metallic.connect = </m/picture.outputs:r>
        float inputs:opacity = 0.8; float inputs:clearcoat = 0.5; float inputs:ior = 1.4
        color3f inputs:emissiveColor = (0.1, 0.2, 0.3)
        token outputs:surface
    }
    def Shader "picture" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @p.png@
        token inputs:wrapS = "mirror"; token inputs:sourceColorSpace = "raw"
        float4 inputs:scale = (0.5, 0.5, 0.5, 1); float4 inputs:bias = (0.1, 0, 0, 0)
        float2 inputs:st.connect = </m/place.outputs:result>
        float3 outputs:rgb
        float outputs:r
    }
    def Shader "place" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </m/reader.outputs:result>
        float2 inputs:scale = (2, 3); float inputs:rotation = 30
        float2 outputs:result
    }
    def Shader "reader" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
}
def Mesh "mesh" (prepend apiSchemas = ["MaterialBindingAPI"]) { SQUARE
    rel material:binding = </m>
    normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 1, 1), (0, 0, 1)] (interpolation = "vertex")
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
    color3f[] primvars:displayColor = [(1, 0, 0)]
    def GeomSubset "part" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        uniform token elementType = "face"; uniform token familyName = "materialBind"
        int[] indices = [0]
        rel material:binding = </m>
    }
}
def SphereLight "l" { float inputs:intensity = 3; float inputs:radius = 0.5
    bool inputs:normalize = 1; color3f inputs:color = (1, 0.5, 0.2)
    double3 xformOp:translate = (0, 3, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
""",
    """
def PointInstancer "p" {
    rel prototypes = [</p/one>, </p/two>]
    int[] protoIndices = [0, 1, 0]
    point3f[] positions = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    quath[] orientations = [(1, 0, 0, 0), (0.7, 0.7, 0, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (0.5, 0.5, 0.5), (1, 1, 1)]
    int64[] invisibleIds = [2]
    def Mesh "one" {SQUARE}
    def Xform "two" { def Sphere "s" { double radius = 0.5 } }
}
class "thing" { def Mesh "box" {
    int[] faceVertexCounts = [3, 3, 3, 3]
    int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    uniform token subdivisionScheme = "catmullClark"; uniform token orientation = "leftHanded"
} }
def Xform "a" (instanceable = true; inherits = </thing>) {
    float3 xformOp:rotateXYZ = (10, 20, 30); float3 xformOp:scale = (1, -1, 2)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ", "xformOp:scale"]
}
def Xform "b" (instanceable = true; inherits = </thing>) { }
def DomeLight "sky" { float inputs:intensity = 0.5; float inputs:exposure = 1
    asset inputs:texture:file = @p.png@
}
""",
    """
def Cube "c" { double size = 1
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 9: (1, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Cylinder "y" { double radius = 0.3; double height = 2; token axis = "X" }
def Cone "k" { double radius = 0.5; double height = 1; token visibility = "invisible" }
def Plane "floor" { double width = 8; double length = 8; token axis = "Y" }
def DistantLight "sun" { float inputs:intensity = 4; float inputs:angle = 1 }
def RectLight "r" (prepend apiSchemas = ["ShapingAPI"]) { float inputs:width = 2
    float inputs:shaping:cone:angle = 40; float inputs:shaping:focus = 1
    matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 4, 1))
    uniform token[] xformOpOrder = ["xformOp:transform"]
}
""",
)


def copy_pictures(folder: Path) -> None:
    """Put the picture that stages name into a folder."""
    Image.linear_gradient("L").resize((4, 3)).convert("RGB").save(folder / "p.png")


def usd_files(seed: int, n: int) -> Iterator[Mutation]:
    """Yield `n` files, each with a name of its own: OpenUSD remembers what it has read."""
    rng = random.Random(seed)
    for i in range(n):
        stage = rng.choice(_STAGES).replace("SQUARE", SQUARE) + _CAMERA
        text = stage_text(stage, up=rng.choice("YZ"), unit=rng.choice((1, 0.01)))
        for _ in range(rng.choice((1, 1, 1, 2, 5))):
            change = rng.choice((_swap_word, _swap_word, _swap_word, *TEXT_MUTATIONS))
            text = change(text, rng)
        name = f"broken-{i}.usda"
        # Lone surrogates stand for bytes that are no text.
        yield Mutation(name, name, text.encode("utf-8", "surrogateescape"))


def _swap_word(text: str, rng: random.Random) -> str:
    """Replace what stands between two blanks, or within brackets and quotes."""
    ends = [i for i, c in enumerate(text) if c in ' ,\n"[](){}<>@']
    if len(ends) < 2:
        return text
    at = rng.randrange(len(ends) - 1)
    return text[: ends[at] + 1] + rng.choice(WORDS) + text[ends[at + 1] :]
