"""OpenUSD: what scale and bias make of texels, within what a surface may have of each."""

import numpy as np
import pytest
from PIL import Image

from alight.bsdfs.matte.diffuse import Diffuse
from alight.laws.materials import Material, direction
from alight.scene.flatten import flatten
from tests.formats.usd.stage import MATERIAL, SQUARE, usd_loader

pytest.importorskip("pxr")
TEXEL = np.array([51, 102, 204])


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Load a stage given as text, in whose folder tests then are."""
    monkeypatch.chdir(tmp_path)
    Image.new("RGB", (1, 1), tuple(TEXEL.tolist())).save(tmp_path / "p.png")
    return usd_loader(tmp_path)


def principled(load, inputs, scale, bias):
    given = f"float4 inputs:scale = {scale}\n        float4 inputs:bias = {bias}"
    given += '\n        token inputs:sourceColorSpace = "raw"'
    text = MATERIAL % (inputs, SQUARE)
    scene = load(text.replace("float4 inputs:scale = (0.5, 0.5, 0.5, 1)", given))
    (bsdf,) = flatten(scene).bsdfs
    return bsdf.bsdf, scene.warnings


def shown(texture):
    """What a texture is: the albedo of matte stuff that it colours."""
    up = direction(1.0)
    return np.pi * Material(Diffuse(reflectance=texture)).evaluate(up, up)[0][:, 0]


COLOR = "color3f inputs:diffuseColor.connect = </m/picture.outputs:rgb>"
NUMBER = "float inputs:roughness.connect = </m/picture.outputs:g>"


@pytest.mark.parametrize(
    ("scale", "bias", "said"),
    [
        ((0.5, 1.0, 0.25), (0.25, 0.0, 0.5), ""),
        ((1.2, 1.2, 1.2), (0.0, 0.0, 0.0), "may reach 1.2: they are cut at 1"),
        ((3.0, 3.0, 3.0), (0.0, 0.0, 0.0), "may reach 3: they are cut at 1"),
        ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), ""),
        ((1.0, -0.5, 1.0), (0.0, 0.75, 0.0), ""),
    ],
)
def test_colors_are_scale_times_texel_plus_bias_up_to_1(load, scale, bias, said):
    found, warnings = principled(load, COLOR, (*scale, 1), (*bias, 0))
    expected = np.minimum(TEXEL / 255 * scale + bias, 1.0)
    np.testing.assert_allclose(shown(found.base_color), expected, atol=1e-6)
    assert any("they are" in line for line in warnings) == bool(said)
    assert any(said in line for line in warnings)


@pytest.mark.parametrize(("scale", "bias"), [(0.5, 0.25), (1.2, 0.0), (-1.0, 1.0), (-0.5, 0.5)])
def test_numbers_are_scale_times_texel_plus_bias(load, scale, bias):
    found, _ = principled(load, NUMBER, (1, scale, 1, 1), (0, bias, 0, 0))
    expected = min(TEXEL[1] / 255 * scale + bias, 1.0)
    np.testing.assert_allclose(shown(found.roughness), [expected] * 3, atol=1e-6)


def test_what_would_be_below_0_is_said(load):
    _, warnings = principled(load, NUMBER, (1, 1, 1, 1), (0, -0.25, 0, 0))
    assert any("begin at -0.25: they are moved up to 0" in line for line in warnings)


def test_what_shines_may_be_brighter_than_1(load):
    emission = "color3f inputs:emissiveColor.connect = </m/picture.outputs:rgb>"
    _, warnings = principled(load, emission, (5, 5, 5, 1), (0, 0, 0, 0))
    assert not any("they are cut" in line for line in warnings)


@pytest.mark.parametrize(("output", "value"), [("r", 0.1), ("g", 0.2), ("b", 0.3), ("a", 0.4)])
def test_without_a_picture_the_output_of_the_fallback_is_taken(load, output, value):
    """Each of its channels by itself, as number and as colour."""
    inputs = f"{COLOR.replace('rgb', output)}\n        {NUMBER.replace('g>', f'{output}>')}"
    text = MATERIAL % (inputs, SQUARE)
    fallback = "float4 inputs:fallback = (0.1, 0.2, 0.3, 0.4)"
    text = text.replace("asset inputs:file = @p.png@", fallback)
    for name in "rba":
        text = text.replace("float outputs:g", f"float outputs:{name}\n        float outputs:g", 1)
    assert fallback in text
    (bsdf,) = flatten(load(text)).bsdfs
    assert bsdf.bsdf.roughness == pytest.approx(value)
    assert bsdf.bsdf.base_color == pytest.approx((value,) * 3)
