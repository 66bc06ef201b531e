"""Scenes with one light only, compiled: its row is the same for all lanes, what it gives is not."""

import numpy as np

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.scene.flatten import flatten

DIRECTIONAL = """
alight: 1
camera: {fov: 30, transform: [{look_at: {origin: [0, 0, 5], target: [0, 0, 0]}}]}
film: {size: [8, 8]}
integrator: path
nodes:
  sun:
    transform: [{rotate: {axis: x, angle: 180}}, {rotate: {axis: y, angle: 60}}]
    light: {type: directional, irradiance: [1, 2, 4]}
  wall:
    shape: {type: mesh, vertices: [[-9, -9, 0], [9, -9, 0], [0, 9, 0]], faces: [[0, 1, 2]]}
    bsdf: {type: diffuse, reflectance: 0.5}
"""

# The lamp is bright on one half of its longitudes and dark on the other, so that in its middle a
# surface that faces the poles receives their mean from all around.
TEXTURED = """
alight: 1
camera: {fov: 10, transform: [{look_at: {origin: [0, 0, 0.1], target: [0, 0, 0], up: [0, 1, 0]}}]}
film: {size: [16, 16]}
integrator: {type: path, max_depth: 2}
nodes:
  lamp:
    shape: {type: sphere, radius: 100, flip_normals: true}
    light:
      type: area
      radiance: {type: checkerboard, color0: [1, 0.8, 0.5], color1: [0, 0.4, 0.1], scale: [2, 1]}
    bsdf: {type: diffuse, reflectance: 0}
  spot:
    shape: {type: disk}
    bsdf: {type: diffuse, reflectance: 0.5}
"""


def picture(text, spp):
    film = alight.render(loads(text), spp=spp)
    assert film.invalid == 0
    return film.image.astype(np.float64)


def test_directional_light_on_a_list_of_triangles():
    assert "list triangles" in compile_scene(flatten(loads(DIRECTIONAL))).program.accel
    # rho / pi E cos(60 degrees), without any noise.
    expected = 0.5 / np.pi * 0.5 * np.broadcast_to([1.0, 2.0, 4.0], (8, 8, 3))
    np.testing.assert_allclose(picture(DIRECTIONAL, 4), expected, rtol=1e-5)


def test_textured_area_light():
    pixels = picture(TEXTURED, 256).reshape(-1, 3)
    mean, error = pixels.mean(0), pixels.std(0, ddof=1) / np.sqrt(len(pixels))
    expected = 0.5 * np.array([0.5, 0.6, 0.3])
    assert np.all(np.abs(mean - expected) < 4.5 * error + 1e-4 * expected), (mean, error)
    # An error of 1 % would be seen.
    assert np.all(4.5 * error < 0.005 * expected)
