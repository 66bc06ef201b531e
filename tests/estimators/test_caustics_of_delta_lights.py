"""Caustics of lamps without a size, which no path hits: closed forms, and light paths."""

from __future__ import annotations

import numpy as np

import alight
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from tests.estimators.test_caustics import WATER, blocks, reflected

HEAD = """
alight: 1
camera: {fov: %g, transform: {look_at: {origin: [%s], target: [%s]}}}
film: {size: [16, 16], filter: {type: box}}
sampler: {type: independent}
integrator: {type: %s, max_depth: %d%s}
bsdfs:
  floor: {type: diffuse, reflectance: 0.5}
  water: {type: dielectric, int_ior: 1.33}
  glass:
    {type: dielectric, int_ior: 1.5, attenuation_color: [0.5, 0.8, 1], attenuation_distance: 0.1}
  mirror: {type: mirror, reflectance: 0.8}
nodes:
  floor: {shape: rectangle, bsdf: floor, transform: [{scale: 2}, {rotate: {axis: x, angle: -90}}]}
"""
#: Each lamp has a colour to itself; all of them shine down.
LAMPS = """
  bulb: {light: {type: point, intensity: [3, 0, 0]}, transform: {translate: [%s]}}
  beam:
    light: {type: spot, intensity: [0, 4, 0], cutoff_angle: 80, beam_width: 70}
    transform: [{rotate: {axis: x, angle: 90}}, {translate: [%s]}]
  day:
    light: {type: directional, irradiance: [0, 0, 2]}
    transform: [{rotate: {axis: x, angle: 60}}]
"""
HEIGHT = 3.0
UNDER_WATER = """
  water:
    {shape: rectangle, bsdf: water, transform: [{scale: 9}, {rotate: {axis: x, angle: -90}},
     {translate: [0, 1, 0]}]}
""" + LAMPS % (f"0, {HEIGHT}, 0", f"0, {HEIGHT}, 0")  # fmt: skip


def test_lamps_light_the_ground_under_water():
    """The water is 1 m deep, the lamps hang 2 m above it, and the camera is below."""
    at, fov = 0.5, 40.0
    text = HEAD % (fov, f"0, {at}, 0.001", "0, 0, 0", "path", 3, ", caustics: manifold")
    film = alight.render(loads(text + UNDER_WATER), spp=6144, seed=3)
    a, error = blocks(film)
    edge = at * np.tan(np.radians(0.5 * fov))
    y, x = np.meshgrid(*[edge * ((np.arange(64) + 0.5) / 32.0 - 1.0)] * 2, indexing="ij")
    of_one = _irradiance_below(np.hypot(x, y))
    cosine = np.cos(np.radians(30.0))
    of_day = np.full_like(x, 2.0 * cosine * (1.0 - reflected(cosine, WATER)))
    expected = 0.5 / np.pi * np.stack([3.0 * of_one, 4.0 * of_one, of_day], -1)
    expected = expected.reshape(4, 16, 4, 16, 3).mean((1, 3))
    z = (a - expected) / error
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a - expected).sum((0, 1)), np.sqrt((error**2).sum((0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), total / expected.sum((0, 1))
    # It would see 4 % of the lamps and 1 % of the day.
    assert (noise < [0.009, 0.009, 0.0022] * expected.sum((0, 1))).all(), noise


def _irradiance_below(x):
    """Of a lamp of 1 W/sr, 2 m above water of 1 m, at the distance x from its foot."""
    t = np.linspace(0.0, 1.2, 5_001)[1:]
    place = (HEIGHT - 1.0) * np.tan(t) + np.tan(np.arcsin(np.sin(t) / WATER))
    flux = (1.0 - reflected(np.cos(t), WATER)) * np.sin(t)
    return np.interp(x, place, flux / (place * np.gradient(place, t)))


#: Above the camera, which sees their caustics alone.
THINGS = (
    """
  glass: {shape: cube, bsdf: glass, transform: [{scale: 0.2}, {translate: [0.2, 0.6, 0]}]}
  mirror: {shape: {type: sphere, radius: 0.4}, bsdf: mirror, transform: {translate: [-0.6, 0.8, 0]}}
"""
    + LAMPS % ("0.2, 1.5, 0.1", "0.1, 1.4, 0")
)


def test_caustics_are_those_that_light_paths_find():
    (a, error_a), (b, error_b) = (
        blocks(alight.render(loads(HEAD % (30, "0, 0.3, 1.2", "0.1, 0, 0", *way) + THINGS), spp=n))
        for way, n in (
            (("path", 5, ", caustics: manifold"), 1500),
            (("light", 5, ""), 6_000),
        )
    )
    error = np.hypot(error_a, error_b)
    z = (a - b) / error
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a - b).sum((0, 1)), np.sqrt((error**2).sum((0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), total / noise
    # Caustics are 10 to 35 % of all light here.
    assert (noise < 0.06 * b.sum((0, 1))).all(), noise / b.sum((0, 1))


def test_nothing_comes_through_what_lies_in_front():
    """A dark lid above the water, below the lamps: they light nothing."""
    lid = """
  lid:
    {shape: rectangle, bsdf: lid, transform: [{scale: 9}, {rotate: {axis: x, angle: -90}},
     {translate: [0, 1.5, 0]}]}
"""
    text = HEAD % (40.0, "0, 0.5, 0.001", "0, 0, 0", "path", 3, ", caustics: manifold")
    text = text.replace("nodes:", "  lid: {type: diffuse, reflectance: 0}\nnodes:")
    dark, lit = (alight.render(loads(text + UNDER_WATER + more), spp=16) for more in (lid, ""))
    assert not dark.mean.any()
    assert lit.mean.any(axis=(0, 1)).all()
