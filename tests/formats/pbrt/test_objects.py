"""Materials and textures: what a file says becomes the description that was meant."""

import numpy as np
import pytest

from alight.formats.pbrt.walks import Coat, base_of_walk
from tests.formats.pbrt.reading import (
    messages,
    native,
    node,
    read,
    read_bsdf,
    read_old,
    two_sided,
)

COPPER = "eta: [0.20101, 0.92375, 1.1022], k: [3.9133, 2.453, 2.1421]"
GOLD = "eta: [0.14304, 0.37531, 1.442], k: [3.983, 2.3856, 1.6034]"

BOTH_SIDES = {
    '"diffuse"': "{type: diffuse, reflectance: 0.5}",
    '"diffuse" "rgb reflectance" [.1 .2 .3]': "{type: diffuse, reflectance: [0.1, 0.2, 0.3]}",
    '"conductor"': f"{{type: conductor, {COPPER}}}",
    '"conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" .3'
    ' "bool remaproughness" false': f"{{type: rough_conductor, {GOLD}, alpha: 0.3}}",
    '"conductor" "float uroughness" .04 "float vroughness" .25': (
        f"{{type: rough_conductor, {COPPER}, alpha_u: 0.2, alpha_v: 0.5}}"
    ),
}  # fmt: skip

ONE_SIDED = {
    '"dielectric"': "{type: dielectric, int_ior: 1.5, ext_ior: 1}",
    '"dielectric" "spectrum eta" "glass-SF11"': "{type: dielectric, dispersion: sf11, ext_ior: 1}",
    '"dielectric" "float roughness" 0.09 "float eta" 1.3': (
        "{type: rough_dielectric, int_ior: 1.3, ext_ior: 1, alpha: 0.3}"
    ),
    '"thindielectric" "float eta" 1.2': "{type: thin_dielectric, int_ior: 1.2, ext_ior: 1}",
    '"diffusetransmission" "rgb reflectance" [.4 .2 0] "float scale" .5': (
        "{type: diffuse_transmission, reflectance: [0.2, 0.1, 0], transmittance: 0.125}"
    ),
    '"interface"': "{type: 'null'}",
    '""': "{type: 'null'}",
}


@pytest.mark.parametrize("material", BOTH_SIDES)
def test_materials_that_have_two_sides(material):
    assert read_bsdf(material) == two_sided(BOTH_SIDES[material])


@pytest.mark.parametrize("material", ONE_SIDED)
def test_materials_that_tell_inside_from_outside(material):
    assert read_bsdf(material) == native("bsdfs", ONE_SIDED[material])


OF_3 = {
    '"matte" "rgb Kd" [.1 .2 .3]': "{type: diffuse, reflectance: [0.1, 0.2, 0.3]}",
    '"matte" "float sigma" 20': "{type: oren_nayar, reflectance: 0.5, sigma: 20}",
    '"mirror"': "{type: mirror, reflectance: 0.9}",
    '"plastic" "float roughness" 0.1 "bool remaproughness" "false"': (
        "{type: rough_plastic, alpha: 0.1, int_ior: 1.5, ext_ior: 1, "
        "diffuse_reflectance: 0.25, specular_reflectance: 0.25}"
    ),
    '"metal" "float roughness" 1': f"{{type: rough_conductor, {COPPER}, alpha: 1}}",
}


@pytest.mark.parametrize("material", OF_3)
def test_materials_of_pbrt_3(material):
    assert read_bsdf(material, old=True) == two_sided(OF_3[material])


def test_glass_of_pbrt_3():
    meant = "{type: dielectric, int_ior: 1.4, ext_ior: 1, specular_reflectance: 0.5}"
    found = read_bsdf('"glass" "float index" 1.4 "rgb Kr" [.5 .5 .5]', old=True)
    assert found == native("bsdfs", meant)


def test_reflectance_of_a_conductor_is_what_it_reflects_straight_on():
    bsdf = read_bsdf('"conductor" "rgb reflectance" [.2 .5 .9]').bsdf
    eta, k = np.array(bsdf.eta), np.array(bsdf.k)
    found = ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)
    np.testing.assert_allclose(found, [0.2, 0.5, 0.9], rtol=1e-12)


def test_amount_of_a_mixture_is_of_the_second_material_and_in_pbrt_3_of_the_first():
    body = """MakeNamedMaterial "a" "string type" "{0}" MakeNamedMaterial "b" "string type" "{1}"
    MakeNamedMaterial "m" "string type" "mix" "float amount" 0.25 {2}
    NamedMaterial "m" Shape "sphere" """
    parts = '"string materials" ["a" "b"]'
    scene = read(body.format("diffuse", "dielectric", parts))
    assert (scene.bsdfs["m"].weight, scene.bsdfs["m"].bsdfs) == (0.25, ("a", "b"))
    parts = '"string namedmaterial1" "a" "string namedmaterial2" "b"'
    scene = read_old(body.format("matte", "glass", parts))
    assert (scene.bsdfs["m"].weight, scene.bsdfs["m"].bsdfs) == (0.25, ("b", "a"))


def test_mixtures_that_hold_themselves():
    body = """MakeNamedMaterial "m" "string type" "mix" "string materials" ["m" "m"]
    NamedMaterial "m" Shape "sphere" """
    [message] = messages(body)
    assert "contains itself" in message


# ---------------------------------------------------------------- textures

PICTURE = '"string filename" "letters.png"'


def texture_of(texture: str, kind: str = "spectrum"):
    body = f'Texture "t" "{kind}" {texture}\nMaterial "diffuse" "texture reflectance" "t"\n'
    return read(body + 'Shape "sphere"').textures["t"]


TEXTURES = {
    f'"imagemap" {PICTURE}': "{type: bitmap, file: letters.png}",
    f'"imagemap" {PICTURE} "string wrap" "clamp" "string encoding" "linear" '
    '"float uscale" 2 "float vscale" 3 "float udelta" .5': (
        "{type: bitmap, file: letters.png, wrap: clamp, color_space: linear, "
        "to_uv: [{scale: [2, 3]}, {translate: [0.5, 0]}]}"
    ),
    '"checkerboard" "rgb tex1" [.9 .1 .1] "rgb tex2" [.1 .1 .9] "float uscale" 4 "float vscale" 4':
        "{type: checkerboard, color0: [0.9, 0.1, 0.1], color1: [0.1, 0.1, 0.9], "
        "to_uv: [{scale: [4, 4]}]}",
}  # fmt: skip


@pytest.mark.parametrize("texture", TEXTURES)
def test_textures(texture):
    assert texture_of(texture) == native("textures", TEXTURES[texture])


def test_constant_textures_are_folded():
    body = """Texture "a" "spectrum" "constant" "rgb value" [.2 .4 .6]
    Texture "b" "spectrum" "scale" "texture tex" "a" "float scale" .5
    Texture "c" "spectrum" "mix" "texture tex1" "b" "rgb tex2" [1 1 1] "float amount" .25
    Material "diffuse" "texture reflectance" "c" Shape "sphere" """
    [bsdf] = read(body).bsdfs.values()
    np.testing.assert_allclose(bsdf.bsdf.reflectance, [0.325, 0.4, 0.475])


def test_textures_are_found_by_kind_and_where_they_are_defined():
    body = """Texture "a" "float" "constant" "float value" .25
    Texture "a" "spectrum" "constant" "rgb value" [.1 .2 .3]
    Material "diffuse" "texture reflectance" "a"
    Texture "a" "spectrum" "constant" "rgb value" [.9 .9 .9]
    Shape "sphere" """
    [bsdf] = read(body).bsdfs.values()
    assert bsdf.bsdf.reflectance == (0.1, 0.2, 0.3)
    [message] = messages('Material "diffuse" "texture reflectance" "nil" Shape "sphere"')
    assert 'unknown texture "nil"' in message


def test_opacity_of_a_shape_is_a_mask():
    scene = read('Shape "sphere" "float alpha" 0.25')
    assert (node(scene).bsdf.type_name(), node(scene).bsdf.opacity) == ("mask", 0.25)
    assert node(read('Shape "sphere" "float alpha" 1')).bsdf == "default"
    body = f'Texture "t" "float" "imagemap" {PICTURE}\nShape "sphere" "texture alpha" "t"'
    assert node(read(body)).bsdf.opacity == "t"


def test_bumps_lie_around_a_material():
    height = f'Texture "h" "float" "imagemap" {PICTURE}\n'
    meant = "{type: bump_map, texture: h, bsdf: {type: two_sided, bsdf: {type: diffuse}}}"
    tables = {"textures": "{h: {type: bitmap, file: letters.png}}"}
    body = f'{height}Material "diffuse" "texture displacement" "h" Shape "sphere"'
    [found] = read(body).bsdfs.values()
    assert found == native("bsdfs", meant, **tables)
    old = f'{height}Material "matte" "texture bumpmap" "h" Shape "sphere"'
    assert [*read_old(old).bsdfs.values()] == [found]
    meant = (
        "{type: normal_map, texture: {type: bitmap, file: letters.png, color_space: linear}, "
        "bsdf: {type: thin_dielectric, int_ior: 1.5, ext_ior: 1}}"
    )
    assert read_bsdf('"thindielectric" "string normalmap" "letters.png"') == native("bsdfs", meant)


def test_products_and_inverses_of_pictures_are_nodes():
    body = f"""Texture "a" "spectrum" "imagemap" {PICTURE} "float scale" 0.5 "bool invert" true
    Material "diffuse" "texture reflectance" "a" Shape "sphere" """
    scene = read(body)
    [bsdf] = scene.bsdfs.values()
    mix = scene.textures[bsdf.bsdf.reflectance]
    product = scene.textures[mix.weight]
    assert (mix.type_name(), mix.a, mix.b) == ("mix", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    assert (product.type_name(), product.b) == ("multiply", (0.5, 0.5, 0.5))
    assert scene.textures[product.a].file == "letters.png"


def test_layers_over_metal_keep_their_numbers():
    given = """"coatedconductor" "float conductor.roughness" .0625 "float interface.roughness" .0001
        "float interface.eta" 1.4 "float thickness" .03 "integer maxdepth" 7 "integer nsamples" 4
        "rgb reflectance" [.2 .5 .9]"""
    scene = read(f'Material {given}\nShape "sphere"')
    [bsdf] = scene.bsdfs.values()
    found = bsdf.bsdf
    # Alpha is the root of the roughness; of 7 events numbers 1, 3, 5 and 7 are at the metal.
    assert (found.alpha, found.int_ior, found.ext_ior) == (0.25, 1.4, 1.0)
    assert found.coat_alpha == pytest.approx(0.01)
    assert (found.thickness, found.bounces) == (0.03, 4)
    # pbrt's k for a reflectance, of a metal in air.
    eta, k = found.index_of_refraction
    np.testing.assert_allclose(k, 2.0 * np.sqrt([0.25, 1.0, 9.0]))
    assert eta == (1.0, 1.0, 1.0)
    assert any("reflects as much as in pbrt within 0.01" in w for w in scene.warnings)
    smooth = read_bsdf('"coatedconductor"').bsdf
    assert (smooth.alpha, smooth.coat_alpha) == (0.001, 0.001)
    assert (smooth.thickness, smooth.bounces) == (0.01, 5)


def test_layers_with_textures_and_disney_become_the_principled_material():
    texture = 'Texture "a" "float" "checkerboard" "float tex1" .04 "float tex2" .0625'
    given = '"coatedconductor" "texture conductor.roughness" "a" "rgb reflectance" [.2 .5 .9]'
    scene = read(f'{texture}\nMaterial {given}\nShape "sphere"')
    [bsdf] = scene.bsdfs.values()
    found = bsdf.bsdf
    assert (found.metallic, found.clearcoat, found.clearcoat_roughness) == (1.0, 1.0, 0.0)
    # k / 1.5 inside of the coat: less is reflected than in air.
    k2 = np.array([0.25, 1.0, 9.0]) * 4.0 / 2.25
    eta = 1.0 / 1.5
    expected = ((eta - 1.0) ** 2 + k2) / ((eta + 1.0) ** 2 + k2)
    np.testing.assert_allclose(found.base_color, expected)
    assert any("principled metal" in warning for warning in scene.warnings)
    found = read_bsdf('"disney" "float metallic" 1 "float roughness" 0.3', old=True).bsdf
    assert (found.type_name(), found.metallic, found.roughness) == ("principled", 1.0, 0.3)


def test_layers_over_matte_stuff_have_the_base_of_pbrts_walk():
    keys = '"float eta" 1.4 "rgb reflectance" [.1 .2 .3] "float thickness" .2 "integer maxdepth" 5'
    for roughness, alpha in ((0.0, 0.0), (0.25, 0.5)):
        scene = read(
            f'Material "coateddiffuse" "float roughness" {roughness} {keys} Shape "sphere"'
        )
        [bsdf] = scene.bsdfs.values()
        found = bsdf.bsdf
        assert (found.int_ior, found.ext_ior, found.nonlinear) == (1.4, 1.0, True)
        assert getattr(found, "alpha", 0.0) == alpha
        expected = base_of_walk([0.1, 0.2, 0.3], Coat(alpha, 1.4, 0.2, 3))
        np.testing.assert_allclose(found.diffuse_reflectance, expected)
        assert any("too dark towards the rim" in w for w in scene.warnings) == (alpha > 0.0)
    texture = 'Texture "a" "spectrum" "checkerboard"'
    scene = read(f'{texture} Material "coateddiffuse" "texture reflectance" "a" Shape "sphere"')
    [bsdf] = scene.bsdfs.values()
    product = scene.textures[bsdf.bsdf.diffuse_reflectance]
    np.testing.assert_allclose(product.b, base_of_walk([0.7], Coat(0.0, 1.5, 0.01, 5))[0] / 0.7)
    assert any("texture below a coat" in warning for warning in scene.warnings)


# ---------------------------------------------------------------- what is out of range, or unused


def test_roughness_below_zero_is_refused_and_above_one_cut_and_said():
    [message] = messages('Material "conductor" "float vroughness" -0.5 Shape "sphere"')
    assert message == "must be >= 0, got -0.5"
    scene = read('Material "dielectric" "float roughness" 4 Shape "sphere"')
    assert scene.bsdfs["dielectric"].alpha == 1.0
    assert any("alpha 2 became 1" in line for line in scene.warnings)


def test_a_substrate_as_it_stands_becomes_the_brightest_coat():
    scene = read_old('Material "substrate" Shape "sphere"')
    coat = scene.bsdfs["substrate"].bsdf
    assert coat.int_ior == pytest.approx(5.0) and coat.specular_reflectance == (1.0, 1.0, 1.0)
    assert any("more than 0.444 straight on" in line for line in scene.warnings)
    # Up to there it reflects what the file says.
    scene = read_old('Material "substrate" "rgb Ks" [.2 .1 .2] Shape "sphere"')
    coat = scene.bsdfs["substrate"].bsdf
    straight_on = ((coat.int_ior - 1.0) / (coat.int_ior + 1.0)) ** 2
    np.testing.assert_allclose(straight_on * np.array(coat.specular_reflectance), [0.2, 0.1, 0.2])


@pytest.mark.parametrize(("given", "said"), [("", True), ('"rgb Ks" [0 0 0]', False)])
def test_the_gloss_of_translucent_is_left_out_and_said(given, said):
    scene = read_old(f'Material "translucent" {given} Shape "sphere"')
    assert any("adds its gloss" in line for line in scene.warnings) == said


def test_textures_and_materials_that_nothing_uses_are_listed():
    scene = read(
        """Texture "used" "float" "constant" "float value" 0.25
        Texture "t" "spectrum" "constnt" Texture "u" "spectrum" "imagemap"
        MakeNamedMaterial "a" "string type" "diffuse"
        MakeNamedMaterial "b" "string type" "conductor" "texture roughness" "used"
        NamedMaterial "b" Shape "sphere" """
    )
    notes = [note for note in scene.source.remarks.notes if "nothing uses" in note]
    assert notes == [
        'textures that nothing uses are not read: "t", "u"',
        'materials that nothing uses are not read: "a"',
    ]
