"""OpenUSD: meshes that are lights, and what lights are told that none in nature does."""

import pytest

from tests.formats.usd.stage import SQUARE, shapes, usd_loader

pytest.importorskip("pxr")

MESH_LIGHT = f"""def Mesh "m" (prepend apiSchemas = ["MeshLightAPI", "MaterialBindingAPI"])
{{
    {SQUARE}
    float inputs:intensity = 5
    color3f inputs:color = (1, 0.5, 0)
    %s
}}
"""


@pytest.fixture
def load(tmp_path):
    return usd_loader(tmp_path)


def radiance_of(scene):
    (node,) = shapes(scene).values()
    return tuple(node.light.radiance)


def test_a_mesh_may_be_a_light(load):
    scene = load(MESH_LIGHT % "")
    assert radiance_of(scene) == (5.0, 2.5, 0.0)
    assert not any("studio" in text for text in scene.warnings)


def test_the_light_of_a_normalised_mesh_is_divided_by_its_area(load):
    scaled = "bool inputs:normalize = 1\n float3 xformOp:scale = (3, 0.5, 1)\n"
    scaled += ' uniform token[] xformOpOrder = ["xformOp:scale"]'
    # The square is 2 m by 1 m.
    assert radiance_of(load(MESH_LIGHT % scaled)) == pytest.approx((5 / 3, 2.5 / 3, 0.0))


GLOWING = """def Material "look"
{
    token outputs:surface.connect = </look/s.outputs:surface>
    def Shader "s"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:emissiveColor = (0.5, 1, 1)
        token outputs:surface
    }
}
"""


@pytest.mark.parametrize(
    ("mode", "radiance", "word"),
    [
        (None, (2.5, 2.5, 0.0), "multiplied by the glow"),
        ("materialGlowTintsLight", (2.5, 2.5, 0.0), "multiplied by the glow"),
        ("independent", (5.5, 3.5, 1.0), None),
        ("noMaterialResponse", (5.0, 2.5, 0.0), "asks for no response"),
    ],
)
def test_the_glow_of_a_material_and_the_light_of_a_mesh(load, mode, radiance, word):
    more = f'uniform token light:materialSyncMode = "{mode}"\n' if mode else ""
    scene = load(GLOWING + MESH_LIGHT % (more + "rel material:binding = </look>"))
    assert radiance_of(scene) == radiance
    found = [warning for warning in scene.warnings if "glow" in warning or "response" in warning]
    assert [word in text for text in found] == [True] * (word is not None)


def said(load, attributes, kind="SphereLight", more=""):
    text = f'def {kind} "l" {{\n{attributes}\n}}\n{more}'
    return [w for w in load(f'def Mesh "m" {{{SQUARE}}}\n{text}').warnings if w.startswith("/l:")]


@pytest.mark.parametrize(
    ("attribute", "word"),
    [
        ("float inputs:diffuse = 0", "(diffuse)"),
        ("float inputs:specular = 0.5", "(specular)"),
        ("bool inputs:shadow:enable = 0", "(shadow:enable)"),
        ("color3f inputs:shadow:color = (1, 0, 0)", "(shadow:color)"),
        ("float inputs:shadow:distance = 3", "(shadow:distance)"),
        ("bool collection:lightLink:includeRoot = 0", "(lightLink)"),
        ("rel collection:shadowLink:excludes = [</m>]", "(shadowLink)"),
        ("rel light:filters = [</f>]", "filters"),
    ],
)
def test_what_no_light_does_is_told(load, attribute, word):
    found = said(load, attribute)
    assert len(found) == 1
    assert word in found[0]


def test_a_plain_light_has_nothing_to_tell(load):
    plain = "float inputs:diffuse = 1\n bool inputs:shadow:enable = 1"
    assert not said(load, plain + "\n bool collection:lightLink:includeRoot = 1")


def test_other_layouts_of_skies_are_told(load, tmp_path):
    from PIL import Image

    Image.new("RGB", (4, 2)).save(tmp_path / "p.png")
    picture = "asset inputs:texture:file = @p.png@\n token inputs:texture:format = "
    assert "mirroredBall" in said(load, picture + '"mirroredBall"', "DomeLight")[0]
    assert not said(load, picture + '"latlong"', "DomeLight")


@pytest.mark.parametrize(
    ("opacity", "interpolation", "wanted"),
    [("0.25", "constant", 0.25), ("0, 0.5, 1, 0.5", "vertex", 0.5), ("7", "constant", 1.0)],
)
def test_prims_without_a_material_show_their_display_opacity(load, opacity, interpolation, wanted):
    primvar = f"float[] primvars:displayOpacity = [{opacity}]"
    text = f'{SQUARE}\n{primvar} ( interpolation = "{interpolation}" )'
    scene = load(f'def Mesh "m" {{{text}}}\n')
    (bsdf,) = scene.bsdfs.values()
    assert getattr(bsdf, "opacity", 1.0) == pytest.approx(wanted)
    varies = any("displayOpacity varies" in warning for warning in scene.warnings)
    assert varies == (interpolation == "vertex")
