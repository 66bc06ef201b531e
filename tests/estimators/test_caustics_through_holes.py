"""Caustics through holes, and at surfaces that are sums of models: closed forms, and paths."""

from __future__ import annotations

import numpy as np

import alight
from alight.core.wavelengths import LINE_C, LINE_D, LINE_F, wavelength_at, weights_at
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from tests.estimators.test_caustics import blocks, reflected

HEIGHT, FOV, AT = 3.0, 40.0, 0.5
#: The camera is below water of 1 m; above are leaves that let 60 % through, below is a
#: surface that is not there. What is made of the other material is behind the floor: so both tests
#: need the same kernels.
HEAD = """
alight: 1
camera: {fov: %g, transform: {look_at: {origin: [0, %g, 0.001], target: [0, 0, 0]}}}
film: {size: [16, 16], filter: {type: box}}
sampler: {type: independent}
integrator: {type: path, max_depth: 5, caustics: manifold}
bsdfs:
  floor: {type: diffuse, reflectance: 0.5}
  leaf: {type: mask, opacity: 0.4, bsdf: {type: diffuse, reflectance: 0}}
  water: %s
  other: %s
nodes:
  floor: {shape: rectangle, bsdf: floor, transform: [{scale: 2}, {rotate: {axis: x, angle: -90}}]}
  air: {shape: rectangle, bsdf: {type: 'null'}, transform: [{scale: 9},
    {rotate: {axis: x, angle: -90}}, {translate: [0, 0.7, 0]}]}
  water: {shape: rectangle, bsdf: water, transform: [{scale: 9}, {rotate: {axis: x, angle: -90}},
    {translate: [0, 1, 0]}]}
  leaf: {shape: rectangle, bsdf: leaf, transform: [{scale: 9}, {rotate: {axis: x, angle: -90}},
    {translate: [0, 1.6, 0]}]}
  other: {shape: sphere, bsdf: other, transform: {translate: [0, -20, 0]}}
  bulb: {light: {type: point, intensity: [3, 4, 5]}, transform: {translate: [0, 3, 0]}}
"""

MIXED = """
    type: blend
    weight: 0.5
    bsdfs:
      - {type: dielectric, int_ior: 1.33}
      - {type: mask, opacity: 0.5, bsdf: {type: dielectric, int_ior: 1.6}}
"""
ABBE, N_D = 15.0, 1.5
PRISM = f"{{type: dielectric, int_ior: {N_D}, dispersion: {ABBE}}}"
LINES = LINE_D, LINE_F, LINE_C


def _irradiance_below(x, index):
    """Of a lamp of 1 W/sr, 2 m above water of 1 m, at the distance x from its foot."""
    t = np.linspace(0.0, 1.2, 5_001)[1:]
    place = (HEIGHT - 1.0) * np.tan(t) + np.tan(np.arcsin(np.sin(t) / index))
    flux = (1.0 - reflected(np.cos(t), index)) * np.sin(t)
    return np.interp(x, place, flux / (place * np.gradient(place, t)))


def _from_the_foot():
    """Distances of the places that the camera sees."""
    edge = AT * np.tan(np.radians(0.5 * FOV))
    return np.hypot(*np.meshgrid(*[edge * ((np.arange(64) + 0.5) / 32.0 - 1.0)] * 2))


def _demand(film, of_one):
    """The picture is that of the lamp, whose irradiance is given for 1 W/sr, in three channels."""
    a, error = blocks(film)
    expected = 0.5 / np.pi * 0.6 * of_one.reshape(4, 16, 4, 16, 3).mean((1, 3)) * [3.0, 4.0, 5.0]
    z = (a - expected) / error
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a - expected).sum((0, 1)), np.sqrt((error**2).sum((0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), total / expected.sum((0, 1))
    return (noise / expected.sum((0, 1))).max()


def test_every_model_of_a_material_refracts_by_its_share():
    """Half water, half of that a denser liquid with holes: two caustics, and direct light."""
    film = alight.render(loads(HEAD % (FOV, AT, MIXED, PRISM)), spp=512, seed=2)
    x = _from_the_foot()
    straight = HEIGHT / (HEIGHT**2 + x**2) ** 1.5
    one = 0.5 * _irradiance_below(x, 1.33) + 0.25 * (_irradiance_below(x, 1.6) + straight)
    assert _demand(film, one[..., np.newaxis] * np.ones(3)) < 0.03


def test_light_is_dispersed_on_its_way():
    """Each wavelength has an index, and so an irradiance; channels are means over them."""
    film = alight.render(loads(HEAD % (FOV, AT, PRISM, MIXED)), spp=512, seed=5)
    u = ((np.arange(24) + 0.5) / 24.0).astype(np.float32)
    lines = 1.0 / np.square([*(wavelength_at(u) / 1000.0), *(np.array(LINES) / 1000.0)])
    index = N_D + (N_D - 1.0) / ABBE * (lines[:-3] - lines[-3]) / (lines[-2] - lines[-1])
    of_each = np.stack([_irradiance_below(_from_the_foot(), n) for n in index], -1)
    # Each of few samples has the colour of its wavelength.
    lit = film.mean[film.mean.all(-1)] / [3.0, 4.0, 5.0]
    assert np.median(np.ptp(lit, axis=-1) / lit.max(-1)) > 0.05
    w = weights_at(u)
    assert _demand(film, of_each @ np.stack([w.x, w.y, w.z], -1) / len(u)) < 0.03


def test_holes_are_edges_of_paths():
    """To the floor, through what is not there, water and leaves, to the lamp: five edges."""
    text = HEAD % (FOV, AT, PRISM, MIXED)
    dark, lit = (
        alight.render(loads(text.replace("max_depth: 5", f"max_depth: {n}")), spp=16).mean
        for n in (4, 5)
    )
    assert not dark.any()
    assert lit.any(axis=(0, 1)).all()
