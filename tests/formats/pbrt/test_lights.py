"""Lights and settings of pbrt: amounts, spectra, exposure, film, camera, integrator."""

import math

import numpy as np
import pytest

from alight.lights.spot import mean_color
from tests.formats.pbrt.reading import HEAD, messages, node, read, read_bsdf, read_old

TENT = '"point3 P" [0 0 0  1 0 0  1 1 0  0 1 1] "integer indices" [0 1 2  0 2 3]'


def light_of(body: str, head: str = HEAD, **options):
    return next(n for n in read(body, head, **options).nodes.values() if n.light is not None)


def test_amounts_of_light():
    light = light_of('LightSource "point" "rgb I" [1 2 3] "float scale" 2 "point3 from" [1 2 3]')
    np.testing.assert_allclose(light.light.intensity, [2, 4, 6])
    assert light.transform.apply_point([0, 0, 0]).tolist() == [1, 2, 3]
    light = light_of('LightSource "point" "float power" 100')
    np.testing.assert_allclose(light.light.intensity, 100 / (4 * math.pi))
    light = light_of('LightSource "distant" "float illuminance" 5 "point3 to" [1 0 0]')
    np.testing.assert_allclose(light.light.irradiance, 5.0)
    np.testing.assert_allclose(light.transform.apply_vector([0, 0, 1]), [1, 0, 0], atol=1e-12)


def test_spectra_of_lights_have_luminance_one():
    for colour in ('"blackbody I" 3000', '"spectrum I" [400 1 500 2 600 3 700 1]'):
        found = np.array(light_of(f'LightSource "point" {colour}').light.intensity)
        assert found @ [0.212656, 0.715158, 0.072186] == pytest.approx(1.0, rel=1e-4)
        assert found[0] > 1.0 > found[2]


def test_blackbodies_of_pbrt_3_reach_one():
    scene = read_old('LightSource "point" "blackbody I" [3000 2]')
    old = np.array(node(scene).light.intensity)
    new = np.array(light_of('LightSource "point" "blackbody I" 3000').light.intensity)
    np.testing.assert_allclose(old / old[0], new / new[0])
    # The largest value, 2, lies beyond the visible: luminance is less.
    assert 0.5 < old @ [0.2127, 0.7152, 0.0722] < 1.5


def test_exposure_of_the_film_scales_all_light():
    head = 'Camera "perspective" "float shutterclose" 0.5\nFilm "rgb" "float iso" 400\n'
    bodies = {
        'LightSource "point"': "intensity",
        'LightSource "distant"': "irradiance",
        'AreaLightSource "diffuse" Shape "sphere"': "radiance",
    }
    for body, name in bodies.items():
        assert getattr(light_of(body, head).light, name) == (2.0, 2.0, 2.0)
    assert read('LightSource "infinite"', head).environment.radiance == (2.0, 2.0, 2.0)
    head = 'Camera "perspective"\nFilm "image" "float scale" 3\n'
    assert light_of('LightSource "point" WorldEnd', head).light.intensity == (3.0, 3.0, 3.0)


@pytest.mark.parametrize(("cone", "delta"), [(30, 5), (40, 40), (150, 60)])
def test_spots_fade_as_in_pbrt(cone, delta):
    given = f'"float coneangle" {cone} "float conedeltaangle" {delta}'
    light = light_of(f'LightSource "spot" {given} "float power" 10').light
    assert (light.cutoff_angle, light.beam_width) == (cone, cone - delta)
    assert light.falloff == "smooth"
    # All that it shines with is what the file asks.
    np.testing.assert_allclose(4 * math.pi * np.array(mean_color(light)), 10.0)
    old = node(read_old(f'LightSource "spot" {given}')).light
    assert (old.cutoff_angle, old.beam_width, old.falloff) == (cone, cone - delta, "quartic")


def test_lights_of_shapes():
    body = 'AreaLightSource "diffuse" "rgb L" [1 2 3] "float scale" 2\n'
    assert light_of(f'{body}Shape "sphere"').light.radiance == (2.0, 4.0, 6.0)
    power = 'Scale 2 2 2 AreaLightSource "diffuse" "float power" 10\n'
    shapes = {
        '"sphere" "float radius" 3': 4 * math.pi * 36,
        '"disk" "float radius" 3': math.pi * 36,
        '"cylinder" "float radius" 3 "float zmin" 0': 2 * math.pi * 6 * 2,
        f'"trianglemesh" {TENT}': 4 * (0.5 + 0.5 * math.sqrt(3.0)),
    }
    for shape, size in shapes.items():
        found = light_of(f"{power}Shape {shape}").light.radiance
        np.testing.assert_allclose(found, 10 / (math.pi * size), rtol=1e-5)


@pytest.mark.parametrize("shape", ['"disk"', '"cylinder"', f'"trianglemesh" {TENT}'])
def test_lights_with_two_sides_are_two_surfaces(shape):
    body = f'AreaLightSource "diffuse" "bool twosided" true "float power" 10\nShape {shape}'
    scene = read(body)
    front, back = scene.nodes.values()
    assert (front.shape.flip_normals, back.shape.flip_normals) == (False, True)
    assert front.light == back.light
    one = light_of(body.replace("true", "false"))
    np.testing.assert_allclose(np.array(one.light.radiance) / 2, front.light.radiance)
    sphere = 'AreaLightSource "diffuse" "bool twosided" true\nShape "sphere"'
    assert len(read(sphere).nodes) == 1


def test_lights_in_objects_do_not_shine_as_in_pbrt():
    body = """ObjectBegin "o" AreaLightSource "diffuse" Shape "sphere" ObjectEnd
    ObjectInstance "o" LightSource "point" """
    scene = read(body)
    [child] = scene.prototypes["o"].children.values()
    assert child.light is None
    assert any("pbrt shows no light there" in warning for warning in scene.warnings)


def test_light_from_all_around():
    scene = read('LightSource "infinite" "float illuminance" 6.2831853072')
    np.testing.assert_allclose(scene.environment.radiance, 2.0)
    body = 'LightSource "infinite" "rgb L" [1 0 0]\nLightSource "infinite" "rgb L" [0 1 0]'
    assert read(body).environment.radiance == (1.0, 1.0, 0.0)


def test_lights_from_all_around_add_up(tmp_path):
    np.save(tmp_path / "map.npy", np.ones((8, 8, 3), np.float32))
    picture = 'LightSource "infinite" "string filename" "map.npy"'
    body = f'{picture}\nLightSource "infinite" "rgb L" [1 0 0]\n{picture}'
    scene = read(body, folder=tmp_path)
    assert scene.environment.radiance == (1.0, 0.0, 0.0)
    assert [found.light.type_name() for found in scene.nodes.values()] == ["environment"] * 2
    assert not any("not covered" in text for text in scene.warnings)


# ---------------------------------------------------------------- settings


def test_film_filter_sampler_integrator():
    head = """Camera "perspective" "float lensradius" 0.1 "float focaldistance" 7
    Film "rgb" "integer xresolution" 40 "integer yresolution" 20 "float cropwindow" [.25 .5 0 1]
    Sampler "zsobol" "integer pixelsamples" 33 Integrator "volpath" "integer maxdepth" 9
    PixelFilter "triangle" "float xradius" 1.5 "float yradius" 1.5
    """
    scene = read('Shape "sphere"', head)
    assert (scene.film.size, scene.film.crop) == ((40, 20), (10, 0, 10, 20))
    assert (scene.film.filter.type_name(), scene.film.filter.radius) == ("tent", 1.5)
    camera = scene.camera.camera
    assert (camera.aperture_radius, camera.focus_distance) == (0.1, 7.0)
    assert scene.source.remarks.spp == 33
    assert scene.sampler.type_name() == "sobol"
    # Bounces in pbrt, edges of the path here.
    assert scene.integrator.max_depth == 10
    scene = read('Shape "sphere"', 'Camera "perspective"\n')
    assert (scene.film.size, scene.source.remarks.spp) == ((1280, 720), 16)
    assert (scene.film.filter.stddev, scene.film.filter.radius) == (0.5, 1.5)
    assert scene.integrator.max_depth == 6
    scene = read('Shape "sphere"\nWorldEnd', 'Camera "perspective"\n')
    assert (scene.film.size, scene.film.filter.type_name()) == ((640, 480), "box")


def test_what_three_numbers_lose_of_a_spectrum_is_told():
    def told(body, of=read):
        return [warning for warning in of(body).warnings if "reduced to linear sRGB" in warning]

    red = '"diffuse" "spectrum reflectance" [400 .02 580 .04 620 .85 700 .9]'
    body = f'Material {red}\nShape "sphere"'
    [found] = told(body)
    assert "it is seen off by 0 %, after two reflections by 5 %, of its largest channel" in found
    # pbrt 3 reduces spectra, too; a grey loses nothing.
    assert not told(body, read_old)
    assert not told('Material "diffuse" "spectrum reflectance" [300 .5 900 .5]\nShape "sphere"')
    [found] = told('LightSource "point" "spectrum I" [520 0 530 1 540 0]\nShape "sphere"')
    assert "it is seen off by 55 % of its largest channel" in found


def test_colour_spaces_and_spectra(tmp_path):
    body = 'ColorSpace "rec2020" Material "diffuse" "rgb reflectance" [.5 .5 .5] Shape "sphere"'
    [bsdf] = read(body).bsdfs.values()
    # White stays white.
    np.testing.assert_allclose(bsdf.bsdf.reflectance, 0.5, atol=1e-3)
    flat = '"diffuse" "spectrum reflectance" [300 .5 900 .5]'
    np.testing.assert_allclose(read_bsdf(flat).bsdf.reflectance, 0.5, rtol=2e-3)
    (tmp_path / "s.spd").write_text("# a remark\n300 0.25 # here too\n900 0.25\n")
    filed = '"diffuse" "spectrum reflectance" "s.spd"'
    np.testing.assert_allclose(read_bsdf(filed, folder=tmp_path).bsdf.reflectance, 0.25, rtol=2e-3)
    wrong = {
        '"spectrum reflectance" [500 1 400 1]': "must ascend",
        '"spectrum reflectance" [500 1 600]': "pairs of wavelength",
        '"spectrum reflectance" "metal-Xx-eta"': "unknown spectrum",
        '"spectrum reflectance" "t.spd"': "no such file",
        '"rgb reflectance" [1 2]': "must hold 3 numbers",
        '"rgb reflectance" [1 2 3]': "in [0, 1]",
        '"blackbody reflectance" [5]': "must be in [100, 1e+06] K",
    }
    for parameter, meant in wrong.items():
        found = messages(f'Material "diffuse" {parameter} Shape "sphere"', folder=tmp_path)
        assert any(meant in message for message in found), found


def test_nothing_more_is_said_of_a_light_that_is_not_covered():
    [text] = read('LightSource "glow" "float x" 1', lenient=True).warnings[:1]
    assert 'light "glow"' in text
    assert not any("float x" in said for said in _said('LightSource "glow" "float x" 1'))


def _said(body):
    scene = read(body, lenient=True)
    return [*scene.warnings, *scene.source.remarks.notes]
