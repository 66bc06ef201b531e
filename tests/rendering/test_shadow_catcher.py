"""Shadows on the ground, against closed forms, and alpha with its error."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import AlightError, SceneError
from alight.films import Film
from alight.formats import loads
from alight.integrators.walk import make_settings
from alight.laws.statistics import LARGEST_Z
from alight.lights.ground import SHADOW
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten

#: A disk of radius 1, one metre above the ground, which a grain of sand beside the picture lies on;
#: seen from between the two, 4 m across.
DISK = """
alight: 1
film: {size: [24, 24], filter: box}
integrator: path
camera:
  type: orthographic
  height: 4
  transform: {look_at: {origin: [0, 0.9, 0], target: [0, 0, 0], up: [0, 0, -1]}}
nodes:
  disk:
    shape: disk
    transform: [{rotate: {axis: x, angle: -90}}, {translate: [0, 1, 0]}]
    bsdf: {type: diffuse, reflectance: 0.5}
  grain: {shape: {type: sphere, radius: 0.001}, transform: {translate: [50, 0.001, 0]}}
"""
#: The same with a hole in every point, which may be closed.
SIEVE = DISK.replace(
    "{type: diffuse, reflectance: 0.5}",
    "{type: mask, opacity: %g, bsdf: {type: diffuse, reflectance: 0.5}}",
)
DOME = "environment: {type: constant, radiance: [2, 1, 0.5]}\n"
LAMP = "  lamp: {light: {type: point, intensity: 5}, transform: {translate: [0, 3, 0]}}\n"
OTHER = """  %s:
    light: {type: spot, intensity: 5, cutoff_angle: 90, beam_width: 90}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [%g, 0.5, 0]}]
"""
MAP = "environment: {type: environment, %s pixels: [[[1,1,1],[3,3,3]],[[1,1,1],[3,3,3]]]}\n"
Y = 0.212671 * 2 + 0.715160 + 0.072169 * 0.5

MOVING = """%s:
    transform: {keyframes: [{time: 0, translate: [0, 3, 0]}, {time: 1, translate: [1, 3, 0]}]}
"""
LAMP_THAT_MOVES = MOVING % "  lamp" + "    light: {type: point}\n"


def caught(text, spp=256, **options):
    return alight.render(loads(text), spp=spp, background="shadow", seed=3, **options)


def over_pixels(function, n=24, inner=8):
    """Means of a function of (x, z) over the pixels of the picture."""
    x = (np.arange(n * inner) + 0.5) / (n * inner) * 4.0 - 2.0
    values = function(*np.meshgrid(x, x))
    return values.reshape(n, inner, n, inner).mean(axis=(1, 3))


def of_the_dome(x, z):
    """Form factor of a parallel disk, radius 1 at height 1 (Howell, A Catalog, B-13)."""
    a = x * x + z * z
    return 0.5 * (1.0 - a / np.sqrt((a + 2.0) ** 2 - 4.0 * a))


def irradiance(x, z, height):
    """On the ground, of a lamp of 5 W/sr above the origin."""
    return 5.0 * height / (x * x + height * height + z * z) ** 1.5


def demand_alpha(film, expected):
    """Each pixel within its own error bar, and their sum within that of the sum."""
    error = np.maximum(film.alpha_error, 1e-6)
    z = (film.alpha - expected) / error
    # Stratified samples: at most as spread as independent ones, for which the error is meant.
    assert np.mean(z**2) < 1.2
    assert abs((film.alpha - expected).sum()) < LARGEST_Z * np.sqrt((error**2).sum())
    return z


def test_the_shadow_of_a_disk_under_a_uniform_dome():
    film = caught(DOME + SIEVE % 1)
    demand_alpha(film, over_pixels(of_the_dome))
    assert film.alpha[12, 12] > 0.45 and film.alpha[0, 0] < 0.12


def test_the_shadow_of_a_disk_under_a_lamp_has_an_edge():
    film = caught(DISK + LAMP, spp=4)
    r = over_pixels(np.hypot)
    # 3 m above the ground, 2 m above the disk.
    assert np.abs(film.alpha[r < 1.5 - 0.15] - 1.0).max() < 1e-6
    assert (film.alpha[r > 1.5 + 0.15] == 0.0).all()
    assert film.alpha_error[np.abs(r - 1.5) > 0.15].max() < 1e-3


def test_lights_of_all_kinds_share_the_ground():
    """A lamp above the disk, two below it that are never hidden, and the dome."""

    def expected(x, z):
        above = irradiance(x, z, 3.0) * (np.hypot(x, z) < 1.5)
        whole = np.pi * Y + irradiance(x, z, 3.0)
        whole += irradiance(x + 2.5, z, 0.5) + irradiance(x - 2.5, z, 0.5)
        return (np.pi * Y * of_the_dome(x, z) + above) / whole

    lamps = LAMP + OTHER % ("left", -2.5) + OTHER % ("right", 2.5)
    film = caught("sampler: independent\n" + DOME + DISK.strip("\n") + "\n" + lamps)
    z = demand_alpha(film, over_pixels(expected))
    # The error is that of independent samples, which these are.
    assert np.mean(z**2) > 0.8


def test_holes_let_light_through():
    film = caught(DOME + SIEVE % 0.4)
    demand_alpha(film, 0.4 * over_pixels(of_the_dome))


def test_the_light_of_surroundings_is_known():
    """A map with a dark and a bright side, compensated or not, and a sun that is low."""
    uneven = [MAP % word for word in ("", "compensation: false,")]
    for text, expected in ((DOME, np.pi * Y), *((text, 2.0 * np.pi) for text in uneven)):
        compiled = compile_scene(flatten(loads(text + DISK)), aovs=(SHADOW,))
        assert compiled.ground.height == pytest.approx(0.0, abs=1e-8)
        assert compiled.ground.sky == pytest.approx(expected, rel=1e-3)
    moving = MOVING % "  ball" + "    shape: {type: sphere, radius: 0.1}\n"
    compiled = compile_scene(flatten(loads(DOME + DISK + moving)), aovs=(SHADOW,))
    assert compiled.ground.sky == pytest.approx(np.pi * Y, rel=1e-3)
    sun = "environment: {type: sun, sun_direction: [1, 1, 0], diameter: %s}\n"
    small, large = (
        compile_scene(flatten(loads(sun % size + DISK)), aovs=(SHADOW,)).ground.sky
        for size in (0.5, 20)
    )
    # The mean of the cosine over a cap of half angle a is that of its middle times (1 + cos a) / 2.
    share = 0.5 * (1.0 + np.cos(np.radians(10.0)))
    assert large / small == pytest.approx(share, rel=1e-3)


def test_the_picture_is_that_of_a_transparent_background():
    text = DOME + (SIEVE % 1).replace("origin: [0, 0.9, 0]", "origin: [0, 3, 0]")
    film = caught(text, 8)
    plain = alight.render(loads(text), spp=8, background="transparent", seed=3)
    np.testing.assert_array_equal(film.sums, plain.sums)
    np.testing.assert_array_equal(film.aov("alpha")[..., 0], plain.alpha)
    assert (film.alpha >= plain.alpha).all() and (film.alpha > plain.alpha).any()
    # A pixel is covered by the disk, or its ray meets the ground.
    assert film.alpha.max() <= 1.0 + 1e-6
    merged = Film.merge(caught(text, 4), caught(text, 4, first_sample=4))
    np.testing.assert_array_equal(merged.aov_sums[SHADOW], film.aov_sums[SHADOW])


def test_edges_have_the_error_of_a_coin():
    """Half of a pixel is covered by samples that know nothing of each other."""
    text = DISK.replace("film: {size: [24, 24]", "film: {size: [1, 1]")
    text = text.replace("0.9, 0]", "3, 0]").replace("height: 4", "height: 2.5")
    text = "sampler: independent" + text + LAMP.replace("3, 0]", "200, 0]")
    film = caught(text, 512)
    share = np.pi / 2.5**2
    error = np.sqrt(share * (1.0 - share) / 511)
    assert film.alpha_error[0, 0] == pytest.approx(error, rel=0.2)
    assert abs(film.alpha[0, 0] - share) < LARGEST_Z * error


def test_the_twin_catches_the_same():
    scene = compile_scene(flatten(loads(DOME + DISK + LAMP)), aovs=(SHADOW,), structure="list")
    settings = make_settings(scene.integrator, seed=1, replicates=4)
    ranges = np.array([[[0, 2]]], np.int64)
    kernels, tile = (make_kernels(scene, compiled=way) for way in (True, False)), Tile(8, 8, 12, 12)
    machine, twin = (render_tile(one, scene, settings, tile, ranges)[0] for one in kernels)
    difference = machine.aovs[SHADOW] - twin.aovs[SHADOW]
    assert np.abs(difference[..., 0] + difference[..., 1] * 2.0**-40).max() < 1e-3 * 2**8
    assert machine.aovs[SHADOW].any()


@pytest.mark.parametrize(
    ("change", "place", "said"),
    [
        (("disk:\n", "disk:\n    light: {type: area, radiance: 1}\n"), "nodes.disk", "shines"),
        (("  disk:\n", LAMP_THAT_MOVES + "  disk:\n"), "nodes.lamp", "moves"),
        (("shape: disk", "shape: plane"), "", ""),
        (("integrator: path", "integrator: ambient_occlusion"), "background", "path or direct"),
    ],
)  # fmt: skip
def test_where_no_shadow_is_known(change, place, said):
    text = (DOME + DISK).replace(*change)
    if not said:
        grain = text.index("  grain")
        text, said = text[:grain], "finite shapes"
    with pytest.raises(AlightError, match=said):
        caught(text, 1)


def test_media_are_refused_as_a_layer_too():
    text = (DOME + DISK).replace("integrator: path", "integrator: volpath")
    text += "media: {fog: {type: homogeneous, sigma_s: 0.1}}\n"
    text = text.replace("camera:\n", "camera:\n  medium: fog\n")
    with pytest.raises(SceneError, match="empty space"):
        alight.render(loads(text), spp=1, aovs=SHADOW)
