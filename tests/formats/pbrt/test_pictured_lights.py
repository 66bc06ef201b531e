"""Projectors, lamps with a profile, shining pictures and portals, against pbrt's own formulas."""

import numpy as np
import pytest

from alight.formats.pbrt.octahedral import to_sphere
from alight.formats.pbrt.transforms import rotation, scaling, translation
from alight.lights.area import mean_color
from alight.lights.model import LIGHTS
from alight.scene.flatten import flatten
from tests.formats.pbrt.reading import HEAD, messages, read, read_old
from tests.lights.test_light_sampling import sample
from tests.shapes.tracing import PROGRAM, World, rows

PLACED = "Translate 1 2 3 Rotate 40 1 2 3 Scale 2 2 2\n"
MATRIX = translation(1, 2, 3) @ rotation(40, np.array([1.0, 2.0, 3.0])) @ scaling(2, 2, 2)
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])


def picture(folder, *shape):
    texels = np.random.default_rng(7).random(shape, np.float32) + 0.1
    np.save(folder / "picture.npy", texels)
    return texels


def blocks(folder, *shape):
    """A picture of blocks of 16 x 16 texels: in their middles no interpolation is seen."""
    texels = np.random.default_rng(7).random(shape, np.float32) + 0.1
    np.save(folder / "picture.npy", np.kron(texels, np.ones((16, 16, 1), np.float32)))
    return texels


def sent(scene, w):
    """Intensity of the only light, W/sr, along w of the space that its directive stands in."""
    [placed] = flatten(scene).lights
    towards = MATRIX[:3, :3] @ w
    p = MATRIX[:3, 3] + 2.0 * towards / np.linalg.norm(towards)
    program = PROGRAM._replace(lights=(placed.light.type_name(),))
    return 4.0 * rows(sample(World(lights=[placed]), p, 16, program=program).radiance)[:, 0]


def power_of(scene):
    """Lumens of the only light, of white for pbrt's one."""
    [placed] = flatten(scene).lights
    mean = LIGHTS[placed.light.type_name()].mean_color(placed.light)
    return 4.0 * np.pi * float(np.array(mean) @ LUMINANCE)


def on_film(uv, width, height):
    """pbrt's window, at distance 1 and for a field of 90 degrees across the shorter side."""
    aspect = width / height
    half = [aspect, 1.0] if aspect > 1.0 else [1.0, 1.0 / aspect]
    return (2.0 * np.array(uv) - 1.0) * half


@pytest.mark.parametrize("size", [(3, 2), (2, 3)])
@pytest.mark.parametrize("old", [False, True])
def test_projectors_show_each_texel_where_pbrt_does(tmp_path, size, old):
    width, height = size
    texels = picture(tmp_path, height, width, 3)
    fov, name = 50.0, "mapname" if old else "filename"
    given = f'"float fov" {fov} "string {name}" "picture.npy" "float scale" 3'
    scene = (read_old if old else read)(
        f'{PLACED}LightSource "projection" {given}', folder=tmp_path
    )
    for row in range(height):
        for column in range(width):
            x, y = on_film([(column + 0.5) / width, (row + 0.5) / height], width, height)
            tangent = np.tan(np.radians(0.5 * fov))
            # pbrt 4 turns over the axis y of its light, so that pictures stand upright.
            w = np.array([x * tangent, y * tangent * (1.0 if old else -1.0), 1.0])
            np.testing.assert_allclose(sent(scene, w), 3.0 * texels[row, column], rtol=1e-4)
    edge = on_film([1.02, 0.5], width, height)[0] * np.tan(np.radians(0.5 * fov))
    assert not sent(scene, np.array([edge, 0.0, 1.0])).any()
    assert not sent(scene, np.array([0.0, 0.0, -1.0])).any()


@pytest.mark.parametrize("kind", ["projection", "goniometric"])
def test_power_of_a_picture(tmp_path, kind):
    blocks(tmp_path, 4, 4, 3)
    given = '"string filename" "picture.npy" "float power" 20 "float scale" 2'
    assert power_of(read(f'LightSource "{kind}" {given}', folder=tmp_path)) == pytest.approx(
        40.0, 2e-4
    )
    # As for all other lights, before the film's exposure.
    head = HEAD.replace('"rgb"', '"rgb" "float iso" 200')
    bright = read(f'LightSource "{kind}" {given}', head, folder=tmp_path)
    assert power_of(bright) == pytest.approx(80.0, 2e-4)


def test_profiles_of_pbrt_4_are_octahedra_around_y(tmp_path):
    texels = blocks(tmp_path, 4, 4, 1)
    given = '"string filename" "picture.npy" "rgb I" [1 2 3]'
    scene = read(f'{PLACED}LightSource "goniometric" {given}', folder=tmp_path)
    for row in range(4):
        for column in range(4):
            x, z, y = to_sphere(np.array([(column + 0.5) / 4, (row + 0.5) / 4]))
            expected = texels[row, column] * np.array([1.0, 2.0, 3.0])
            np.testing.assert_allclose(sent(scene, np.array([x, y, z])), expected, rtol=1e-4)


def test_profiles_of_pbrt_3_are_maps_around_y(tmp_path):
    texels = blocks(tmp_path, 3, 6, 1)
    given = '"string mapname" "picture.npy" "rgb I" [1 2 3]'
    scene = read_old(f'{PLACED}LightSource "goniometric" {given}', folder=tmp_path)
    for row in range(3):
        for column in range(6):
            theta, phi = (row + 0.5) * np.pi / 3, (column + 0.5) * np.pi / 3
            w = [np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)]
            expected = texels[row, column] * np.array([1.0, 2.0, 3.0])
            np.testing.assert_allclose(sent(scene, np.array(w)), expected, rtol=1e-4)


def test_profile_without_a_picture_is_a_point():
    scene = read(f'{PLACED}LightSource "goniometric" "float power" 10')
    np.testing.assert_allclose(sent(scene, np.array([1.0, 2.0, 3.0])), 10.0 / (4.0 * np.pi), 1e-5)


QUAD = '"point3 P" [0 0 0  3 0 0  3 2 0  0 2 0] "integer indices" [0 1 2  0 2 3]'
UV = '"point2 uv" [0 0  1 0  1 1  0 1]'


def test_shapes_show_their_picture(tmp_path):
    texels = picture(tmp_path, 2, 4, 3)
    given = '"string filename" "picture.npy" "float scale" 3'
    body = f'AreaLightSource "diffuse" {given}\nShape "trianglemesh" {QUAD} {UV}'
    [shape] = flatten(read(body, folder=tmp_path)).shapes
    factor, image = shape.light.radiance.b, shape.light.radiance.a
    assert (factor, image.wrap) == ((3.0, 3.0, 3.0), "clamp")
    # The first row is at the top, v = 1.
    np.testing.assert_array_equal(image.pixels.texels, texels)
    power = f'AreaLightSource "diffuse" {given} "float power" 60 "bool twosided" true'
    shapes = flatten(read(f'{power}\nShape "trianglemesh" {QUAD} {UV}', folder=tmp_path)).shapes
    assert len(shapes) == 2
    for shape in shapes:
        luminance = float(np.array(mean_color(shape.light)) @ LUMINANCE)
        # pbrt multiplies the power by the scale.
        assert 2.0 * np.pi * 6.0 * luminance == pytest.approx(3.0 * 60.0)


def test_shapes_without_coordinates_get_those_of_pbrt(tmp_path):
    picture(tmp_path, 2, 4, 3)
    body = 'AreaLightSource "diffuse" "string filename" "picture.npy"\n'
    body += f'Shape "trianglemesh" {QUAD.replace("[0 1 2  0 2 3]", "[0 1 2]")}'
    [geometry] = flatten(read(body, folder=tmp_path)).geometries
    np.testing.assert_array_equal(geometry.uvs, [[0, 0], [1, 0], [1, 1]])


def test_portals_join_the_surroundings():
    """They stand in the world, wherever the light's picture is turned to."""
    corners = '"point3 portal" [0 0 0  2 0 0  2 0 1  0 0 1]'
    scene = read(f'{PLACED}LightSource "infinite" "rgb L" [1 2 3] {corners}')
    assert scene.environment.radiance == (1.0, 2.0, 3.0)
    [node] = scene.nodes.values()
    assert node.light.type_name() == "portal"
    own = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    there = [[0, 0, 0], [2, 0, 0], [2, 0, 1], [0, 0, 1]]
    found = [node.transform.apply_point(point) for point in own]
    np.testing.assert_allclose(found, there, atol=1e-12)
    assert any("not come through its portal" in text for text in scene.warnings)


def test_what_is_wrong_with_pictures_and_portals(tmp_path):
    picture(tmp_path, 2, 4, 3)
    named = '"string filename" "picture.npy"'
    wrong = {
        'LightSource "projection"': 'needs "string filename"',
        'LightSource "projection" "string filename" "none.png"': "no such file",
        f'LightSource "projection" {named} "float fov" 180': "must be in (0, 180) degrees",
        f'LightSource "goniometric" {named}': "must be a square",
        'LightSource "goniometric" "string filename" "none.png"': "no such file",
        'AreaLightSource "diffuse" "string filename" "none.png" Shape "sphere"': "no such file",
        'LightSource "infinite" "point3 portal" [0 0 0  1 0 0  1 1 0]': "4 corners, got 3",
        'LightSource "infinite" "point3 portal" [0 0 0  1 0 0  2 1 0  0 1 0]': "a rectangle",
        'LightSource "infinite" "point3 portal" [0 0 0  1 0 0  1 0 0  0 0 0]': "a rectangle",
    }
    for body, meant in wrong.items():
        found = messages(body, folder=tmp_path)
        assert any(meant in message for message in found), (body, found)


def test_projections_that_are_too_wide_are_told_of(tmp_path):
    picture(tmp_path, 2, 4, 3)
    body = 'LightSource "projection" "string filename" "picture.npy" "float fov" 179.5'
    scene = read(body, folder=tmp_path)
    [lamp] = scene.nodes.values()
    assert lamp.light.fov == 179.0
    assert any("degrees wide: became 179" in text for text in scene.warnings)
