"""OpenUSD: branches that few stages take, in general position, and stages with a problem each."""

from __future__ import annotations

from tests.formats.usd.stage import stage_text
from tests.recorded.cases.usd_materials import (
    COLOR,
    FILE,
    ROUGH,
    _mesh,
    _painted,
    _picture,
    _stages,
)

LIGHT = "float inputs:intensity = 3.5; color3f inputs:color = (0.9, 0.6, 0.3)"
GLOWS = "color3f inputs:emissiveColor = (0.3, 0.5, 0.2)"
CORNERS = "point3f[] points = [(0, 0, 0.1), (1, 2, 3), (2, 1, 6), (0, 1, 9), (1, 0, 11)]"


def _skinned(mesh: str, bones: str = "", walk: str = "") -> str:
    """A mesh on two joints, with a blend shape."""
    unit = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0.1, 0.2, 0.3, 1))"
    return (
        'def SkelRoot "r" { '
        + _mesh(
            "rel skel:skeleton = </r/b>; "
            'uniform token[] skel:blendShapes = ["grin"]; '
            f"rel skel:blendShapeTargets = [</r/mesh/grin>]; {mesh}; "
            'def BlendShape "grin" { uniform vector3f[] offsets = [(0.1, 0.2, 0.3), (0, 0.4, 0.5), '
            "(0.6, 0, 0.7)] }",
            binds="SkelBindingAPI",
        )
        + 'def Skeleton "b" (prepend apiSchemas = ["SkelBindingAPI"]) { '
        'rel skel:animationSource = </r/w>; uniform token[] joints = ["a", "a/b"]; '
        f"uniform matrix4d[] bindTransforms = [{unit}, {unit}]; uniform matrix4d[] "
        f"restTransforms = [{unit}, {unit}]; "
        f'{bones} }}; def SkelAnimation "w" {{ uniform token[] joints = ["a", "a/b"]; '
        "float3[] translations = [(0, 1, 0.1), (0.1, 0.2, 0)]; quatf[] rotations = "
        "[(0.8, 0.6, 0, 0), (0.6, 0, 0, 0.8)]; half3[] scales = [(1, 1.2, 1), (0.9, 1, 1.1)]; "
        f'uniform token[] blendShapes = ["grin"]; float[] blendShapeWeights = [0.7]; {walk} }}; }}'
    )


HELD = (
    (
        'int[] primvars:skel:jointIndices = [0, 1, 1] (elementSize = 1; interpolation = "vertex"); '
        "float[] primvars:skel:jointWeights = [1, 0.5, 1] (elementSize = 1; interpolation = "
        '"vertex")'
    )
    .replace("(e", "(\ne")
    .replace('x")', 'x"\n)')
)

#: By name: a stage.
STAGES: dict[str, str] = {
    "nothing": 'def Xform "a" { }',
    "negative counts": 'def Mesh "a" { int[] faceVertexCounts = [3, -1]; int[] faceVertexIndices '
    f"= [0, 1]; {CORNERS} }}",
    "counts": f'def Mesh "a" {{ int[] faceVertexCounts = [4]; int[] faceVertexIndices = [0, 1, 2]; '
    f"{CORNERS} }}",
    "corners": f'def Mesh "a" {{ int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, '
    f"-2]; {CORNERS} }}",
    "corners beyond": 'def Mesh "a" { int[] faceVertexCounts = [3]; int[] faceVertexIndices = '
    f"[0, 1, 7]; {CORNERS} }}",
    "points far": _mesh("").replace("2.1, 1", "2e15, 1"),
    "no faces": f'def Mesh "a" {{ int[] faceVertexCounts = [2, 3]; int[] faceVertexIndices = [0, 1,'
    f" 0, 1, 2]; int[] holeIndices = [1]; {CORNERS} }}",
    "holes, left-handed": 'def Mesh "a" { int[] faceVertexCounts = [4, 3, 3]; int[] '
    "faceVertexIndices = [0, 1, 2, 3, 2, 3, 4, 0, 2, 4]; int[] holeIndices = [1, 9]; uniform token "
    f'orientation = "leftHanded"; uniform token subdivisionScheme = "none"; {CORNERS}; normal3f[] '
    "normals = [(0, 0.1, 1), (0.2, 0, 1), (0.3, 0.1, 0.8), (0.1, 0.4, 0.7), (0.5, 0.6, 0.7)]; "
    "color3f[] primvars:displayColor = [(0.1, 0.9, 0.4), (0.2, 1.5, 0.3), (0.3, 0.1, 0.8)] "
    '(interpolation = "uniform") }',
    "what does not fit": _mesh(
        "normal3f[] normals = [(0, 0, 1), (0, 1, 0)]; texCoord2f[] primvars:st = [(0, 0.1)] "
        '(interpolation = "vertex"); color3f[] primvars:displayColor = [(0.1, 0.2, 0.3), '
        '(0.4, 0.5, 0.6)] (interpolation = "faceVarying")'
    ),
    "normals of a primvar": _mesh(
        "normal3f[] primvars:normals = [(0.1, 0.2, 1), (0.3, 0, 1), (0, 0.4, 1)] "
        '(interpolation = "varying"); normal3f[] normals = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]; '
        'float[] primvars:displayOpacity = [0.2, 0.9, 0.7] (interpolation = "vertex")'
    ),
    "opacity": _mesh("float[] primvars:displayOpacity = [0.35]; color3f[] primvars:displayColor "
                     "= [(0.7, 0.2, 1.4)]"),
    "subsets": 'def Mesh "a" { int[] faceVertexCounts = [3, 3, 3]; int[] faceVertexIndices = [0, '
    f'1, 2, 2, 3, 4, 0, 2, 4]; {CORNERS}; def GeomSubset "one" (prepend apiSchemas = '
    '["MaterialBindingAPI"]) { uniform token familyName = "materialBind"; int[] indices = [1, 2]; '
    'rel material:binding = </m> }; def GeomSubset "two" (prepend apiSchemas = '
    '["MaterialBindingAPI"]) { uniform token familyName = "materialBind"; int[] indices = [2]; '
    "rel material:binding = </n> } }" + _painted("float inputs:roughness = 0.2")
    + _painted("float inputs:roughness = 0.7", name="n"),
    "left out": 'def Xform "a" { token model:drawMode = "bounds"; def NurbsPatch "n" { }; '
    'def Volume "v" { }; def Scope "s" { def Sphere "i" { token visibility = "invisible" }; '
    'def Sphere "p" { uniform token purpose = "proxy" }; def Sphere "r" { uniform token purpose = '
    '"render"; double radius = 0.3 } } }; def PortalLight "portal" { }; def GeometryLight "g" { }',
    "reset": 'def Xform "a" { float xformOp:rotateX = 20; uniform token[] xformOpOrder = '
    '["xformOp:rotateX"]; def Cube "c" { double3 xformOp:translate = (1, 2, 3); uniform token[] '
    'xformOpOrder = ["!resetXformStack!", "xformOp:translate"] } }',
    "flat and reset": 'def Xform "a" { float3 xformOp:scale = (0, 1, 2); uniform token[] '
    'xformOpOrder = ["xformOp:scale"]; def Cube "c" { uniform token[] xformOpOrder = '
    '["!resetXformStack!"] } }',
    "skewed": 'def Cube "c" { matrix4d xformOp:transform = ((1, 0, 0, 0.5), (0, 1, 0, 0), (0, 0, 1,'
    ' 0), (0, 0, 0, 1)); uniform token[] xformOpOrder = ["xformOp:transform"] }',
    "far": 'def Cube "c" { double3 xformOp:translate = (1e13, 0, 0); uniform token[] xformOpOrder '
    '= ["xformOp:translate"]; float3 xformOp:scale = (1e9, 1e9, 1e9) }; def Xform "d" { float3 '
    'xformOp:scale = (1e9, 1e9, 1e9); uniform token[] xformOpOrder = ["xformOp:scale"]; '
    'def Xform "e" { float3 xformOp:scale = (1e9, 1e9, 1e9); uniform token[] xformOpOrder = '
    '["xformOp:scale"]; def Cube "f" { } } }',
    "types": 'def Sphere "s" { string radius = "a" }; def Cube "c" { double size = inf }; '
    'def Cone "k" { token axis = "W"; double height = -1.4; double radius = 0.7 }; '
    'def Capsule "p" { double height = 1.3; double radius = 0.2; token axis = "X" }; '
    'def Plane "q" { double width = 1.7; double length = 0.6; uniform token axis = "Y" }',
    "curves": "".join(
        f'def BasisCurves "c{number}" {{ int[] curveVertexCounts = [5]; {CORNERS}; {more} }}\n'
        for number, more in enumerate((
            'uniform token wrap = "looped"', 'uniform token basis = "hermite"',
            "int[] curveVertexCounts = [4]", 'uniform token type = "linear"; float[] widths = [-1]',
            'uniform token basis = "bspline"; float[] widths = [0.1, 0.2, 0.3]',
        ))
    ),
    "thin curves": 'def BasisCurves "a" { int[] curveVertexCounts = []; point3f[] points = [] }; '
    f'def BasisCurves "b" {{ int[] curveVertexCounts = [5]; {CORNERS}; uniform token basis = '
    f'"bspline" }}; def BasisCurves "c" {{ int[] curveVertexCounts = [5]; {CORNERS}; uniform token '
    'type = "linear"; uniform token wrap = "periodic"; float[] widths = [0.4]; float[] '
    'primvars:widths = [0.1, 0.2, 0.3, 0.5, 0.7] (interpolation = "varying") }; '
    f'def BasisCurves "d" {{ int[] curveVertexCounts = [5]; {CORNERS}; uniform token basis = '
    '"catmullRom"; uniform token wrap = "periodic"; float[] widths = [0.1, 0.2, 0.3, 0.5, 0.8] '
    '(interpolation = "varying") }',
    "points": "".join(
        f'def Points "p{number}" {{ {CORNERS}; {more} }}\n'
        for number, more in enumerate((
            "", "float[] widths = [0, 0, 0, 0, 0]",
            ("float[] widths = [0.2]; color3f[] primvars:displayColor = [(0.1, 0.2, 0.3), "
            "(0.4, 0.5,"
            ' 0.6)] (interpolation = "vertex")'),
            ("float[] widths = [0.9]; float[] primvars:widths = [0, 0.1, 0.2, 0, 0.3] "
            '(interpolation = "vertex"); normal3f[] normals = [(0, 0, 1)]'),
        ))
    ),
    "wrong points": f'def Points "p" {{ {CORNERS}; float[] widths = [0.1, 0.2] }}; '
    f'def Points "q" {{ {CORNERS}; float[] widths = [-0.1] }}',
    "wrong instances": 'def PointInstancer "i" { int[] protoIndices = [0, 2]; point3f[] positions '
    '= [(0, 0, 0), (1, 1, 1)]; rel prototypes = [</i/a>]; def Cube "a" { } }',
    "few instances": 'def PointInstancer "i" { int[] protoIndices = [0, 0]; point3f[] positions '
    '= [(0, 0, 0)]; rel prototypes = [</i/a>]; def Cube "a" { } }',
    "far instances": 'def PointInstancer "i" { int[] protoIndices = [0]; point3f[] positions '
    '= [(0, 0, 0)]; float3[] scales = [(inf, 1, 1)]; rel prototypes = [</i/a>]; def Cube "a" { } }',
    "instances of nothing": 'def PointInstancer "i" { int[] protoIndices = [1, 0, 0]; point3f[] '
    "positions = [(0, 0.5, 0), (1, 1, 2), (3, 1, 4)]; int64[] invisibleIds = [2]; rel prototypes = "
    '[</i/a>, </none>]; def Cube "a" { double size = 0.4 } }',
    "lights": "".join(
        f'def {kind} "l{number}" (prepend apiSchemas = ["ShapingAPI"]) {{ {LIGHT}; {more} }}\n'
        for number, (kind, more) in enumerate((
            ("SphereLight", "float inputs:radius = 0; bool inputs:normalize = 1"),
            ("SphereLight", ("float inputs:radius = 0.3; float inputs:shaping:focus = 3; "
             "asset inputs:shaping:ies:file = @a.ies@; bool treatAsPoint = 1")),
            ("SphereLight", ("float inputs:radius = 0.4; float inputs:shaping:cone:angle = 25; "
             "float inputs:shaping:cone:softness = 1.7; asset inputs:shaping:ies:file = @a.ies@")),
            ("RectLight", ("float inputs:width = 0.7; float inputs:exposure = 1.5; "
             "bool inputs:normalize = 1; float inputs:shaping:focus = 1")),
            ("DiskLight", ("bool inputs:enableColorTemperature = 1; float "
             "inputs:colorTemperature = 3200")),
            ("CylinderLight", "float inputs:length = 0.3; bool inputs:normalize = 1"),
            ("DistantLight", "float inputs:angle = 8"),
            ("DistantLight", "float inputs:angle = 170"),
            ("DistantLight", ("float inputs:angle = 4; bool inputs:normalize = 1; float3 "
             'xformOp:scale = (1, 2, 3); uniform token[] xformOpOrder = ["xformOp:scale"]')),
            ("DistantLight", "color3f inputs:color = (0.1, -0.3, 0.2)"),
            ("DomeLight", ""), ("DomeLight", ('asset inputs:texture:file = @a.png@; token '
             'inputs:texture:format = "angular"; float3 xformOp:rotateXYZ = (80, 20, 40); uniform '
             'token[] xformOpOrder = ["xformOp:rotateXYZ"]')),
            ("DomeLight", ('asset inputs:texture:file = @a.png@; float3 xformOp:scale = (1, 2, 3); '
             'uniform token[] xformOpOrder = ["xformOp:scale"]')),
            ("DomeLight_1", ('asset inputs:texture:file = @a.png@; token poleAxis = "Z"; '
             'float xformOp:rotateZ = 25; uniform token[] xformOpOrder = ["xformOp:rotateZ"]')),
            ("DomeLight_1", 'asset inputs:texture:file = @a.png@; token poleAxis = "Y"'),
        ))
    ),
    "too bright": f'def SphereLight "a" {{ {LIGHT}; float inputs:exposure = 2000 }}',
    "lost dome": f'def DomeLight "a" {{ {LIGHT}; asset inputs:texture:file = @none.exr@ }}',
    "meshes that shine": "".join(
        _painted(GLOWS, name=f"m{number}").replace(
            '["MaterialBindingAPI"]', '["MaterialBindingAPI", "MeshLightAPI"]'
        ).replace("uniform token subd", f"{LIGHT}; uniform token light:materialSyncMode = "
                  f'"{mode}"; uniform token subd')
        for number, mode in enumerate(
            ("materialGlowTintsLight", "independent", "noMaterialResponse"))
    ),
    "pictures that shine": "".join(
        _painted("color3f inputs:emissiveColor.connect = </m/p.outputs:rgb>", _picture(FILE),
                 name=f"m{number}").replace(
            '["MaterialBindingAPI"]', '["MaterialBindingAPI", "MeshLightAPI"]'
        ).replace("uniform token subd", f"{LIGHT}; uniform token light:materialSyncMode = "
                  f'"{mode}"; uniform token subd')
        for number, mode in enumerate(("materialGlowTintsLight", "independent"))
    ),
    "no shader": 'def Material "m" { }' + _mesh("rel material:binding = </m>; color3f[] "
                                                "primvars:displayColor = [(0.2, 0.6, 0.4)]"),
    "another shader": 'def Material "m" { token outputs:surface.connect = </m/s.outputs:surface>; '
    'def Shader "s" { uniform token info:id = "ACME_paint"; token outputs:surface } }'
    + _mesh("rel material:binding = </m>"),
    "networks": 'def Material "m" { token outputs:mtlx:surface.connect = </m/s.outputs:out>; '
    'def Shader "s" { uniform token info:id = "ND_standard_surface_surfaceshader"; color3f '
    "inputs:base_color.connect = </m/c.outputs:out>; float inputs:metalness.connect = "
    "</m/f.outputs:out>; float inputs:specular_roughness.connect = </m/v.outputs:result>; "
    "color3f inputs:emission_color.connect = </m/i.outputs:out>; float inputs:emission = 0.4; "
    "int inputs:none; token outputs:out }; "
    'def Shader "c" { uniform token info:id = "ND_geompropvalue_color3"; string inputs:geomprop = '
    '"displayColor"; color3f outputs:out }; def Shader "f" { uniform token info:id = '
    '"ND_geompropvalue_float"; string inputs:geomprop = "metal"; float outputs:out }; '
    'def Shader "v" { uniform token info:id = "UsdPrimvarReader_float"; string inputs:varname = '
    '"rough"; float outputs:result }; def Shader "i" { uniform token info:id = "ND_image_color3"; '
    "asset inputs:file = @none.png@; color3f inputs:default = (0.1, 0.2, 0.7); color3f "
    "outputs:out } }" + _mesh("rel material:binding = </m>; float[] primvars:metal = [0.3] "
    "(interpolation = "
                 '"constant"); float[] primvars:rough = [0.1, 0.2, 0.3] (interpolation = '
                 '"vertex"); '
                 "color3f[] primvars:displayColor = [(0.1, 0.2, 0.3), (0.4, 0.5, 0.9), (0.7, 0.8, "
                 '0.6)] (interpolation = "vertex")'),
    "another network": 'def Material "m" { token outputs:mtlx:surface.connect = '
    '</m/s.outputs:out>; def Shader "s" { uniform token info:id = "ND_volume"; token outputs:out } '
    "}" + _mesh("rel material:binding = </m>; color3f[] primvars:displayColor = [(0.2, 0.6, 0.4)]"),
    "lost pictures": _painted(COLOR + "; " + ROUGH, _picture("asset inputs:file = @none.png@")),
    "broken pictures": _painted(COLOR, _picture("asset inputs:file = @b.usdz[b.png]@")),
    "pictures without": _painted(COLOR, _picture("asset inputs:file = @/none/a.png@")),
    "skin": _skinned(HELD), "skin by shapes alone": _skinned(""),
    "skin of other joints": _skinned(HELD + '; uniform token[] skel:joints = ["c", "a"]'),
    "skin beyond": _skinned(HELD.replace("[0, 1, 1]", "[0, 1, 7]")),
    "skin too short": _skinned(HELD.replace("[1, 0.5, 1]", "[1, 0.5]")),
    "skin as rotations": _skinned(HELD + "; uniform token primvars:skel:skinningMethod = "
                                  '"dualQuaternion"'),
    "skin of few weights": _skinned(HELD, walk="float[] blendShapeWeights = [0.7, 0.2]"),
    "skin of no weights": _skinned(HELD, walk="float[] blendShapeWeights = []"),
    "skin of wrong shapes": _skinned(HELD).replace("[(0.1, 0.2, 0.3), (0, ", "[(0, "),
    "skin of shapes beyond": _skinned(HELD).replace(
        "uniform vector3f[] offsets", "uniform int[] pointIndices = [0, 1, 5]; "
        "uniform vector3f[] offsets"),
    "skin without bones": _skinned(HELD, "uniform matrix4d[] bindTransforms = []"),
    "referred outside": 'def "a" (references = @../a.usda@) { }',
    "wrong documents": 'def "a" (references = @b.mtlx@) { }',
}  # fmt: skip

#: As text, with other heads.
WHOLE = {
    "no unit": '#usda 1.0\n( metersPerUnit = -1 )\ndef Cube "a" {\n}\n',
    "no rate": '#usda 1.0\n(\n startTimeCode = 3\n endTimeCode = 9\n timeCodesPerSecond = 0\n)\n'
               'def Cube "a" {\n double size.timeSamples = { 3: 0.5, 6: 1.5, 9: 2 }\n}\n',
    "frames": '#usda 1.0\n(\n startTimeCode = 3\n endTimeCode = 9\n framesPerSecond = 12\n)\n'
              'def Cube "a" {\n double size.timeSamples = { 3: 0.5, 6: 1.5, 9: 2 }\n}\n',
}  # fmt: skip


def _texts(*names: str) -> dict[str, str]:
    found = {name: STAGES[name].replace("}def", "}\ndef") for name in names or STAGES}
    return {name: stage_text(text, "Z", 0.5) for name, text in found.items()}


LOST = ("lost dome", "lost pictures", "networks", "broken pictures", "pictures without")

CASES = {
    "stages": _stages(_texts()),
    "lenient": _stages(_texts(*LOST), lenient=True),
    "whole": _stages(WHOLE),
    "later": _stages(WHOLE, at=0.25),
}
