"""Caustics by manifold sampling: the same light as paths find, and what is known by pen and paper."""

from __future__ import annotations

import numpy as np
import pytest

import alight
from alight.core.fresnel import fresnel_dielectric
from alight.laws.statistics import LARGEST_Z

HEAD = """
alight: 1
camera: {type: pinhole, fov: 40, transform: {look_at: {origin: %s, target: [0, 0, 0]}}}
film: {size: [16, 16], filter: {type: box}}
sampler: {type: independent}
integrator: {type: path, max_depth: %d, caustics: %s}
bsdfs:
  floor: {type: diffuse, reflectance: 0.7}
  glass: {type: dielectric, int_ior: 1.5, attenuation_color: [0.5, 0.8, 1], attenuation_distance: 1}
  mirror: {type: mirror, reflectance: 0.8}
  plastic: {type: plastic}
  black: {type: diffuse, reflectance: 0}
nodes:
  floor: {shape: rectangle, bsdf: plastic, transform: [{scale: 1.5}, {rotate: {axis: x, angle: -90}}]}
"""

#: A ball of glass, one of metal, and two lamps of different shapes.
THINGS = """
  glass: {shape: {type: sphere, radius: 0.25}, bsdf: glass, transform: {translate: [0.3, 0.3, 0]}}
  mirror: {shape: {type: sphere, radius: 0.2}, bsdf: mirror, transform: {translate: [-0.4, 0.2, 0]}}
  table: {shape: cube, bsdf: floor, transform: [{scale: 0.1}, {translate: [-0.1, 0.1, 0.5]}]}
  lamp:
    shape: {type: sphere, radius: 0.1}
    bsdf: black
    light: {type: area, radiance: [60, 50, 40]}
    transform: {translate: [0.1, 1.2, 0.1]}
  panel:
    shape: rectangle
    bsdf: black
    light: {type: area, radiance: [10, 20, 60]}
    transform: [{scale: 0.15}, {rotate: {axis: x, angle: 90}}, {translate: [-0.6, 1, 0.3]}]
"""


def scene_of(tmp_path, nodes, depth, caustics, origin=(0.0, 1.2, 3.2)):
    path = tmp_path / "scene.yaml"
    path.write_text(HEAD % (list(origin), depth, caustics) + nodes)
    return alight.load(path)


def blocks(film, size=4):
    """Means of blocks of pixels, and their standard errors."""
    h, w, _ = film.mean.shape
    shape = (h // size, size, w // size, size, 3)
    errors = (film.standard_error.astype(float) ** 2).reshape(shape).sum((1, 3))
    return film.mean.astype(float).reshape(shape).mean((1, 3)), np.sqrt(errors) / size**2


def test_caustics_are_those_that_paths_find(tmp_path):
    (a, error_a), (b, error_b) = (
        blocks(alight.render(scene_of(tmp_path, THINGS, 6, way), spp=spp, seed=spp))
        for way, spp in (("manifold", 40_000), ("paths", 80_000))
    )
    error = np.hypot(error_a, error_b)
    seen = error > 0.0
    z = (a - b)[seen] / error[seen]
    assert np.abs(z).max() < LARGEST_Z, z
    # All blocks together: their errors are independent.
    total = (a - b).sum(axis=(0, 1)) / np.sqrt((error**2).sum(axis=(0, 1)))
    assert np.abs(total).max() < LARGEST_Z, total
    # It would see 2 % of all light, and so a fifth of that which comes over glass and mirrors.
    noise = np.sqrt((error**2).sum(axis=(0, 1))) / b.sum(axis=(0, 1))
    assert noise.max() < 0.004, noise


WATER, ABOVE, RADIUS = 1.33, 1.0, 0.004
POOL = f"""
  water:
    shape: rectangle
    bsdf: {{type: dielectric, int_ior: {WATER}}}
    transform: [{{scale: 9}}, {{rotate: {{axis: x, angle: -90}}}}, {{translate: [0, 1, 0]}}]
  white: {{shape: rectangle, bsdf: floor, transform: [{{scale: 1.5}}, {{rotate: {{axis: x, angle: -90}}}}, {{translate: [0, 0.001, 0]}}]}}
  lamp:
    shape: {{type: sphere, radius: {RADIUS}}}
    bsdf: black
    light: {{type: area, radiance: 1e5}}
    transform: {{translate: [0, {1.001 + ABOVE - 0.001}, 0]}}
"""


def irradiance_under_water(x, depth):
    """Of a small ball of radiance 1e5, at the distance x from the foot of its height.

    The flux between two cones around the vertical, I 2 pi sin t dt (1 - F), falls onto a ring.
    """
    t = np.linspace(0.0, 1.2, 20_001)[1:]
    inside = np.arcsin(np.sin(t) / WATER)
    place = ABOVE * np.tan(t) + depth * np.tan(inside)
    passed = 1.0 - np.array(
        [fresnel_dielectric(np.float32(c), np.float32(WATER))[0] for c in np.cos(t)]
    )
    intensity = 1e5 * np.pi * RADIUS**2
    ring = intensity * passed * np.sin(t) / (place * np.gradient(place, t))
    return np.interp(x, place, ring)


def test_a_small_lamp_lights_the_ground_of_a_pool(tmp_path):
    origin = (0.0, 0.8, 0.4)
    scene = scene_of(tmp_path, POOL, 3, "manifold", origin)
    film = alight.render(scene, spp=2048, seed=3)
    # Where the middles of the pixels look.
    eye, n = np.array(origin), 16
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up, tangent = np.cross(right, forward), np.tan(np.radians(20.0))
    y, x = np.meshgrid(*[(np.arange(4 * n) + 0.5) / (2 * n) - 1.0] * 2, indexing="ij")
    d = forward + tangent * (x[..., None] * right - y[..., None] * up)
    p = eye + d * ((0.001 - eye[1]) / d[..., 1])[..., None]
    expected = 0.7 / np.pi * irradiance_under_water(np.hypot(p[..., 0], p[..., 2]), 0.999)
    expected = expected.reshape(n, 4, n, 4).mean((1, 3))
    a, error = blocks(film)
    expected = expected.reshape(4, 4, 4, 4).mean((1, 3))
    z = (a[..., 1] - expected) / error[..., 1]
    assert np.abs(z).max() < LARGEST_Z, z
    total = (a[..., 1] - expected).sum() / np.sqrt((error[..., 1] ** 2).sum())
    noise = np.sqrt((error[..., 1] ** 2).sum()) / expected.sum()
    assert abs(total) < LARGEST_Z, total
    assert noise < 0.002, noise


def test_neither_threads_nor_parts_change_a_bit(tmp_path):
    scene = scene_of(tmp_path, THINGS, 6, "manifold")
    whole = alight.render(scene, spp=32, threads=1)
    shared = alight.render(scene, spp=32, threads=2, spp_per_pass=8)
    np.testing.assert_array_equal(whole.mean, shared.mean)
    first, second = (alight.render(scene, spp=16, first_sample=at) for at in (0, 16))
    np.testing.assert_array_equal(whole.mean, alight.Film.merge(second, first).mean)
