"""OpenUSD: materials, their textures and the coordinates that those are looked up by."""

import numpy as np
import pytest
from PIL import Image

from tests.formats.usd.stage import MATERIAL, SQUARE, shapes, usd_loader

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


def bsdf_of(load, tmp_path, inputs):
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "p.png")
    scene = load(MATERIAL % (inputs, SQUARE))
    bsdf = scene.bsdfs["m"]
    return scene, bsdf


def test_a_preview_surface_becomes_principled(load, tmp_path):
    scene, bsdf = bsdf_of(
        load,
        tmp_path,
        """
        color3f inputs:diffuseColor = (0.1, 0.2, 0.3)
        float inputs:metallic = 0.25
        float inputs:roughness = 0.75
        float inputs:ior = 1.4
        float inputs:clearcoat = 0.5
        color3f inputs:emissiveColor = (0, 2, 0)
    """,
    )
    inner = bsdf.bsdf
    assert inner.base_color == pytest.approx((0.1, 0.2, 0.3))
    assert (inner.metallic, inner.roughness) == (0.25, 0.75)
    assert inner.ior == pytest.approx(1.4)
    assert (inner.clearcoat, inner.clearcoat_roughness) == (0.5, pytest.approx(0.01))
    (node,) = shapes(scene).values()
    assert node.light.radiance == (0.0, 2.0, 0.0)
    assert not any("no light" in line for line in scene.warnings)


def test_textures_are_wired_with_scale_and_place(load, tmp_path):
    scene, bsdf = bsdf_of(
        load,
        tmp_path,
        """
        color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>
        float inputs:roughness.connect = </m/picture.outputs:g>
    """,
    )
    color, roughness = bsdf.bsdf.base_color, bsdf.bsdf.roughness
    assert color.a == (0.5, 0.5, 0.5)
    assert (color.b.file, color.b.wrap, color.b.wrap_v) == ("p.png", "mirror", "repeat")
    assert color.b.to_uv.matrix.tolist() == [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]
    assert color.b.color_space == "auto"
    assert (roughness.b.channel, roughness.b.texture.color_space) == ("g", "linear")
    (node,) = shapes(scene).values()
    assert node.shape.uvs is not None


def test_opacity_is_a_chance_and_a_threshold_a_cut(load, tmp_path):
    _, bsdf = bsdf_of(load, tmp_path, "float inputs:opacity = 0.5")
    assert (bsdf.type, bsdf.opacity) == ("mask", 0.5)
    _, bsdf = bsdf_of(
        load, tmp_path, "float inputs:opacity = 0.5; float inputs:opacityThreshold = 0.6"
    )
    assert bsdf.opacity == 0.0


def test_the_specular_workflow_keeps_the_reflectance_at_normal_incidence(load, tmp_path):
    _, bsdf = bsdf_of(
        load,
        tmp_path,
        """
        int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = (0.08, 0.04, 0)
    """,
    )
    inner = bsdf.bsdf
    f0 = ((inner.ior - 1.0) / (inner.ior + 1.0)) ** 2
    np.testing.assert_allclose(f0 * np.array(inner.specular_color), [0.08, 0.04, 0.0], atol=1e-7)


def test_a_specular_color_brighter_than_any_glass_is_the_brightest_one(load, tmp_path):
    scene, bsdf = bsdf_of(
        load,
        tmp_path,
        """
        int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = (0.9, 0.6, 0.2)
    """,
    )
    inner = bsdf.bsdf
    assert inner.ior == pytest.approx(5.0)
    np.testing.assert_allclose(inner.specular_color, [1.0, 1.0, 0.45])
    assert any("at most 0.444 is reflected" in text for text in scene.warnings)


def test_without_a_material_the_display_color_is_shown(load):
    color = "color3f[] primvars:displayColor = [(0.1, 0.5, 0.9)]"
    scene = load(f'def Mesh "m" {{{SQUARE}{color}}}')
    (bsdf,) = scene.bsdfs.values()
    assert bsdf.bsdf.reflectance == pytest.approx((0.1, 0.5, 0.9))


def test_colors_of_vertices_that_are_not_there_are_the_usual_grey(load):
    # A sphere has no vertices to carry them.
    colors = '[(1, 0, 0), (0, 1, 0)] (interpolation = "vertex")'
    scene = load(f'def Sphere "s" {{ color3f[] primvars:displayColor = {colors} }}')
    (bsdf,) = scene.bsdfs.values()
    shown = bsdf.bsdf.reflectance if hasattr(bsdf, "bsdf") else bsdf.reflectance
    assert (shown.type_name(), shown.fallback) == ("vertex_color", pytest.approx((0.18,) * 3))


def test_subsets_have_materials_of_their_own(load):
    scene = load("""
def Material "red" { token outputs:surface.connect = </red/s.outputs:surface>
    def Shader "s" { uniform token info:id = "UsdPreviewSurface"; token outputs:surface
        color3f inputs:diffuseColor = (1, 0, 0) } }
def Mesh "m" {
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
    def GeomSubset "half" (prepend apiSchemas = ["MaterialBindingAPI"]) {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [1]
        rel material:binding = </red>
    }
}""")
    found = {path: node.bsdf for path, node in shapes(scene).items()}
    assert found == {"m/half": "red", "m/rest": "plain"}


PRIMVARS = """
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
    texCoord2f[] primvars:uv2 = [(0, 0), (0, 1), (1, 1), (1, 0)] (interpolation = "faceVarying")
"""


def picture_of(primvar, name):
    """A picture that is looked up in the coordinates of a name."""
    return f"""
    def Shader "{name}" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @p.png@
        float2 inputs:st.connect = </m/{name}Place.outputs:result>
        float3 outputs:rgb
        float outputs:g
    }}
    def Shader "{name}Place" {{
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "{primvar}"
        float2 outputs:result
    }}"""


def preview(name, pictures, inputs):
    return f"""
def Material "{name}" {{
    token outputs:surface.connect = </{name}/s.outputs:surface>
    def Shader "s" {{
        uniform token info:id = "UsdPreviewSurface"
        {inputs}
        token outputs:surface
    }}{pictures.replace("/m/", f"/{name}/")}
}}"""


def two_sets(load, tmp_path, inputs):
    """The mesh and the material of a stage with the pictures a (in st) and b (in uv2)."""
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "p.png")
    pictures = picture_of("st", "a") + picture_of("uv2", "b")
    mesh = f"""
def Mesh "mesh" (prepend apiSchemas = ["MaterialBindingAPI"]) {{{SQUARE}{PRIMVARS}
    rel material:binding = </m>
}}"""
    scene = load(preview("m", pictures, inputs) + mesh)
    (node,) = shapes(scene).values()
    return node.shape, scene.bsdfs["m"].bsdf, scene


def test_each_texture_reads_its_own_primvar(load, tmp_path):
    mesh, bsdf, scene = two_sets(load, tmp_path, """
        color3f inputs:diffuseColor.connect = </m/a.outputs:rgb>
        float inputs:roughness.connect = </m/b.outputs:g>
    """)  # fmt: skip
    own = mesh.vertices[:, :2] / [2, 1]
    np.testing.assert_allclose(mesh.uvs, own)
    np.testing.assert_allclose(mesh.more_uvs, [own[:, ::-1]])
    assert (bsdf.base_color.uv_set, bsdf.roughness.texture.uv_set) == (0, 1)
    assert not any("st" in line.split() for line in scene.warnings)


def test_the_primvar_of_the_normals_is_the_own_one(load, tmp_path):
    mesh, bsdf, _ = two_sets(load, tmp_path, """
        color3f inputs:diffuseColor.connect = </m/a.outputs:rgb>
        normal3f inputs:normal.connect = </m/b.outputs:rgb>
    """)  # fmt: skip
    np.testing.assert_allclose(mesh.uvs, mesh.vertices[:, 1::-1] / [1, 2])
    assert (bsdf.texture.set_of_coordinates(), bsdf.bsdf.base_color.uv_set) == (0, 1)


def test_parts_of_a_mesh_have_the_coordinates_of_their_own_materials(load, tmp_path):
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "p.png")
    color = "color3f inputs:diffuseColor.connect = </{}/a.outputs:rgb>"
    materials = [
        preview(name, picture_of(primvar, "a"), color.format(name))
        for name, primvar in (("one", "st"), ("two", "uv2"), ("three", "uv9"))
    ]
    subset = """
    def GeomSubset "{0}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [{1}]
        rel material:binding = </{0}>
    }}"""
    scene = load(f"""{"".join(materials)}
def Mesh "m" {{
    int[] faceVertexCounts = [3, 3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
    texCoord2f[] primvars:uv2 = [(0, 0), (0, 1), (1, 1), (1, 0)] (interpolation = "vertex")
    {subset.format("one", 0)}{subset.format("two", 1)}{subset.format("three", 2)}
}}""")
    one, two, three = (shapes(scene)[f"m/{name}"].shape for name in ("one", "two", "three"))
    np.testing.assert_allclose(one.uvs, one.vertices[:, :2] / [2, 1])
    np.testing.assert_allclose(two.uvs, two.vertices[:, 1::-1] / [1, 2])
    assert three.uvs is None
    assert one.more_uvs is None
    said = [line for line in scene.warnings if "coordinates" in line]
    asked = "it lacks the coordinates uv9, which its material asks for"
    assert said == [f"/m: {asked}; barycentric ones are taken"]
    # What they look up differs, what they do with it does not.
    assert list(scene.bsdfs) == ["one"]
