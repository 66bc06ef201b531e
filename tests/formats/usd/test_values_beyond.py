"""OpenUSD: values beyond what a material may have are the nearest that it may, and never silent."""

import pytest

from tests.formats.usd.stage import MATERIAL, SQUARE, shapes, usd_loader

pytest.importorskip("pxr")


@pytest.fixture
def load(tmp_path):
    """Load a stage given as text."""
    return usd_loader(tmp_path)


@pytest.mark.parametrize(("name", "found"), [("emissive", (5, 0.3, 1)), ("diffuse", (1, 0.3, 1))])
def test_light_of_a_primvar_is_as_bright_as_it_says(load, name, found):
    more = 'color3f[] primvars:glow = [(5, 0.3, 1)] (interpolation = "constant")'
    connected = f"color3f inputs:{name}Color.connect = </m/reader.outputs:result>"
    text = MATERIAL % (connected, SQUARE + more)
    scene = load(text.replace('varname = "uv2"', 'varname = "glow"'))
    (node,) = shapes(scene).values()
    is_light = name == "emissive"
    color = node.light.radiance if is_light else scene.bsdfs["m"].bsdf.base_color
    assert color == pytest.approx(found)


@pytest.mark.parametrize(("name", "found"), [("emissive", (7, 0.2, 1)), ("diffuse", (1, 0.2, 1))])
def test_the_fallback_of_a_picture_that_is_not_named_has_the_same_bounds(load, name, found):
    connected = f"color3f inputs:{name}Color.connect = </m/picture.outputs:rgb>"
    text = MATERIAL % (connected, SQUARE)
    instead = "float4 inputs:fallback = (7, 0.2, 1, 1)"
    scene = load(text.replace("asset inputs:file = @p.png@", instead))
    (node,) = shapes(scene).values()
    is_light = name == "emissive"
    color = node.light.radiance if is_light else scene.bsdfs["m"].bsdf.base_color
    assert color == pytest.approx(found)


@pytest.mark.parametrize(
    ("given", "found"), [(7.0, 5.0), (0.5, 2.0), (0.1, 5.0), (1.2, 1.2), (0.0, 1.5), (-2.0, 1.5)]
)
def test_an_index_becomes_the_nearest_that_there_is(load, given, found):
    scene = load(MATERIAL % (f"float inputs:ior = {given}", SQUARE))
    assert scene.bsdfs["m"].bsdf.ior == pytest.approx(found)
    assert any("became" in text for text in scene.warnings) == (given != found)


def test_normals_that_do_not_fit_are_said(load):
    mesh = f'def Mesh "mesh" {{{SQUARE}normal3f[] normals = [(0, 0, 1), (0, 1, 0)]}}'
    assert "/mesh: normals has 2 values, which do not fit: left out" in load(mesh).warnings
