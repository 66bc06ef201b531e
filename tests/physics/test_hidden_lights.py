"""`hide_emitters`: the camera sees through lights, and nothing else changes."""

import math

import numpy as np
import pytest

from alight.formats import loads
from tests.twin import picture_of

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


def render(kind, hidden, spp=8):
    """A channel of the picture, in the twin."""
    scene = loads(SCENE.format(kind=kind, hidden=str(hidden).lower()))
    return picture_of(scene, spp)[..., 0]


@pytest.mark.parametrize(("kind", "spp"), [("path", 8), ("direct", 8), ("volpath", 32)])
def test_the_camera_sees_what_is_behind(kind, spp):
    image = render(kind, True, spp)
    # The wall behind the lamp: sun and nearly half a sky, with neither the lamp's light (it faces
    # the camera) nor its shadow, which falls to the side. The lamp hides a small part of the sky.
    sun = 0.6 / math.pi * 3 * math.cos(math.radians(45))
    seen = image[WALL, 10:14]
    expected = sun + 0.6 * 0.5
    # The lamp's own light would be seven.
    assert (seen < 1.5 * expected).all()
    assert seen.mean() == pytest.approx(expected, rel=0.02)
    assert (image[SKY] == 0.0).all()


def test_what_lights_light_stays_the_same():
    """Away from what is hidden both pictures have the very same samples."""
    shown, hidden = render("path", False), render("path", True)
    lamp = shown > 2.0
    assert 4 < lamp[WALL].sum() < 40
    sides = np.r_[0:7, 17:24]
    np.testing.assert_array_equal(shown[WALL][:, sides], hidden[WALL][:, sides])
    assert shown[SKY] == pytest.approx(0.5)
