"""What the surface shaders of MaterialX become."""

import math

import numpy as np
import pytest

import alight
from alight.formats.materialx.nodes import category_of
from tests.formats.materialx.reading import (
    TEXELS,
    core,
    document,
    link,
    material,
    node,
    parsed,
    picture,
    texels,
    value,
)


def principled(shader, folder, *nodes, **more):
    bsdf, said = material(shader, folder, *nodes, **more)
    return core(bsdf), said


def test_defaults_are_those_of_the_library(tmp_path):
    found, said = principled("", tmp_path)
    assert found["base_color"] == [0.8] * 3
    assert (found["roughness"], found["ior"], found["metallic"]) == (0.2, 1.5, 0.0)
    assert not any("S:" in line for line in said)
    found, _ = principled("", tmp_path, category="gltf_pbr")
    assert (found["base_color"], found["metallic"], found["roughness"]) == ([1.0] * 3, 1.0, 1.0)
    found, _ = principled("", tmp_path, category="open_pbr_surface")
    assert (found["base_color"], found["roughness"]) == ([0.8] * 3, 0.3)
    found, _ = principled("", tmp_path, category="UsdPreviewSurface")
    assert found["base_color"] == [0.18] * 3


def test_standard_surface_of_the_oldest_version_has_other_defaults(tmp_path):
    text = document("").replace('type="surfaceshader">', 'type="surfaceshader" version="1.0.0">', 1)
    found = core(parsed(text, tmp_path).data["bsdfs"]["M"])
    assert found["base_color"] == pytest.approx([0.8] * 3)
    colored = document(value("base_color", "color3", "0.5, 0.5, 0.5"))
    colored = colored.replace('type="surfaceshader">', 'type="surfaceshader" version="1.0.0">', 1)
    assert core(parsed(colored, tmp_path).data["bsdfs"]["M"])["base_color"] == [0.4] * 3


def test_layers_of_standard_surface(tmp_path):
    shader = "".join([
        value("base", "float", "0.5"), value("base_color", "color3", "0.8, 0.4, 0.2"),
        value("coat", "float", "0.5"), value("coat_color", "color3", "0.5, 1, 1"),
        value("sheen", "float", "0.5"), value("sheen_color", "color3", "1, 0.5, 0"),
        value("thin_film_thickness", "float", "300"), value("emission", "float", "2"),
        value("emission_color", "color3", "1, 0.5, 0.25"),
        value("opacity", "color3", "0.5, 0.5, 0.5"),
    ])  # fmt: skip
    bsdf, _ = material(shader, tmp_path)
    found = core(bsdf)
    # Half a coat lets through 1 - 0.5 (1 - 0.5) of the red below it.
    assert found["base_color"] == pytest.approx([0.3, 0.2, 0.1])
    assert found["specular_color"] == pytest.approx([0.75, 1.0, 1.0])
    assert (found["clearcoat"], found["clearcoat_roughness"]) == (0.5, 0.1)
    assert found["sheen_color"] == pytest.approx([0.375, 0.25, 0.0])
    assert (found["iridescence"], found["iridescence_thickness"]) == (1.0, 300.0)
    assert bsdf["opacity"] == pytest.approx(0.5)
    light = parsed(document(shader), tmp_path).data["nodes"]["M"]["light"]
    assert light["radiance"] == [1.5, 1.0, 0.5]


@pytest.mark.parametrize("alpha", [0.04, 0.36])
def test_both_alphas_of_anisotropic_facets_are_those_of_the_library(alpha, tmp_path):
    root = math.sqrt(alpha)
    both = value("specular_roughness", "float", root)
    found, _ = principled(both + value("specular_anisotropy", "float", "0.75"), tmp_path)
    across = found["roughness"] ** 2
    along = across + (1.0 - across) * found["anisotropy"] ** 2
    # Aspect sqrt(1 - 0.75).
    assert (along, across) == (pytest.approx(2.0 * alpha), pytest.approx(0.5 * alpha))
    strength = value("specular_roughness_anisotropy", "float", "0.5")
    found, _ = principled(both + strength, tmp_path, category="open_pbr_surface")
    across = found["roughness"] ** 2
    along = across + (1.0 - across) * found["anisotropy"] ** 2
    assert across == pytest.approx(0.5 * along)
    assert along**2 + across**2 == pytest.approx(2.0 * alpha**2)


def test_glass_with_and_without_a_depth(tmp_path):
    shader = value("transmission", "float", "1") + value(
        "transmission_color", "color3", "1, 0.5, 1"
    )
    bsdf, _ = material(shader, tmp_path)
    assert bsdf["type"] == "principled"
    assert (bsdf["transmission"], bsdf["base_color"]) == (1.0, [1.0, 0.5, 1.0])
    bsdf, _ = material(shader + value("transmission_depth", "float", "0.1"), tmp_path)
    assert bsdf["base_color"] == [1.0] * 3
    assert (bsdf["attenuation_color"], bsdf["attenuation_distance"]) == ([1.0, 0.5, 1.0], 0.1)
    bsdf, _ = material(shader + value("thin_walled", "boolean", "true"), tmp_path)
    assert bsdf["thin"]


def test_what_is_left_out_is_told(tmp_path):
    shader = value("subsurface", "float", "1") + value("subsurface_color", "color3", "1, 0, 0")
    shader += (
        value("coat", "float", "0.5")
        + value("diffuse_roughness", "float", "0.5")
        + value("basecolor", "color3", "1, 0, 0")
    )
    found, said = principled(shader, tmp_path)
    assert found["base_color"] == [1.0, 0.0, 0.0]
    for words in ("subsurface", "diffuse_roughness is left out", 'did you mean "base_color"'):
        assert any(words in line for line in said), words


def test_what_is_all_below_the_surface_is_a_body(tmp_path):
    shader = "".join([
        value("subsurface", "float", "1"), value("subsurface_color", "color3", "0.9, 0.5, 0.2"),
        value("subsurface_radius", "color3", "1, 0.5, 0.25"),
        value("subsurface_scale", "float", "0.1"), value("specular_roughness", "float", "0.4"),
    ])  # fmt: skip
    found, said = material(shader, tmp_path)
    assert found == {
        "type": "subsurface", "color": [0.9, 0.5, 0.2], "radius": pytest.approx([0.1, 0.05, 0.025]),
        "ior": 1.5, "roughness": 0.4,
    }  # fmt: skip
    assert not any("subsurface" in line for line in said)
    shader = "".join([
        value("subsurface_weight", "float", "1"), value("specular_weight", "float", "0"),
        value("subsurface_radius", "float", "0.2"), value("subsurface_color", "color3", "1, 1, 1"),
    ])  # fmt: skip
    found, _ = material(shader, tmp_path, category="open_pbr_surface")
    assert found["radius"] == pytest.approx([0.2, 0.1, 0.05])
    assert (found["ior"], found["color"]) == (1.0, [1.0] * 3)


@pytest.mark.parametrize(
    "more",
    [
        value("subsurface", "float", "0.5"), value("metalness", "float", "0.1"),
        value("coat", "float", "1"), value("opacity", "color3", "0.5, 0.5, 0.5"),
        value("thin_walled", "boolean", "true"),
    ],
)  # fmt: skip
def test_what_is_more_than_a_body_is_diffuse(more, tmp_path):
    shader = "" if "subsurface" in more else value("subsurface", "float", "1")
    found, said = principled(shader + more, tmp_path)
    assert found["type"] == "principled"
    assert any("no light wanders below the surface" in line for line in said)


@pytest.mark.parametrize(
    ("category", "thickness", "weight"),
    [
        ("standard_surface", 400.0, None),
        ("open_pbr_surface", 0.4, "thin_film_weight"),
        ("gltf_pbr", 400.0, "iridescence"),
    ],
)
def test_films_have_the_unit_of_their_shader(category, thickness, weight, tmp_path):
    name = "iridescence_thickness" if category == "gltf_pbr" else "thin_film_thickness"
    shader = value(name, "float", thickness)
    shader += "" if weight is None else value(weight, "float", 1)
    found, _ = principled(shader, tmp_path, category=category)
    assert found["iridescence_thickness"] == pytest.approx(400.0)


def test_the_coat_of_open_pbr_is_as_strong_straight_on(tmp_path):
    shader = value("coat_weight", "float", "0.5")
    found, said = principled(shader, tmp_path, category="open_pbr_surface")
    strength = found["clearcoat"] * 0.04
    assert strength == pytest.approx(0.5 * (0.6 / 2.6) ** 2)
    assert any("as strong straight on" in line for line in said)


@pytest.mark.parametrize(
    ("mode", "opacity"),
    [(0, 1.0), (1, 0.0), (2, 0.25)],
)
def test_alpha_modes_of_gltf(mode, opacity, tmp_path):
    shader = value("alpha", "float", "0.25") + value("alpha_mode", "integer", mode)
    bsdf, _ = material(shader, tmp_path, category="gltf_pbr")
    assert (bsdf.get("opacity", 1.0) if bsdf["type"] == "mask" else 1.0) == opacity


def test_normal_maps_bend_and_flat_ones_do_not(tmp_path):
    image = node("image", "p", "vector3", value("file", "filename", "a.png"))
    bent = node("normalmap", "n", "vector3", link("in", "vector3", "p"), value("scale", "float", 2))
    bsdf, _ = material(link("normal", "vector3", "n"), tmp_path, image, bent)
    inner = bsdf["bsdf"]
    assert (inner["type"], inner["scale"], inner["texture"]["type"]) == (
        "normal_map",
        2.0,
        "bitmap",
    )
    assert inner["texture"]["color_space"] == "linear"
    flat = node("normalmap", "n", "vector3")
    bsdf, _ = material(link("normal", "vector3", "n"), tmp_path, flat)
    assert bsdf["bsdf"]["type"] == "principled"


def test_a_negative_scale_turns_the_slopes_round(tmp_path):
    image = node("image", "p", "vector3", value("file", "filename", "a.png"))
    bent = node(
        "normalmap", "n", "vector3", link("in", "vector3", "p"), value("scale", "float", -2)
    )
    bsdf, _ = material(link("normal", "vector3", "n"), tmp_path, image, bent)
    inner = bsdf["bsdf"]
    assert inner["scale"] == 2.0
    # 1 - t in red and green, t in blue.
    seen = texels(inner["texture"], tmp_path)
    plain = TEXELS / 255.0
    np.testing.assert_allclose(seen, np.abs([1.0, 1.0, 0.0] - plain), atol=1e-6)


def test_unknown_shaders_stop_or_are_squares_of_magenta(tmp_path):
    with pytest.raises(alight.SceneError, match='shader "disney_principled" is not covered'):
        material("", tmp_path, category="disney_principled")
    bsdf, said = material("", tmp_path, category="disney_principled", lenient=True)
    assert bsdf["bsdf"]["reflectance"]["type"] == "bitmap"
    assert any("magenta" in line for line in said)


def test_names_of_definitions():
    assert category_of("ND_multiply_color3FA") == ("multiply", "color3", "")
    assert category_of("ND_image_vector3")[:2] == ("image", "vector3")
    assert category_of("ND_mix_color3_color3")[:2] == ("mix", "color3")
    assert category_of("ND_convert_float_color3")[:2] == ("convert", "color3")
    assert category_of("ND_UsdUVTexture_23")[0] == "UsdUVTexture"
    assert category_of("ND_normalmap_float")[0] == "normalmap"
    assert category_of("ND_open_pbr_surface_surfaceshader")[0] == "open_pbr_surface"


@pytest.mark.parametrize(
    ("category", "prefix", "layer"),
    [("standard_surface", "coat", "sheen"), ("open_pbr_surface", "coat_weight", "fuzz_weight")],
)
def test_a_coat_tints_what_lies_below_it(category, prefix, layer, tmp_path):
    """Sheen lies below the coat of a standard surface, OpenPBR's fuzz above it."""
    strength = "emission" if category == "standard_surface" else "emission_luminance"
    shader = value(prefix, "float", 0.5) + value("coat_color", "color3", "0.5, 1, 0")
    shader += value(strength, "float", 2) + value(layer, "float", 0.5)
    bsdf = parsed(document(shader, category=category), tmp_path).data
    found = core(bsdf["bsdfs"]["M"])
    below = [0.75, 1.0, 0.5]
    sheen = below if layer == "sheen" else [1.0] * 3
    assert found["sheen_color"] == pytest.approx([0.5 * c for c in sheen])
    assert str([2.0 * c for c in below]) in str(bsdf)


@pytest.mark.parametrize(
    ("metalness", "color", "told"),
    [(1, 0.4, "straight on"), (0, 0.8, ""), (0.5, 0.8, "left out of the metal")],
)
def test_the_weight_of_the_highlight_scales_metals_of_open_pbr(metalness, color, told, tmp_path):
    shader = value("specular_weight", "float", 0.5) + value("base_metalness", "float", metalness)
    found, said = principled(shader, tmp_path, category="open_pbr_surface")
    assert found["base_color"] == pytest.approx([color] * 3)
    assert any("specular_weight" in line and told in line for line in said) == bool(told)


@pytest.mark.parametrize(
    ("space", "meant", "told"), [("rec709_display", 0.5**2.4, False), ("rgb_of_mars", 0.5, True)]
)
def test_colour_spaces_of_numbers(space, meant, told, tmp_path):
    shader = value("base_color", "color3", "0.5, 0.5, 0.5", f' colorspace="{space}"')
    found, said = principled(shader, tmp_path)
    assert found["base_color"] == pytest.approx([meant] * 3)
    assert any('colour space "rgb_of_mars" is not covered' in line for line in said) == told


def test_a_coat_that_varies_gives_no_layer_that_is_not_there(tmp_path):
    more = value("coat", "float", 0.5) + link("coat_color", "color3", "p")
    more += value("emission", "float", 1) + value("emission_color", "color3", "0, 0, 0")
    found = parsed(document(more, picture()), tmp_path).data
    assert "sheen_color" not in core(found["bsdfs"]["M"])
    assert "radiance" not in str(found["nodes"]["M"])


def test_glass_disperses_light_by_an_abbe_number(tmp_path):
    glass = value("transmission", "float", "1")
    found, said = principled(glass + value("transmission_dispersion", "float", "25"), tmp_path)
    assert found["dispersion"] == 25.0
    assert not any("S:" in line for line in said)
    thin = value("thin_walled", "boolean", "true")
    found, _ = principled(glass + thin + value("transmission_dispersion", "float", "25"), tmp_path)
    assert "dispersion" not in found
    glass = value("transmission_weight", "float", "1")
    glass += value("transmission_dispersion_abbe_number", "float", "30")
    for scale, number in (("0", None), ("1", 30.0), ("0.5", 60.0)):
        spread = value("transmission_dispersion_scale", "float", scale)
        found, _ = principled(glass + spread, tmp_path, category="open_pbr_surface")
        assert found.get("dispersion") == number
    shader = value("transmission", "float", "1") + value("thickness", "float", "1")
    shader += value("dispersion", "float", "0.5")
    found, _ = principled(shader, tmp_path, category="gltf_pbr")
    assert found["dispersion"] == 40.0
