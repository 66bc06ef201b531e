"""OpenUSD: materials in general position, a branch of the reader each."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.formats.usd.stage import stage_text
from tests.recorded.cases.gltf_corners import _of
from tests.recorded.cases.reader_features import _texels
from tests.recorded.making import in_folder, outcome

TRIANGLE = """
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0.1, 0), (2, 0.3, 0), (2.1, 1, 0.4)]
"""


def _mesh(more: str = "", name: str = "mesh", kind: str = "Mesh", binds: str = "") -> str:
    apis = "MaterialBindingAPI" + (f'", "{binds}' if binds else "")
    return (
        f'def {kind} "{name}" (prepend apiSchemas = ["{apis}"]) {{ {TRIANGLE}; '
        f'uniform token subdivisionScheme = "none"; {more} }}\n'
    )


def _painted(inputs: str, shaders: str = "", mesh: str = "", name: str = "m") -> str:
    """A material by a preview surface, and a mesh with it, each by its name."""
    return (
        f'def Material "{name}" {{ token outputs:surface.connect = </{name}/s.outputs:surface>; '
        f'def Shader "s" {{ uniform token info:id = "UsdPreviewSurface"; {inputs}; '
        f"token outputs:surface }}; {shaders.replace('</m/', f'</{name}/')} }}\n"
    ).replace("</m/", f"</{name}/") + _mesh(
        f"rel material:binding = </{name}>; {mesh}", f"on_{name}"
    )


def _picture(inputs: str = "", name: str = "p") -> str:
    return (
        f'def Shader "{name}" {{ uniform token info:id = "UsdUVTexture"; {inputs}; '
        "float3 outputs:rgb; float outputs:r; float outputs:b; float outputs:a }; "
    )


def _reader(inputs: str, kind: str = "float3") -> str:
    return (
        f'def Shader "v" {{ uniform token info:id = "UsdPrimvarReader_{kind}"; {inputs}; '
        f"{kind} outputs:result }}; "
    )


FILE = "asset inputs:file = @a.png@"
#: Connections of inputs.
COLOR = "color3f inputs:diffuseColor.connect = </m/p.outputs:rgb>"
ROUGH = "float inputs:roughness.connect = </m/p.outputs:b>"
GLOW = "color3f inputs:emissiveColor.connect = </m/v.outputs:result>"

#: Materials, each on a mesh: inputs of the surface, other shaders, lines of the mesh.
MATERIALS: list[tuple[str, ...]] = [
    ("float inputs:ior = 7; float inputs:roughness = 0.31",),
    ("float inputs:ior = 0.1",), ("float inputs:ior = 0; float inputs:metallic = 0.4",),
    ("float inputs:roughness = 1.4; color3f inputs:diffuseColor = (0.2, -0.1, 1.3)",),
    ("float inputs:shine = 3; float inputs:roughnes = 0.2",),
    ("normal3f inputs:normal = (0.3, -0.2, 0.9)",),
    ("float inputs:displacement = 0.07",),
    ("float inputs:displacement.connect = </m/v.outputs:result>", _reader("", "float")),
    ("normal3f inputs:normal.connect = </m/v.outputs:result>", _reader("")),
    ("int inputs:useSpecularWorkflow = 1; color3f inputs:specularColor = (0, 0, 0)",),
    (("int inputs:useSpecularWorkflow = 1; color3f inputs:specularColor = (0.9, 0.6, 0.5); "
     "color3f inputs:diffuseColor = (0, 0, 0)"),),
    (("int inputs:useSpecularWorkflow = 1; color3f inputs:specularColor = (0.7, 0.6, 0.5); "
     "color3f inputs:diffuseColor = (0.5, 0.3, 0.1)"),),
    (("int inputs:useSpecularWorkflow = 1; color3f inputs:specularColor.connect = "
     "</m/p.outputs:rgb>"), _picture(FILE)),
    ("float inputs:opacity = 0.4",), (("float inputs:opacity = 0.4; "
     'token inputs:opacityMode = "presence"'),),
    ("float inputs:opacity = 0.4; float inputs:opacityThreshold = 0.6",),
    ("float inputs:clearcoat = 0.3; float inputs:clearcoatRoughness = 0.17",),
    ("float inputs:occlusion.connect = </m/p.outputs:r>", _picture(FILE)),
    (COLOR, _picture()), (COLOR, _picture("float4 inputs:fallback = (0.2, 0.5, 0.9, 0.3)")),
    ("color3f inputs:diffuseColor.connect = </m/p.outputs:b>",
     _picture("float4 inputs:fallback = (0.2, 0.5, 0.9, 0.3)")),
    (ROUGH, _picture("float4 inputs:fallback = (0.2, 0.5, 0.9, 0.3)")),
    (COLOR + "; " + ROUGH,
     _picture(FILE + "; float4 inputs:scale = (2, 0.7, -0.4, 1); "
              "float4 inputs:bias = (-0.3, 0.1, 0.9, 0)")),
    (ROUGH, _picture(FILE + '; token inputs:wrapS = "useMetadata"; token inputs:wrapT = "zero"')),
    (COLOR, _picture(FILE + '; token inputs:wrapS = "mirror"; token inputs:wrapT = "clamp"; '
                     'token inputs:sourceColorSpace = "sRGB"')),
    (COLOR, _picture(FILE + '; token inputs:sourceColorSpace = "ACES"; float4 inputs:bias = (0.2, '
                     "0.1, 0.4, 0); float2 inputs:st.connect = </m/t.outputs:result>")
     + 'def Shader "t" { uniform token info:id = "UsdTransform2d"; float2 inputs:in.connect = '
       "</m/u.outputs:result>; float inputs:rotation = 0; float2 outputs:result }; "
       'def Shader "u" { uniform token info:id = "UsdTransform2d"; float2 inputs:in.connect = '
       "</m/v.outputs:result>; float inputs:rotation = 31; float2 inputs:scale = (2, 3); "
       "float2 inputs:translation = (0.1, 0.4); float2 outputs:result }; "
     + _reader('string inputs:varname = "uv"', "float2"),
     ("texCoord2f[] primvars:uv = [(0.1, 0.2), (1.4, 0.3), (0.6, 0.7)] "
     '(interpolation = "vertex")')),
    (COLOR, _picture(FILE + "; float2 inputs:st.connect = </m/t.outputs:result>")
     + 'def Shader "t" { uniform token info:id = "UsdTransform2d"; float2 inputs:in.connect = '
       "</m/t.outputs:result>; float2 outputs:result }; "),
    ("normal3f inputs:normal.connect = </m/p.outputs:rgb>", _picture(FILE)),
    ("normal3f inputs:normal.connect = </m/p.outputs:rgb>",
     _picture(FILE + "; float4 inputs:scale = (2, -2, 2, 1); float4 inputs:bias = (-1, 1, -1, 0)")),
    ("float inputs:displacement.connect = </m/p.outputs:a>",
     _picture(FILE + "; float4 inputs:scale = (2, 3, 4, 0.5); "
              "float4 inputs:bias = (1, 2, 3, -0.2)")),
    ("float inputs:displacement.connect = </m/p.outputs:rgb>", _picture(FILE)),
    (GLOW, _reader('string inputs:varname = "glow"'),
     "color3f[] primvars:glow = [(5, 3, 1)] (interpolation = \"constant\")"),
    (GLOW, _reader('string inputs:varname = "glow"; float3 inputs:fallback = (4, 0.2, 7)')),
    (GLOW, _reader('string inputs:varname = "glow"'),
     "color3f primvars:glow = (0.4, 2, 0.6)"),
    (GLOW, _reader('string inputs:varname = "glow"'),
     'string[] primvars:glow = ["a"] (interpolation = "constant")'),
    (GLOW, _reader('string inputs:varname = "displayColor"'),
     ("color3f[] primvars:displayColor = [(0.4, 0.2, 0.6), (0.5, 0.9, 0.1), (0.3, 0.7, 0.8)] "
     '(interpolation = "vertex")')),
    (GLOW, _reader('string inputs:varname = "glow"'),
     ("color3f[] primvars:glow = [(0.4, 0.2, 0.6), (0.5, 0.9, 0.1), (0.3, 0.7, 0.8)] "
     '(interpolation = "vertex")')),
    ("float inputs:roughness.connect = </m/v.outputs:result>",
     _reader('string inputs:varname = "rough"', "float"),
     'float[] primvars:rough = [0.37] (interpolation = "constant")'),
    ("float inputs:roughness.connect = </m/v.outputs:result>",
     'def Shader "v" { uniform token info:id = "ACME_noise"; float outputs:result }; '),
    *(((f"{COLOR}; {ROUGH.replace('/p.', '/q.')}; float inputs:metallic.connect = "
       "</m/o.outputs:r>; float inputs:clearcoat.connect = </m/n.outputs:r>; float inputs:opacity"
       ".connect = </m/l.outputs:r>; float inputs:clearcoatRoughness.connect = </m/k.outputs:r>"),
       "".join(_picture(FILE + f"; float2 inputs:st.connect = </m/v{n}.outputs:result>", n)
               + f'def Shader "v{n}" {{ uniform token info:id = "UsdPrimvarReader_float2"; '
                 f'string inputs:varname = "uv{n}"; float2 outputs:result }}; '
               for n in "pqonlk")),),
]  # fmt: skip


def _all_materials() -> str:
    return "".join(
        _painted(*(one for one in (*parts, "", "")[:3]), name=f"m{number}")
        for number, parts in enumerate(MATERIALS)
    )


DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.38">
  <standard_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" value="0.2, 0.5, 0.7" />
  </standard_surface>
  <surfacematerial name="M" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s" />
  </surfacematerial>
</materialx>
"""


def _files() -> None:
    from alight.outputs import write_image

    write_image("a.png", _texels(3, 4, 3).astype(np.float32) / 255.0)
    with zipfile.ZipFile("b.usdz", "w") as package:
        package.writestr("b.png", b"no picture")


def _own(name: str, **words: Any) -> Any:
    """What a stage says itself, without what is made up for it."""
    found = _of(name, **words)
    if "refused" not in found:
        for key in ("alight", "film", "sampler", "integrator", "camera"):
            found.pop(key, None)
        found["nodes"].pop("studio floor", None)
        found["warnings"] = [one for one in found["warnings"] if "the file has no" not in one]
    return found


def _stages(stages: dict[str, str], **words: Any) -> Callable[[], Any]:
    def run() -> Any:
        with in_folder({"a.mtlx": DOCUMENT, "b.mtlx": DOCUMENT[:90], "a.ies": "none"}) as folder:
            _files()
            found = {}
            for name, text in stages.items():
                (folder / "a.usda").write_text(text, "utf-8")
                found[name] = outcome(_own, "a.usda", **words)
            return found

    return run


CASES = {"materials": _stages({"all": stage_text(_all_materials(), "Z", 0.5)})}
