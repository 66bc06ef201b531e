"""`hide_emitters`: the camera sees through lights, and nothing else changes."""

import math

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats import loads
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.twin import film_of, picture_of

SCENE = """
alight: 1
camera: {{fov: 40, transform: {{look_at: {{origin: [0, 0, 2], target: [0, 0, 0]}}}}}}
film: {{size: [24, 24]}}
sampler: sobol
integrator: {{type: {kind}, hide_emitters: {hidden}}}
environment: {{type: constant, radiance: 0.5}}
nodes:
  sun:
    light: {{type: directional, irradiance: 3}}
    transform: {{look_at: {{origin: [0, 0, 0], target: [1, 0, 1]}}}}
  wall:
    shape: rectangle
    transform: [{{scale: [3, 0.4, 1]}}, {{translate: [0, 0, -1]}}]
    bsdf: {{type: diffuse, reflectance: 0.6}}
  lamp:
    shape: rectangle
    transform: [{{scale: 0.15}}, {{rotate: {{axis: x, angle: 10}}}}]
    light: {{type: area, radiance: 7}}
"""
#: Rows of pixels that see the wall alone, with or without the lamp before it, and the sky alone.
WALL, SKY = slice(9, 15), slice(0, 3)


REPLICATES = 16


def render(kind, hidden):
    """A channel of the picture, in the twin."""
    scene = loads(SCENE.format(kind=kind, hidden=str(hidden).lower()))
    return picture_of(scene, 8)[..., 0]


def means(scene, tile, spp):
    """Means of the replicates, (pixels, replicates), in a channel."""
    film = film_of(scene, spp, replicates=REPLICATES, tile=tile)
    sums = fixed_point.to_float(film.sums)[..., 0] * (REPLICATES / spp)
    return sums.reshape(-1, REPLICATES)


@pytest.mark.parametrize("kind", ["path", "direct", "volpath"])
def test_the_camera_sees_what_is_behind(kind):
    scene = loads(SCENE.format(kind=kind, hidden="true"))
    compiled = compile_scene(flatten(scene), structure="list")
    # The wall behind the lamp: sun and nearly half a sky, with neither the lamp's light (it faces
    # the camera) nor its shadow, which falls to the side. The lamp hides a small part of the sky.
    sun = 0.6 / math.pi * 3 * math.cos(math.radians(45))
    expected = sun + 0.6 * 0.5
    seen = means(compiled, Tile(10, WALL.start, 14, WALL.stop), 128)
    error = seen.std(axis=1, ddof=1) / math.sqrt(REPLICATES)
    assert error.max() < 0.08 * expected
    # Student's t with 15 degrees of freedom: by chance in one of 1000 runs of 24 pixels.
    assert (np.abs(seen.mean(axis=1) - expected) < 5.7 * error + 0.02 * expected).all()
    assert seen.mean() == pytest.approx(expected, rel=0.02)
    assert (means(compiled, Tile(0, SKY.start, 24, SKY.stop), REPLICATES) == 0.0).all()


def test_what_lights_light_stays_the_same():
    """Away from what is hidden both pictures have the very same samples."""
    shown, hidden = render("path", False), render("path", True)
    lamp = shown > 2.0
    assert 4 < lamp[WALL].sum() < 40
    sides = np.r_[0:7, 17:24]
    np.testing.assert_array_equal(shown[WALL][:, sides], hidden[WALL][:, sides])
    assert shown[SKY] == pytest.approx(0.5)


@pytest.mark.parametrize("kind", ["path", "volpath"])
def test_hidden_lights_light_what_is_beside_them(kind):
    turned = SCENE.replace("angle: 10", "angle: 170").replace("radiance: 7", "radiance: 70")
    shown, hidden = (
        picture_of(loads(turned.format(kind=kind, hidden=word)), 8)[WALL][..., 0]
        for word in ("false", "true")
    )
    sides = np.r_[0:7, 17:24]
    np.testing.assert_array_equal(shown[:, sides], hidden[:, sides])
    # Sun and sky alone give 0.65.
    assert hidden[:, sides].mean() > 0.9
