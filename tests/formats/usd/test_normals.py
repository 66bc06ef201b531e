"""OpenUSD: a normal is scale times a texel plus bias, in the frame of the coordinates."""

import numpy as np
import pytest
from PIL import Image

from tests.formats.leaning import normals_of
from tests.formats.usd.stage import MATERIAL, SQUARE, shapes, usd_loader

pytest.importorskip("pxr")
TEXEL = (179, 166, 230)


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Load a stage given as text, in whose folder tests then are."""
    monkeypatch.chdir(tmp_path)
    return usd_loader(tmp_path)


def with_normals(load, tmp_path, scale, bias, change="float2 inputs:scale = (1, 1)"):
    """The scene of a square in the plane z = 0 with a picture of one normal."""
    Image.new("RGB", (1, 1), TEXEL).save(tmp_path / "p.png")
    text = MATERIAL % ("normal3f inputs:normal.connect = </m/picture.outputs:rgb>", SQUARE)
    text = text.replace("float4 inputs:scale = (0.5, 0.5, 0.5, 1)", f"{scale}\n        {bias}")
    return load(text.replace("float2 inputs:scale = (2, 3)", change))


def measured(scene):
    (node,) = shapes(scene).values()
    return normals_of(node.shape, scene.bsdfs["m"].bsdf.texture)


def agree(found, expected):
    expected = np.asarray(expected) / np.linalg.norm(expected)
    np.testing.assert_allclose(found, np.tile(expected, (len(found), 1)), atol=2e-4)


@pytest.mark.parametrize(
    ("scale", "bias"),
    [
        ((2, 2, 2), (-1, -1, -1)),
        ((2, -2, 2), (-1, 1, -1)),
        ((-2, 2, 2), (1, -1, -1)),
        ((1, 1, 2), (-0.5, -0.5, -1)),
        ((4, 4, 2), (-2, -2, -1)),
        ((0.25, 0.5, 1), (0, 0, 0)),
    ],
)
def test_normals_are_scaled_and_shifted_texels(load, tmp_path, scale, bias):
    given = (
        f"float4 inputs:scale = ({', '.join(map(str, scale))}, 1)",
        f"float4 inputs:bias = ({', '.join(map(str, bias))}, 0)",
    )
    scene = with_normals(load, tmp_path, *given)
    agree(measured(scene), np.array(scale) * np.array(TEXEL) / 255.0 + bias)
    assert any("lean to +x and +y" in line for line in scene.warnings) == (bias == (0, 0, 0))


def test_normals_without_scale_and_bias_are_read_as_they_are_and_said(load, tmp_path):
    scene = with_normals(load, tmp_path, "", "")
    # A normal of three parts above 0 leans to the upper right.
    agree(measured(scene), TEXEL)
    assert any("without a bias of -1 its normals lean" in line for line in scene.warnings)


@pytest.mark.parametrize(
    ("change", "right", "above"),
    [
        ("float inputs:rotation = 90", (0, -1), (1, 0)),
        ("float2 inputs:scale = (-1, 1)", (-1, 0), (0, 1)),
    ],
)
def test_normals_turn_with_their_picture(load, tmp_path, change, right, above):
    """UsdTransform2d turns coordinates counter-clockwise, so that the picture turns clockwise."""
    twice = "float4 inputs:scale = (2, 2, 2, 1)", "float4 inputs:bias = (-1, -1, -1, 0)"
    scene = with_normals(load, tmp_path, *twice, change)
    lean, rise, height = 2.0 * np.array(TEXEL) / 255.0 - 1.0
    agree(measured(scene), [*(lean * np.array(right) + rise * np.array(above)), height])


def test_a_plain_normal_is_bent_to(load):
    st = """
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")"""
    scene = load(MATERIAL % ("normal3f inputs:normal = (0.4, 0.3, 0.9)", SQUARE + st))
    agree(measured(scene), (0.4, 0.3, 0.9))
