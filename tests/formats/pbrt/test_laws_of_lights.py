"""Lights of pbrt, whatever they are: where they stand, what exposes them, what their power is."""

import math

import numpy as np
import pytest

from alight.formats.pbrt import lights
from alight.formats.pbrt.roughness import alpha_of
from alight.lights.model import LIGHTS
from alight.scene.flatten import flatten
from alight.textures.images import Image
from tests.formats.materialx.test_laws_of_spaces import to_srgb
from tests.formats.pbrt.reading import node, read
from tests.formats.pbrt.test_laws_of_cameras_and_films import listed

LUMINANCE = (0.212671, 0.715160, 0.072169)
#: What some of them need.
GIVEN = {"projection": '"string filename" "p.npy"', "goniometric": '"string filename" "p.npy"'}
PLACED = {"point": ("from",), "spot": ("from", "to"), "distant": ("from", "to")}
FILM = 'Film "{}" "integer xresolution" 8 "integer yresolution" 4 {}\n'


@pytest.fixture
def folder(tmp_path):
    """With a square picture, grey, as profiles are."""
    grey = np.random.default_rng(5).uniform(0.2, 2.0, (8, 8, 1)) * np.ones(3)
    np.save(tmp_path / "p.npy", grey.astype(np.float32))
    return tmp_path


def turned(rng):
    """A random turn, size and shift, as pbrt reads it, and its matrix."""
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    made = np.eye(4)
    made[:3, :3] = q * np.sign(np.linalg.det(q)) * rng.uniform(0.5, 2.0)
    made[:3, 3] = rng.normal(size=3)
    return f"Transform [{listed(made.T)}]\n", made


def row(scene, matrix=None):
    """What kernels know of the only light, after a matrix has moved it."""
    [placed] = flatten(scene).lights
    matrix = np.eye(4) if matrix is None else matrix
    color, numbers = LIGHTS[placed.light.type_name()].place(placed.light, matrix @ placed.to_world)
    return [*color, *numbers]


@pytest.mark.parametrize("kind", lights.COVERED)
def test_what_transforms_the_world_moves_a_light(kind, folder):
    text, matrix = turned(np.random.default_rng(len(kind)))
    points = np.random.default_rng(3).normal(size=(2, 3))
    names = PLACED.get(kind, ())
    pairs = list(zip(names, points, strict=False))
    body = f'LightSource "{kind}" {GIVEN.get(kind, "")} '
    own = body + " ".join(f'"point3 {name}" [{listed(p)}]' for name, p in pairs)
    found = row(read(text + own, folder=folder))
    np.testing.assert_allclose(found, row(read(own, folder=folder), matrix), atol=1e-5)
    moved = [(name, matrix[:3, :3] @ p + matrix[:3, 3]) for name, p in pairs]
    if pairs:
        by_hand = body + " ".join(f'"point3 {name}" [{listed(p)}]' for name, p in moved)
        np.testing.assert_allclose(found, row(read(by_hand, folder=folder)), atol=1e-5)


def amounts(head, kind, folder):
    """How bright the only light is, as a number for each channel."""
    scene = read(f'LightSource "{kind}" {GIVEN.get(kind, "")}', head, folder)
    if scene.environment is not None:
        return np.array(scene.environment.radiance)
    return np.array(row(scene)[:3])


@pytest.mark.parametrize("kind", [*lights.COVERED, "infinite"])
def test_what_exposes_the_film_brightens_every_light(kind, folder):
    rng = np.random.default_rng(len(kind))
    opens, lasts = rng.uniform(0.0, 2.0), rng.uniform(0.2, 0.8)
    iso, scale = rng.uniform(50.0, 800.0), rng.uniform(0.5, 3.0)
    shutter = f'"float shutteropen" {opens} "float shutterclose" {opens + lasts}'
    camera = 'Camera "perspective" {}\n'
    plain = amounts(camera.format("") + FILM.format("rgb", ""), kind, folder)
    given = f'"float iso" {iso} "float scale" {scale}'
    exposed = camera.format(shutter) + FILM.format("rgb", given)
    found = amounts(exposed, kind, folder)
    np.testing.assert_allclose(found / plain, scale * lasts * iso / 100.0, rtol=1e-5)
    # pbrt 3 knows no exposure but the film's scale.
    given = f'"float scale" {scale}'
    if kind not in GIVEN:
        old = amounts(camera.format(shutter) + FILM.format("image", given), kind, folder)
        np.testing.assert_allclose(old / plain, scale, rtol=1e-5)


FOG = 'MakeNamedMedium "fog" "string type" "homogeneous" "rgb Le" [1 2 4] MediumInterface "fog" ""'
#: What shines besides, and how bright it is.
SHINING = {
    'AreaLightSource "diffuse" "rgb L" [1 2 4] Shape "sphere"': lambda s: node(s).light.radiance,
    f'{FOG} Shape "sphere"': lambda s: s.media["fog"].emission,
}


@pytest.mark.parametrize("body", SHINING, ids=["lamp", "fog"])
def test_what_exposes_the_film_brightens_lamps_and_fog(body):
    film = FILM.format("rgb", '"float iso" 250 "float scale" 2')
    scene = read(body, f'Camera "perspective" "float shutterclose" 0.5\n{film}')
    np.testing.assert_allclose(SHINING[body](scene), 2.5 * np.array([1.0, 2.0, 4.0]))


def test_illuminance_is_that_of_the_upper_half_as_pbrt_adds_it_up(tmp_path):
    texels = np.random.default_rng(7).uniform(0.0, 2.0, (16, 16, 3))
    # Nothing like the same above and below.
    texels[:8] *= 0.1
    np.save(tmp_path / "p.npy", texels.astype(np.float32))
    given = '"string filename" "p.npy" "float illuminance" 7'
    item = node(read(f'LightSource "infinite" {given}', folder=tmp_path))
    light, to_world = item.light, item.transform.matrix
    assert isinstance(light.pixels, Image)
    radiance = light.pixels.linear() * np.array(light.scale)
    rows, columns = radiance.shape[:2]
    theta = np.arange(rows)[:, None] * (np.pi / (rows - 1))
    phi = (np.arange(columns) + 0.5) * (2.0 * np.pi / columns)
    up = np.broadcast_to(np.cos(theta), (rows, columns))
    local = np.stack([np.sin(theta) * np.sin(phi), up, -np.sin(theta) * np.cos(phi)], axis=-1)
    z = local @ to_world[2, :3]
    weight = np.sin(theta) * (np.pi / (rows - 1)) * (2.0 * np.pi / columns)
    found = float((weight * np.maximum(z, 0.0) * (radiance @ LUMINANCE)).sum())
    # pbrt adds up the upper half as if its texels filled the whole square: half of what arrives.
    assert 0.5 * found == pytest.approx(7.0, rel=0.02)


def test_roughness_of_pbrt_3_is_its_polynomial():
    for roughness in np.geomspace(1e-3, 1.0, 9):
        x = math.log(roughness)
        wanted = np.polyval([0.000640711, 0.0171201, 0.1734, 0.819955, 1.62142], x)
        assert alpha_of(roughness, True) == pytest.approx(wanted)
        assert alpha_of(roughness, False) == pytest.approx(math.sqrt(roughness))


@pytest.mark.parametrize(
    ("space", "primaries"), [("srgb", "rec709"), ("rec2020", "rec2020"), ("dci-p3", "p3"),
                             ("aces2065-1", "ap0")],
)  # fmt: skip
def test_colours_are_those_of_the_space_that_is_named(space, primaries):
    rgb = np.random.default_rng(len(space)).uniform(0.4, 0.6, 3)
    body = f'ColorSpace "{space}" LightSource "point" "rgb I" [{listed(rgb)}]'
    wanted = to_srgb(primaries) @ rgb
    np.testing.assert_allclose(row(read(body))[:3], np.maximum(wanted, 0.0), atol=2e-3)
