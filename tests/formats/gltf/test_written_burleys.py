"""Burley's materials written to glTF: the same parameters where both models have them."""

import math

import pytest

from tests.formats.gltf.written import GREY, again

RIM = "burley: what is reflected on top is taken from what is below, rims are darker"


def test_colour_metal_roughness_and_index_stay(tmp_path):
    number = {"type": "channel", "texture": GREY, "channel": "r"}
    bsdf = {"type": "burley", "base_color": GREY | {"color_space": "srgb"}, "metallic": number,
            "roughness": 0.3, "ior": 1.4}  # fmt: skip
    found, _, lost = again(bsdf, tmp_path)
    assert lost == [RIM]
    assert found.ior == 1.4
    assert found.roughness.mean()[1] == pytest.approx(0.3)
    assert found.metallic.channel == "b"
    assert (found.base_color.pixels.texels[..., 0] == [[64, 128], [192, 255]]).all()


def test_glass_has_the_root_of_the_colour_and_sheets_are_thin(tmp_path):
    glass = {"type": "burley", "base_color": [0.25, 0.5, 1.0], "spec_trans": 1.0}
    found, _, lost = again(glass, tmp_path)
    assert lost == [RIM]
    assert found.base_color == pytest.approx([0.5, math.sqrt(0.5), 1.0])
    assert (found.transmission, found.thin) == (1.0, False)
    found, _, lost = again(glass | {"type": "burley_thin", "through": 0.5}, tmp_path)
    assert found.thin
    assert "burley_thin: its through" in lost
    found, _, lost = again(glass | {"spec_trans": 0.5}, tmp_path)
    assert found.base_color == pytest.approx([0.25, 0.5, 1.0])
    assert "burley: its glass takes the whole colour at each side, not the root" in lost


def test_stretched_facets_keep_both_roughnesses(tmp_path):
    bsdf = {"type": "burley", "roughness": 0.5, "anisotropic": 0.8}
    found, _, _ = again(bsdf, tmp_path)
    alpha, aspect = found.roughness**2, math.sqrt(1.0 - 0.9 * 0.8)
    assert alpha == pytest.approx(0.25 * aspect)
    assert alpha + (1.0 - alpha) * found.anisotropy**2 == pytest.approx(0.25 / aspect)


def test_coat_and_sheen_have_their_strength(tmp_path):
    bsdf = {"type": "burley", "base_color": [0.2, 0.4, 0.1], "clearcoat": 0.8, "flatness": 0.5,
            "clearcoat_gloss": 0.25, "sheen": 0.6, "sheen_tint": 0.5, "spec_tint": 0.5}  # fmt: skip
    found, _, lost = again(bsdf, tmp_path)
    assert found.clearcoat == pytest.approx(0.2)
    assert found.clearcoat_roughness**2 == pytest.approx(0.07525)
    assert found.sheen_color == pytest.approx([0.45, 0.6, 0.375])
    for name in ("spec_tint", "flatness"):
        assert f"burley: its {name}" in lost
