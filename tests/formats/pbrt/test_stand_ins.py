"""What pbrt has and alight lacks: what takes its place, and that it is said."""

import base64

import numpy as np
import pytest

from alight.bsdfs.fibres.hair import Hair
from alight.bsdfs.measured.examples import satin
from alight.formats import load
from alight.formats.materials.substances import SUBSTANCES, diffuse_reflectance
from alight.scene import flatten
from tests.formats.pbrt.reading import messages, node, read, read_bsdf, read_old

PICTURE = '"string filename" "letters.png"'


def textured(kind, *parameters, old=False, use="reflectance", material="diffuse"):
    """The texture that a material shows."""
    body = f'Texture "t" "spectrum" "{kind}" {" ".join(parameters)}'
    name = "matte" if old else material
    use = "Kd" if old else use
    body += f'\nMaterial "{name}" "texture {use}" "t"\nShape "sphere"'
    return read_old(body) if old else read(body)


def test_hair_is_hair():
    assert read_bsdf('"hair"').absorption == Hair(eumelanin=1.3).absorption
    found = read_bsdf('"hair" "rgb color" [0.1 0.2 0] "float beta_m" 0.5 "float eta" 1.4')
    assert isinstance(found, Hair)
    np.testing.assert_allclose(found.color, (0.1, 0.2, 1e-4))
    assert (found.beta_m, found.beta_n, found.ior) == (0.5, 0.3, 1.4)
    found = read_bsdf('"hair" "float eumelanin" 2 "float pheomelanin" 0.5 "float alpha" 3')
    assert (found.eumelanin, found.pheomelanin, found.alpha) == (2.0, 0.5, 3.0)
    found = read_bsdf('"hair" "rgb sigma_a" [1 2 3]')
    np.testing.assert_allclose(found.sigma_a, (1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("kind", "said"), [("measured", 'has no "string filename"'), ("fourier", "is not covered")]
)
def test_what_takes_their_place_is_said(kind, said):
    scene = read(f'Material "{kind}"\nShape "sphere"')
    assert any(f'"{kind}" {said}' in text for text in scene.warnings)


def test_measured_materials_are_read_and_have_two_sides(tmp_path):
    (tmp_path / "it.bsdf").write_bytes(base64.b64decode(satin().plain()))
    (tmp_path / "a.pbrt").write_text(
        'Camera "perspective"\nWorldBegin\nLightSource "point"\n'
        'Material "measured" "string filename" "it.bsdf"\nShape "sphere"'
    )
    (found,) = flatten(load(tmp_path / "a.pbrt")).bsdfs
    assert found.type_name() == "two_sided"
    assert found.bsdf.data == satin()


@pytest.mark.parametrize(
    ("texture", "most"),
    [
        ('"fbm"', 1.0),
        ('"checkerboard" "float tex1" 0.2 "float tex2" 1.5', 1.0),
        ('"checkerboard" "float tex1" 0.2 "float tex2" 0.7', 0.7),
    ],
)
@pytest.mark.parametrize("material", ["conductor", "dielectric", "coateddiffuse"])
def test_textures_of_roughness_end_at_the_roughest(texture, most, material):
    scene = read(
        f'Texture "t" "float" {texture}\nMaterial "{material}" "texture roughness" "t"\n'
        'Shape "sphere"'
    )
    [material] = flatten(scene).bsdfs
    while hasattr(material, "bsdf"):
        material = material.bsdf
    assert max(material.alpha.maximum()) == pytest.approx(most)


def test_media_by_name_have_their_coefficients():
    (scattered, absorbed), eta = SUBSTANCES["Marble"], 1.33
    meant = [diffuse_reflectance(a, s, eta) for a, s in zip(absorbed, scattered, strict=True)]
    found = read_bsdf('"subsurface" "string name" "Marble" "float scale" 2')
    np.testing.assert_allclose(found.color, meant)
    free = [0.5 / (a + s) for a, s in zip(absorbed, scattered, strict=True)]
    np.testing.assert_allclose(found.radius, free)
    assert (found.ior, found.roughness) == (eta, 0.0)
    # The diffuse reflectances of Jensen et al., figure 5.
    printed = {"Marble": (1.5, [0.83, 0.79, 0.75]), "Skin1": (1.3, [0.44, 0.22, 0.13])}
    for name, (index, wanted) in printed.items():
        found = [diffuse_reflectance(a, s, index) for s, a in zip(*SUBSTANCES[name], strict=True)]
        np.testing.assert_allclose(found, wanted, atol=0.008)
    body = 'MakeNamedMedium "m" "string type" "homogeneous" "string preset" "Apple"'
    scene = read(f'{body}\nMediumInterface "m" ""\nMaterial ""\nShape "sphere"')
    assert scene.media["m"].sigma_s == (2.29, 2.39, 1.97)


def test_bodies_have_their_colour_and_free_path():
    given = '"rgb reflectance" [0.8 0.5 0.3] "rgb mfp" [0.3 0.2 0.1] "float scale" 0.5'
    found = read_bsdf(f'"subsurface" {given} "float eta" 1.4 "float roughness" 0.25')
    assert (found.color, found.ior) == ((0.8, 0.5, 0.3), 1.4)
    np.testing.assert_allclose(found.radius, (0.15, 0.1, 0.05))
    given = '"rgb sigma_a" [1 2 3] "rgb sigma_s" [8 16 24] "float g" 0.5'
    np.testing.assert_allclose(read_bsdf(f'"subsurface" {given}').radius, (0.2, 0.1, 1.0 / 15.0))
    old = read_bsdf('"kdsubsurface" "rgb Kd" [0.5 0.25 0.125] "rgb mfp" [1 2 3]', old=True)
    assert (old.color, old.radius) == ((0.5, 0.25, 0.125), (1.0, 2.0, 3.0))


SPHERE = 'Material "subsurface"\nShape "sphere"'
BODY = 'MakeNamedMaterial "w" "string type" "subsurface"'
MIXED = 'MakeNamedMaterial "m" "string type" "mix" "string materials" ["w" "w"]'
MATTE = 'MakeNamedMaterial "d" "string type" "diffuse"\n'
SECOND = MATTE + MIXED.replace('"w" "w"', '"d" "w"')
FILLED = 'MakeNamedMedium "m" "string type" "homogeneous"\nMediumInterface "m" ""'


@pytest.mark.parametrize(
    "body",
    [
        f'{BODY}\n{MIXED}\nNamedMaterial "m"\nShape "disk"',
        f'{BODY}\n{SECOND}\nNamedMaterial "m"\nShape "disk"',
        f'{SPHERE} "float alpha" 0.5',
        f"{FILLED}\n{SPHERE}",
        'Material "subsurface"\nShape "curve" "point3 P" [0 0 0 1 0 0 2 0 0 3 0 0]',
    ],
)
def test_where_no_body_can_be_a_coat_takes_its_place(body):
    scene = read(body)
    assert not any(bsdf.type_name() == "subsurface" for bsdf in scene.bsdfs.values())
    assert any("a coat is taken" in text for text in scene.warnings)


def test_factors_of_heights_may_be_negative():
    maps = (
        f'Texture "h" "float" "imagemap" {PICTURE}\n'
        'Texture "two" "float" "constant" "float value" 2\n'
        'Texture "a" "float" "scale" "texture tex" "h" "float scale" -0.05\n'
        'Texture "b" "float" "scale" "texture tex" "a" "texture scale" "two"\n'
    )
    scene = read(f'{maps}Material "diffuse" "texture displacement" "b"\nShape "sphere"')
    [bump] = scene.bsdfs.values()
    assert bump.type_name() == "bump_map"
    assert bump.scale == pytest.approx(-0.1)
    assert scene.textures[bump.texture].type_name() == "bitmap"
    # What was looked into counts as used.
    assert not any("nothing uses" in note for note in scene.source.remarks.notes)


def test_pictures_of_reflectances_are_cut_at_one():
    maps = (
        f'Texture "p" "spectrum" "imagemap" {PICTURE}\n'
        'Texture "t" "spectrum" "scale" "texture tex" "p" "float scale" 1.5\n'
    )
    scene = read(f'{maps}Material "diffuse" "texture reflectance" "t"\nShape "sphere"')
    [material] = scene.bsdfs.values()
    assert scene.textures[material.bsdf.reflectance].type_name() == "clamp"
    scene = read(f'{maps}Material "diffuse" "texture reflectance" "p"\nShape "sphere"')
    [material] = scene.bsdfs.values()
    assert scene.textures[material.bsdf.reflectance].type_name() == "bitmap"
    # Numbers above 1 are cut in pbrt 3, and refused in pbrt 4.
    found = read_bsdf('"matte" "rgb Kd" [1.5 1 0.5]', old=True).bsdf.reflectance
    assert found == (1.0, 1.0, 0.5)
    assert "in [0, 1]" in messages('Material "diffuse" "rgb reflectance" [1.5 1 1] Shape "disk"')[0]


def test_gradients_go_from_corner_to_corner():
    corners = '"rgb v00" [1 0 0] "rgb v10" [0 1 0] "rgb v01" [0 0 1] "rgb v11" [1 1 1]'
    scene = textured("bilerp", corners)
    [texture] = scene.textures.values()
    np.testing.assert_array_equal(texture.pixels.texels[1], [[1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(texture.pixels.texels[0], [[0, 0, 1], [1, 1, 1]])
    from tests.textures.lookup import look_up

    u, v = np.array([0.0, 1.0, 0.0, 0.25]), np.array([0.0, 0.0, 1.0, 0.5])
    meant = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.25, 0.5]]
    np.testing.assert_allclose(look_up(texture, u, v), meant, atol=1e-6)
    [texture] = textured("uv").textures.values()
    np.testing.assert_allclose(look_up(texture, u, v)[:, :2], np.stack([u, v], 1), atol=1e-6)


def test_gradients_beyond_their_square():
    """The part of (u, v) after the point begins again; others stay as at their edges."""
    from tests.textures.lookup import look_up

    places = '"float uscale" 4 "float udelta" 0.5 "float vscale" 2'
    [texture] = textured("uv", places, old=True).textures.values()
    u, v = np.random.default_rng(1).random((2, 50))
    meant = np.stack([4.0 * u + 0.5, 2.0 * v], axis=1) % 1.0
    np.testing.assert_allclose(look_up(texture, u, v)[:, :2], meant, atol=1 / 500)
    scene = textured("bilerp", places)
    assert any("beyond its corners" in text for text in scene.warnings)
    assert not any("beyond its corners" in text for text in textured("bilerp").warnings)


def test_waves_out_of_range_are_told_of():
    scene = textured("fbm", '"integer octaves" 40 "float roughness" 1.5')
    said = "\n".join(scene.warnings)
    assert '"integer octaves" became 16' in said
    assert '"float roughness" became 1' in said


@pytest.mark.parametrize("text", ["float eumelanin", "float pheomelanin", "float beta_n"])
def test_numbers_of_hair_have_their_range(text):
    most = 1 if "beta" in text else 1000
    for value in (-0.5, most + 1):
        found = messages(f'Material "hair" "{text}" {value} Shape "sphere"')
        assert found == [f"must be in [0, {most}], got {value:g}"]
    assert "must be >= 0" in messages('Material "hair" "rgb sigma_a" [1 -1 1] Shape "sphere"')[0]


def test_hair_that_absorbs_by_a_texture_is_told_of():
    scene = textured("checkerboard", use="sigma_a", material="hair")
    assert any('"texture sigma_a" is a texture' in text for text in scene.warnings)
    scene = textured("checkerboard", use="color", material="hair")
    assert any("textured colour: a matte surface" in text for text in scene.warnings)


@pytest.mark.parametrize("kind", ["fbm", "wrinkled", "windy", "marble"])
def test_waves_become_noise_and_it_is_said(kind):
    scene = textured(kind, old=True)
    assert "noise" in {texture.type_name() for texture in scene.textures.values()}
    assert any(f'"{kind}" becomes noise' in text for text in scene.warnings)


def test_waves_stand_in_the_space_of_their_texture():
    body = 'Scale 2 4 8 Translate 1 0 0 Texture "t" "spectrum" "wrinkled"\n'
    scene = read(f'{body}Material "diffuse" "texture reflectance" "t"\nShape "sphere"')
    [noise] = [t for t in scene.textures.values() if t.type_name() == "noise"]
    # A point of the world is (x / 2 - 1, y / 4, z / 8) there.
    assert noise.scale == (0.5, 0.25, 0.125)
    assert noise.offset == (-1.0, 0.0, 0.0)


@pytest.mark.parametrize(("kind", "size"), [("marble", 3.0), ("windy", 0.1)])
def test_waves_are_finer_by_their_scale(kind, size):
    """pbrt multiplies the point by it; the wind is ten times as wide as its waves."""
    given = '"float scale" 3' if kind == "marble" else ""
    body = f'Scale 2 4 8 Texture "t" "spectrum" "{kind}" {given}\n'
    scene = read(f'{body}Material "diffuse" "texture reflectance" "t"\nShape "sphere"')
    found = [t.scale for t in scene.textures.values() if t.type_name() == "noise"]
    assert any(np.allclose(scale, size * np.array([0.5, 0.25, 0.125])) for scale in found)


def test_unseen_spheres_light_as_points():
    lamp = 'AreaLightSource "diffuse" "rgb L" [3 2 1]\nTranslate 1 2 3\nShape "sphere"'
    scene = read(f'{lamp} "float radius" 2 "float alpha" 0')
    light = node(scene).light
    np.testing.assert_allclose(light.intensity, 4.0 * np.pi * np.array([3, 2, 1]), rtol=1e-6)
    assert node(scene).transform.apply_point((0, 0, 0)).tolist() == [1.0, 2.0, 3.0]
    assert any("without being seen" in text for text in scene.warnings)
    # The area light of the same power: pi L times the surface.
    power = lamp.replace('"rgb L" [3 2 1]', '"rgb L" [1 1 1] "float power" 12')
    light = node(read(f'{power} "float alpha" 0')).light
    np.testing.assert_allclose(light.intensity, 12.0 / (4.0 * np.pi), rtol=1e-6)


def test_shining_pictures():
    lamp = f'AreaLightSource "diffuse" {PICTURE} "float scale" 3'
    uv = '"point2 uv" [0 0 1 0 1 1]'
    points = '"point3 P" [0 0 0 1 0 0 1 1 0] "integer indices" [0 1 2]'
    radiance = node(read(f'{lamp}\nShape "trianglemesh" {points} {uv}')).light.radiance
    assert radiance.type_name() == "multiply"
    assert radiance.b == (3.0, 3.0, 3.0)


def test_an_included_file_may_end_within_a_directive(tmp_path):
    (tmp_path / "part.pbrt").write_text(
        'MakeNamedMedium "smoke" "string type" "uniformgrid" "integer nx" 2\n"float density" [1 2]'
    )
    body = 'Include "part.pbrt"\n"rgb sigma_a" [0 0 0] "rgb sigma_s" [3 3 3]\n'
    scene = read(f'{body}MediumInterface "smoke" ""\nMaterial ""\nShape "sphere"', folder=tmp_path)
    assert scene.media["smoke"].sigma_s == (3.0, 3.0, 3.0)
    # Elsewhere texts behind an Include are no directive.
    (tmp_path / "part.pbrt").write_text("Identity\n")
    assert "unknown directive" in messages(body, folder=tmp_path)[0]


def test_colored_grids_keep_their_albedos():
    grid = (
        'MakeNamedMedium "g" "string type" "rgbgrid" "integer nx" 2 "float scale" 2\n'
        '"rgb sigma_s" [1 2 3 1 1 1] "rgb sigma_a" [1 0 1 0 0 0]\n'
    )
    scene = read(f'{grid}MediumInterface "g" ""\nMaterial ""\nShape "sphere"')
    medium = scene.media["g"]
    # One rim of cells around the two.
    inside = medium.values.values[1, 1, 1:3, 0]
    np.testing.assert_allclose(inside, [(2 + 2 + 4) / 3, 1.0])
    assert medium.sigma_t == (2.0, 2.0, 2.0)
    np.testing.assert_allclose(medium.albedo_values.values[1, 1, 1], [0.5, 1.0, 0.75])
    assert any("as dense for all colours" in text for text in scene.warnings)
    short = grid.replace("1 1 1]", "1 1]")
    assert "= 2 colours, got 5" in messages(f'{short}MediumInterface "g" ""')[0]


def test_illuminants_have_their_chromaticities():
    from alight.core.spectra import TO_SRGB

    for name, x, y in (("stdillum-F4", 0.4402, 0.4031), ("stdillum-A", 0.44758, 0.40745)):
        light = node(read(f'LightSource "point" "spectrum I" "{name}"')).light
        xyz = np.linalg.inv(TO_SRGB) @ light.intensity
        np.testing.assert_allclose(xyz[:2] / xyz.sum(), [x, y], atol=1e-6)
        assert xyz[1] == pytest.approx(1.0)


def test_pictures_twice_as_wide_as_high_are_maps_of_pbrt_3(tmp_path):
    texels = np.random.default_rng(1).random((4, 8, 3), np.float32)
    np.save(tmp_path / "wide.npy", texels)
    new = read('LightSource "infinite" "string filename" "wide.npy"', folder=tmp_path)
    old = read_old('LightSource "infinite" "string mapname" "wide.npy"', folder=tmp_path)
    assert node(new).light == node(old).light
    np.testing.assert_array_equal(node(new).transform.matrix, node(old).transform.matrix)
    assert any("latitude and longitude" in text for text in new.warnings)
    # A light from far away has no place: projective matrices of exporters do no harm.
    skewed = "ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 7 0 0 0 1]"
    same = read(f'{skewed} LightSource "infinite" "string filename" "wide.npy"', folder=tmp_path)
    np.testing.assert_array_equal(node(same).transform.matrix, node(new).transform.matrix)


def test_film_scale_of_early_files_is_exposure():
    head = 'Camera "perspective"\nFilm "rgb" "float scale" 3 "float iso" 200\n'
    light = node(read('LightSource "point" "rgb I" [1 1 1]', head)).light
    np.testing.assert_allclose(light.intensity, 6.0, rtol=1e-6)
