"""Channels of nodes: the fourth one of pictures, those that are not given, those put in order."""

import numpy as np
import pytest
from PIL import Image

from alight.core.srgb import decode_srgb
from tests.formats.materialx.reading import (
    TEXELS,
    core,
    link,
    material,
    node,
    picture,
    texels,
    value,
)

LINEAR = decode_srgb(TEXELS / 255.0)
ALPHA = np.array([[0, 51], [102, 255]], np.uint8)


def base(folder, *nodes, of="x", kind="color3"):
    """The colour that a standard surface gets from a node, and what was said."""
    bsdf, said = material(link("base_color", kind, of), folder, *nodes)
    return core(bsdf)["base_color"], said


def fourth(folder, *nodes, of="x"):
    """The fourth channel of a node, at each texel of a picture with opacity."""
    Image.fromarray(np.dstack([TEXELS, ALPHA])).save(folder / "b.png")
    taken = node("extract", "last", "float", link("in", "color4", of), value("index", "integer", 3))
    found, _ = base(folder, *nodes, taken, of="last", kind="float")
    if isinstance(found, float | list):
        return np.full((2, 2), np.array(found).flat[0])
    return texels(found, folder)[..., 0]


@pytest.mark.parametrize(
    ("category", "inputs", "function"),
    [
        ("multiply", value("in2", "color4", "1, 1, 1, 0.5"), lambda a: a * 0.5),
        ("multiply", value("in2", "float", "0.5"), lambda a: a * 0.5),
        ("power", value("in2", "float", 2), lambda a: a * a),
        ("invert", "", lambda a: 1.0 - a),
        ("contrast", value("amount", "float", 0.5), lambda a: 0.5 * a + 0.25),
        ("saturate", value("amount", "float", 0.5), lambda a: a),
    ],
)
def test_the_opacity_of_a_picture_goes_through_nodes(category, inputs, function, tmp_path):
    name = "in1" if category in ("multiply", "power") else "in"
    two = picture("p", "color4", file="b.png"), node(category, "x", "color4",
                                                     link(name, "color4", "p"), inputs)  # fmt: skip
    meant = function(ALPHA / 255.0)
    np.testing.assert_allclose(fourth(tmp_path, *two), meant, atol=1e-5)


@pytest.mark.parametrize("space", ["srgb_texture", "g22_rec709", "acescg"])
def test_the_opacity_of_a_picture_has_no_colour_space(space, tmp_path):
    shown = picture("x", "color4", file="b.png", space=f' colorspace="{space}"')
    np.testing.assert_allclose(fourth(tmp_path, shown), ALPHA / 255.0, atol=1e-5)


def test_channels_that_are_not_given_are_0(tmp_path):
    apart = node("separate3", "s", "multioutput", link("in", "color3", "p"))
    two = node("combine3", "x", "color3", *(
        link(f"in{i}", "float", "s", f' output="out{c}"') for i, c in ((2, "r"), (3, "g"))
    ))  # fmt: skip
    found, _ = base(tmp_path, picture(), apart, two)
    meant = np.dstack([np.zeros((2, 2)), LINEAR[..., 0], LINEAR[..., 1]])
    np.testing.assert_allclose(texels(found, tmp_path), meant, atol=1e-6)
    found, _ = base(tmp_path, node("combine3", "x", "color3", value("in2", "float", 0.5)))
    assert found == [0.0, 0.5, 0.0]
    only = node("combine2", "x", "color4", value("in2", "float", 0.25))
    np.testing.assert_allclose(fourth(tmp_path, only), 0.25)
    pairs = node("combine2", "v", "vector4", value("in1", "vector2", "0.1, 0.2"),
                 value("in2", "vector2", "0.3, 0.4"))  # fmt: skip
    third = node("extract", "x", "float", link("in", "vector4", "v"), value("index", "integer", 2))
    found, _ = base(tmp_path, pairs, third, kind="float")
    assert found == pytest.approx([0.3] * 3)


@pytest.mark.parametrize("given", ["", "scale", "bias"])
def test_ranges_of_usd_pictures_that_vary_are_told(given, tmp_path):
    more = link(given, "vector4", "p") if given else ""
    file = value("file", "filename", "a.png") + more
    shown = f'<UsdUVTexture name="u" type="multioutput">{file}</UsdUVTexture>'
    kept = node("dot", "x", "color3", link("in", "color3", "u", ' output="rgb"'))
    found, said = base(tmp_path, picture("p", "vector4"), shown, kept)
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR, atol=1e-6)
    assert any(f"its {given} varies" in line for line in said) == bool(given)


@pytest.mark.parametrize("category", ["image", "tiledimage", "UsdUVTexture"])
def test_pictures_without_a_name_show_what_stands_for_them(category, tmp_path):
    key = "fallback" if category == "UsdUVTexture" else "default"
    kind = "vector4" if category == "UsdUVTexture" else "color3"
    inputs = (
        value("file", "filename", ""),
        value(key, kind, "0.1, 0.2, 0.3" + (", 1" if kind == "vector4" else "")),
    )
    found, _ = base(tmp_path, node(category, "x", kind, *inputs))
    assert found == pytest.approx([0.1, 0.2, 0.3])


def test_checkers_have_eight_squares_unless_said(tmp_path):
    found, _ = base(tmp_path, node("checkerboard", "x", "color3"))
    assert "[8.0, 0.0, 0.0]" in str(found)
    given = value("uvtiling", "vector2", "3, 3")
    found, _ = base(tmp_path, node("checkerboard", "x", "color3", given))
    assert "[3.0, 0.0, 0.0]" in str(found)


@pytest.mark.parametrize(("letters", "order"), [("bgr", [2, 1, 0]), ("rgb", [0, 1, 2])])
def test_inputs_of_1_38_take_channels_in_any_order(letters, order, tmp_path):
    shader = link("base_color", "color3", "p", f' channels="{letters}"')
    bsdf, _ = material(shader, tmp_path, picture())
    found = texels(core(bsdf)["base_color"], tmp_path)
    np.testing.assert_allclose(found, LINEAR[..., order], atol=1e-6)
    one = node("dot", "x", "float", link("in", "float", "p", f' channels="{letters[0]}"'))
    found, _ = base(tmp_path, picture(), one, kind="float")
    np.testing.assert_allclose(texels(found, tmp_path), LINEAR[..., order[:1]].repeat(3, 2))
