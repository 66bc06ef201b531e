"""Materials of MaterialX in stages: networks of their shaders, and documents that layers name."""

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("pxr")

import alight
from tests.formats.bare import load
from tests.formats.usd.stage import SQUARE, stage_text

MESH = """
def Mesh "wall" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = <%s>
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
    %s
}
"""
NETWORK = """
def Material "m" {
    token outputs:mtlx:surface.connect = </m/s.outputs:out>
    %s
    def Shader "s" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        float inputs:specular_roughness = 0.25
        color3f inputs:base_color.connect = </m/g.outputs:c>
        token outputs:out
    }
    def NodeGraph "g" {
        color3f inputs:tint = (0.5, 0.25, 0.125)
        color3f outputs:c.connect = </m/g/x.outputs:out>
        def Shader "x" {
            uniform token info:id = "ND_multiply_color3"
            color3f inputs:in1.connect = </m/g/p.outputs:out>
            color3f inputs:in2.connect = </m/g.inputs:tint>
            color3f outputs:out
        }
        def Shader "p" {
            uniform token info:id = "ND_image_color3"
            asset inputs:file = @a.png@
            float2 inputs:texcoord.connect = </m/g/t.outputs:out>
            color3f outputs:out
        }
        def Shader "t" {
            uniform token info:id = "ND_geompropvalue_vector2"
            string inputs:geomprop = "st"
            float2 outputs:out
        }
    }
}
"""
PREVIEW = """
    token outputs:surface.connect = </m/plain.outputs:surface>
    def Shader "plain" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (1, 0, 0)
        token outputs:surface
    }
"""
DOCUMENT = """<materialx version="1.38" colorspace="lin_rec709">
  <image name="p" type="color3"><input name="file" type="filename" value="%s"/></image>
  <standard_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" nodename="p"/>
  </standard_surface>
  <surfacematerial name="Wood" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S"/>
  </surfacematerial>
</materialx>"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a picture."""
    Image.fromarray(np.full((2, 2, 3), 128, np.uint8)).save(tmp_path / "a.png")
    return tmp_path


def bsdf_of(folder, text):
    """The material of the only mesh, and what was said."""
    (folder / "a.usda").write_text(stage_text(text))
    scene = load(folder / "a.usda")
    (node,) = (node for _, _, node in scene.walk() if node.shape is not None)
    return scene.bsdfs[node.bsdf].bsdf, scene.warnings, node


def test_a_network_is_read_through_its_graphs(folder):
    found, said, node = bsdf_of(folder, NETWORK % "" + MESH % ("/m", SQUARE))
    assert found.roughness == 0.25
    assert found.base_color.type_name() == "multiply"
    texture = found.base_color.b
    assert (texture.file, texture.color_space) == ("a.png", "auto")
    assert found.base_color.a == (0.5, 0.25, 0.125)
    assert node.shape.uvs is not None
    assert not any("/m" in line for line in said)


def test_the_network_counts_before_the_preview(folder):
    found, _, _ = bsdf_of(folder, NETWORK % PREVIEW + MESH % ("/m", SQUARE))
    assert found.roughness == 0.25


def test_the_preview_stands_for_a_network_that_is_not_covered(folder):
    unknown = NETWORK.replace("ND_standard_surface_surfaceshader", "ND_disney_principled")
    found, said, _ = bsdf_of(folder, unknown % PREVIEW + MESH % ("/m", SQUARE))
    assert found.base_color == (1.0, 0.0, 0.0)
    assert any("ND_disney_principled" in line for line in said)


@pytest.mark.parametrize("how", ["references", "payload"])
def test_documents_that_layers_refer_to(how, folder):
    (folder / "looks").mkdir()
    (folder / "looks" / "wood.mtlx").write_text(DOCUMENT % "../a.png")
    text = f'def "looks" ({how} = @looks/wood.mtlx@</MaterialX>) {{ }}\n'
    found, _, _ = bsdf_of(folder, text + MESH % ("/looks/Materials/Wood", SQUARE))
    assert found.base_color.file == "a.png"
    assert found.base_color.color_space == "linear"


def test_changes_of_a_document_by_a_stage_are_told(folder):
    (folder / "wood.mtlx").write_text(DOCUMENT % "a.png")
    over = 'over "Materials" { over "Wood" { float inputs:base = 0.5 } } '
    text = f'def "looks" (references = @wood.mtlx@</MaterialX>) {{ {over} }}\n'
    found, said, _ = bsdf_of(folder, text + MESH % ("/looks/Materials/Wood", SQUARE))
    assert found.base_color.file == "a.png"
    assert any("what the stage changes" in line for line in said)


def test_problems_of_documents_have_their_place(folder):
    text = 'def "looks" (references = @wood.mtlx@</MaterialX>) { }\n'
    text += MESH % ("/looks/Materials/Wood", SQUARE)
    with pytest.raises(alight.SceneError, match=r"wood\.mtlx"):
        bsdf_of(folder, text)
    (folder / "wood.mtlx").write_text("<scene/>")
    with pytest.raises(alight.SceneError, match="must be a <materialx>"):
        bsdf_of(folder, text)
    (folder / "wood.mtlx").write_text(DOCUMENT % "lost.png")
    with pytest.raises(alight.SceneError, match=r"no such file: .*lost\.png"):
        bsdf_of(folder, text)


def test_coordinates_that_come_from_themselves(folder):
    nodes = """
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/p.outputs:rgb>
        token outputs:surface
    }
    def Shader "p" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @a.png@
        float2 inputs:st.connect = </m/t.outputs:result>
        float3 outputs:rgb
    }
    def Shader "t" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:scale = (2, 2)
        float2 inputs:in.connect = </m/t.outputs:result>
        float2 outputs:result
    }
    """
    found, said, _ = bsdf_of(folder, f'def Material "m" {{{nodes}}}' + MESH % ("/m", SQUARE))
    assert found.base_color.file == "a.png"
    assert any("come from itself" in line for line in said)


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("color3f primvars:tone = (0.1, 0.2, 0.3)", (0.1, 0.2, 0.3)),
        ("color3f[] primvars:tone = [(0.1, 0.2, 0.3)]", (0.1, 0.2, 0.3)),
        ("float primvars:tone = 0.25", (0.25, 0.25, 0.25)),
        ("float[] primvars:tone = [0.25]", (0.25, 0.25, 0.25)),
    ],
)
def test_constant_primvars_are_lists_of_one_or_single_values(given, meant, folder):
    reader = """
        def Shader "p" {
            uniform token info:id = "ND_geompropvalue_color3"
            string inputs:geomprop = "tone"
            color3f outputs:out
        }
    """
    first, last = NETWORK.index('        def Shader "p"'), NETWORK.index('        def Shader "t"')
    network = NETWORK[:first] + reader + NETWORK[last:]
    network = network.replace("(0.5, 0.25, 0.125)", "(1, 1, 1)") % ""
    mesh = MESH % ("/m", SQUARE + f'{given} (interpolation = "constant")')
    found, _, _ = bsdf_of(folder, network + mesh)
    assert found.base_color == pytest.approx(meant)


BODY = """
def Material "m" {
    token outputs:mtlx:surface.connect = </m/s.outputs:out>
    def Shader "s" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        float inputs:subsurface = 1
        color3f inputs:subsurface_radius = (1, 0.5, 0.25)
        token outputs:out
    }
}
def Sphere "ball" (prepend apiSchemas = ["MaterialBindingAPI"]) { rel material:binding = </m> }
"""


def test_light_is_scattered_inside_of_closed_shapes_only(tmp_path):
    """The radius is in the unit of the stage."""
    text = BODY + MESH % ("/m", SQUARE)
    (tmp_path / "a.usda").write_text(stage_text(text, unit=0.01))
    scene = load(tmp_path / "a.usda")
    looks = {path: scene.bsdfs[node.bsdf] for path, _, node in scene.walk() if node.shape}
    assert looks["world/ball"].radius == pytest.approx((0.01, 0.005, 0.0025))
    assert looks["world/wall"].type_name() == "two_sided"
    assert any("/wall: open or inside out" in text for text in scene.source.remarks.warnings)


OCTAHEDRON = """
    int[] faceVertexCounts = [3, 3, 3, 3, 3, 3, 3, 3]
    int[] faceVertexIndices = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
        2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]
    point3f[] points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    uniform token subdivisionScheme = "none"
"""
TOP = """
    def GeomSubset "top" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0, 1, 2, 3]
        rel material:binding = %s
    }
"""


def looks_of(folder, mesh, top):
    other = BODY.partition("def Sphere")[0].replace('"m"', '"n"').replace("/m/", "/n/")
    other = other.replace("(1, 0.5, 0.25)", "(2, 2, 2)")
    plain = MATERIAL_OF_PRIM
    text = BODY.partition("def Sphere")[0] + other + plain + MESH % ("/m", mesh + TOP % top)
    (folder / "a.usda").write_text(stage_text(text))
    scene = load(folder / "a.usda")
    shown = {path: scene.bsdfs[node.bsdf] for path, _, node in scene.walk() if node.shape}
    return {path.rpartition("/")[2]: bsdf for path, bsdf in shown.items()}, scene.warnings


MATERIAL_OF_PRIM = """
def Material "plain" {
    token outputs:surface.connect = </plain/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        token outputs:surface
    }
}
"""


def test_parts_of_a_mesh_may_close_a_body_together(tmp_path):
    """Each has its own; an open mesh, or one with a part that is no body, has none."""
    looks, said = looks_of(tmp_path, OCTAHEDRON, "</n>")
    assert {bsdf.type_name() for bsdf in looks.values()} == {"subsurface"}
    assert looks["top"].radius == (2.0, 2.0, 2.0)
    assert looks["rest"].radius == (1.0, 0.5, 0.25)
    assert not any("inside out" in text for text in said)
    opened = OCTAHEDRON.replace("3, 3]", "3]", 1).replace(", 0, 3, 5]", "]")
    for mesh, top in ((opened, "</n>"), (OCTAHEDRON, "</plain>")):
        looks, said = looks_of(tmp_path, mesh, top)
        assert looks["rest"].type_name() == "two_sided"
        assert any("inside out" in text for text in said)
