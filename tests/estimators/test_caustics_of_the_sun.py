"""Caustics of what is around the scene: a sun behind glass and water, and the sun of a picture."""

from __future__ import annotations

import numpy as np

import alight
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from alight.lights import environment
from alight.lights.bright_disk import brightest_disk
from alight.lights.daylight import solid_angle
from alight.lights.environment import Environment
from alight.lights.sun import Sun
from alight.scene.builtin import pictures
from alight.textures.images import Image
from tests.estimators.test_caustics import WATER, blocks, reflected

HEAD = """
alight: 1
camera: {type: pinhole, fov: 40, transform: {look_at: {origin: %s, target: [0, 0, 0]}}}
film: {size: [16, 16], filter: {type: box}}
sampler: {type: independent}
integrator: {type: path, max_depth: %d, caustics: manifold}
bsdfs:
  floor: {type: diffuse, reflectance: 0.7}
  glass:
    {type: dielectric, int_ior: 1.5, attenuation_color: [0.5, 0.8, 1], attenuation_distance: 0.1}
  water: {type: dielectric, int_ior: 1.33}
  mirror: {type: mirror, reflectance: 0.8}
  black: {type: diffuse, reflectance: 0}
"""
FLOOR = """
nodes:
  floor:
    shape: rectangle
    bsdf: floor
    transform: [{scale: 1.5}, {rotate: {axis: x, angle: -90}}]
"""
TO_SUN = (0.5, 0.8, 0.2)
UNDER_WATER = """
environment: {type: sun, sun_direction: [0.5, 0.8, 0.2]}
""" + FLOOR + """
  water:
    shape: rectangle
    bsdf: water
    transform: [{scale: 9}, {rotate: {axis: x, angle: -90}}, {translate: [0, 1, 0]}]
"""  # fmt: skip


def test_the_sun_lights_the_ground_under_water():
    text = HEAD % ([0.0, 0.8, 0.4], 3) + UNDER_WATER
    film = alight.render(loads(text), spp=1024, seed=3)
    a, error = blocks(film)
    cosine = TO_SUN[1] / np.linalg.norm(TO_SUN)
    # As large as the disk is, the height of its middle is that of the mean of its cosines.
    passed = 1.0 - reflected(cosine, WATER)
    sun = np.array(Sun(sun_direction=TO_SUN).of_the_sun) * solid_angle(0.533)
    expected = 0.7 / np.pi * cosine * passed * sun
    z = (a - expected) / error
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a - expected).sum(axis=(0, 1)), np.sqrt((error**2).sum(axis=(0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), a.mean(axis=(0, 1)) / expected
    assert (noise < 0.003 * 16 * expected).all(), noise / expected / 16


THINGS = """
environment:
  {type: sunsky, sun_direction: [0.5, 0.8, 0.2], diameter: 10, sun_scale: 0.01, sky_scale: 0.2}
""" + FLOOR + """
  glass: {shape: cube, bsdf: glass, transform: [{scale: 0.2}, {translate: [0.35, 0.25, 0]}]}
  mirror: {shape: {type: sphere, radius: 0.2}, bsdf: mirror, transform: {translate: [-0.4, 0.2, 0]}}
  lamp:
    shape: {type: sphere, radius: 0.1}
    bsdf: black
    light: {type: area, radiance: [60, 50, 40]}
    transform: {translate: [0.1, 1.2, 0.1]}
"""  # fmt: skip


def test_caustics_are_those_that_paths_find():
    text = HEAD % ([0.0, 1.2, 3.2], 5) + THINGS
    (a, error_a), (b, error_b) = (
        blocks(alight.render(loads(text.replace("manifold", way)), spp=spp, seed=spp))
        for way, spp in (("manifold", 6_000), ("paths", 16_000))
    )
    error = np.hypot(error_a, error_b)
    seen = error > 0.0
    z = (a - b)[seen] / error[seen]
    assert np.abs(z).max() < LARGEST_Z, z
    total = (a - b).sum(axis=(0, 1)) / np.sqrt((error**2).sum(axis=(0, 1)))
    assert np.abs(total).max() < LARGEST_Z, total
    noise = np.sqrt((error**2).sum(axis=(0, 1))) / b.sum(axis=(0, 1))
    # It would see 1 % of all light.
    assert noise.max() < 0.002, noise


def test_neither_threads_nor_parts_change_a_bit():
    scene = loads(HEAD % ([0.0, 1.2, 3.2], 5) + THINGS)
    whole = alight.render(scene, spp=32, threads=1)
    shared = alight.render(scene, spp=32, threads=2, spp_per_pass=8)
    np.testing.assert_array_equal(whole.mean, shared.mean)


def disk_of(pixels, **turned):
    """Of the picture's texels, (axis, half angle in degrees, light of it over that of all)."""
    spec = Environment(pixels=Image(pixels), **turned)
    disk, made = environment.disk_of(spec, np.eye(4)), environment.map_of(spec, np.eye(4), False)
    assert disk is not None
    return disk.axis, np.degrees(disk.half_angle), np.array(disk.mean) / made.mean


def test_the_sun_of_a_picture_is_found():
    high, around = np.radians([pictures.SUN_HEIGHT, pictures.SUN_AZIMUTH])
    to_sun = [np.cos(high) * np.sin(around), np.sin(high), -np.cos(high) * np.cos(around)]
    axis, half_angle, share = disk_of(pictures.sky())
    np.testing.assert_allclose(axis, to_sun, atol=2e-3)
    # Half a texel of soft edge, and a texel from one to the next.
    assert pictures.SUN_RADIUS < half_angle < pictures.SUN_RADIUS + 0.8
    assert (share > 0.2).all() and (share < 1.0).all()
    # +x of the picture to -z of the world.
    axis, _, _ = disk_of(pictures.sky(), rotate=90.0)
    np.testing.assert_allclose(axis, [to_sun[2], to_sun[1], -to_sun[0]], atol=2e-3)


def test_a_picture_without_a_sun_has_none():
    spec = Environment(pixels=Image(np.ones((8, 16, 3), np.float32)))
    assert environment.disk_of(spec, np.eye(4)) is None
    small = np.ones((64, 128, 3), np.float32)
    small[20, 30] = 20.0
    # Too dim to be looked for; black.
    assert environment.disk_of(Environment(pixels=Image(small)), np.eye(4)) is None
    assert environment.disk_of(Environment(pixels=Image(0.0 * small)), np.eye(4)) is None


def test_a_sun_of_one_texel_reaches_as_far_as_the_next_one():
    pixels = np.ones((64, 128, 3), np.float32)
    pixels[20, 30] = 1e4
    disk = brightest_disk(pixels, np.eye(3))
    assert disk is not None
    assert abs(disk.half_angle - np.hypot(np.pi / 63.0, 2.0 * np.pi / 128.0)) < 1e-6
