"""Caustics by manifold sampling: the same light as paths find, and closed forms."""

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
  dim: {type: diffuse, reflectance: 0.01}
  glass:
    {type: dielectric, int_ior: 1.5, attenuation_color: [0.5, 0.8, 1], attenuation_distance: 0.1}
  mirror: {type: mirror, reflectance: 0.8}
  plastic: {type: plastic}
  black: {type: diffuse, reflectance: 0}
nodes:
  floor:
    shape: rectangle
    bsdf: plastic
    transform: [{scale: 1.5}, {rotate: {axis: x, angle: -90}}]
"""

#: A block of glass, a ball of metal, and two lamps of different shapes.
THINGS = """
  glass: {shape: cube, bsdf: glass, transform: [{scale: 0.2}, {translate: [0.35, 0.25, 0]}]}
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
        for way, spp in (("manifold", 30_000), ("paths", 60_000))
    )
    error = np.hypot(error_a, error_b)
    seen = error > 0.0
    z = (a - b)[seen] / error[seen]
    assert np.abs(z).max() < LARGEST_Z, z
    # All blocks together: their errors are independent.
    total = (a - b).sum(axis=(0, 1)) / np.sqrt((error**2).sum(axis=(0, 1)))
    assert np.abs(total).max() < LARGEST_Z, total
    # It would see 5 % of all light, and less of that which comes over glass and mirrors.
    noise = np.sqrt((error**2).sum(axis=(0, 1))) / b.sum(axis=(0, 1))
    assert noise.max() < 0.01, noise


WATER, HEIGHT, RADIUS, RADIANCE = 1.33, 2.0, 0.004, 1e5
INTENSITY = RADIANCE * np.pi * RADIUS**2
SMALL_LAMP = f"""
  dim:
    shape: rectangle
    bsdf: dim
    transform: [{{scale: 2}}, {{rotate: {{axis: x, angle: -90}}}}, {{translate: [0, 0.001, 0]}}]
  lamp:
    shape: {{type: sphere, radius: {RADIUS}}}
    bsdf: black
    light: {{type: area, radiance: {RADIANCE}}}
    transform: {{translate: [0, {HEIGHT + 0.001}, 0]}}
"""
SURFACE = """
  %s:
    shape: rectangle
    bsdf: {type: dielectric, int_ior: %g, ext_ior: %g}
    transform: [{scale: 9}, {rotate: {axis: x, angle: -90}}, {translate: [0, %g, 0]}]
"""
WATERY = SMALL_LAMP + SURFACE % ("water", WATER, 1.0, 1.001)
DENSE = 3.0
PANE = SMALL_LAMP + SURFACE % ("top", DENSE, 1.0, 1.0) + SURFACE % ("bottom", 1.0, DENSE, 0.9997)


def reflected(cosine, eta):
    """Fresnel's reflectance of glass."""
    return np.array(
        [float(fresnel_dielectric(np.float32(c), np.float32(eta))[0]) for c in np.ravel(cosine)]
    ).reshape(np.shape(cosine))


def irradiance_under_water(x):
    """Of the small lamp, at the distance x from the foot of its height.

    The flux between two cones around the vertical, I 2 pi sin t dt (1 - F), falls onto a ring.
    """
    t = np.linspace(0.0, 1.2, 5_001)[1:]
    place = np.tan(t) + np.tan(np.arcsin(np.sin(t) / WATER))
    flux = INTENSITY * (1.0 - reflected(np.cos(t), WATER)) * np.sin(t)
    return np.interp(x, place, flux / (place * np.gradient(place, t)))


def irradiance_behind_a_pane(x):
    """Of the small lamp, and of the light that is reflected in the pane: (1 - F) / (1 + F)."""
    cosine = HEIGHT / np.hypot(HEIGHT, x)
    f = reflected(cosine, DENSE)
    return INTENSITY * cosine**3 / HEIGHT**2 * (1.0 - f) / (1.0 + f)


@pytest.mark.parametrize(
    ("nodes", "depth", "irradiance"),
    [(WATERY, 3, irradiance_under_water), (PANE, 8, irradiance_behind_a_pane)],
    ids=["water", "pane"],
)
def test_a_small_lamp_lights_the_ground(tmp_path, nodes, depth, irradiance):
    origin, n, ways = (0.0, 0.8, 0.4), 16, 4
    film = alight.render(scene_of(tmp_path, nodes, depth, "manifold", origin), spp=2048, seed=3)
    # Where the pixels look.
    eye = np.array(origin)
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    up, tangent = np.cross(right, forward), np.tan(np.radians(20.0))
    y, x = np.meshgrid(*[(np.arange(ways * n) + 0.5) / (ways * n / 2) - 1.0] * 2, indexing="ij")
    d = forward + tangent * (x[..., None] * right - y[..., None] * up)
    p = eye + d * ((0.001 - eye[1]) / d[..., 1])[..., None]
    expected = 0.01 / np.pi * irradiance(np.hypot(p[..., 0], p[..., 2]))
    expected = expected.reshape(4, n, 4, n).mean((1, 3))
    a, error = blocks(film)
    z = (a[..., 1] - expected) / error[..., 1]
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a[..., 1] - expected).sum(), np.sqrt((error[..., 1] ** 2).sum())
    assert abs(total) < LARGEST_Z * noise, total / expected.sum()
    assert noise < 0.005 * expected.sum(), noise / expected.sum()


def test_neither_threads_nor_parts_change_a_bit(tmp_path):
    scene = scene_of(tmp_path, THINGS, 6, "manifold")
    whole = alight.render(scene, spp=32, threads=1)
    shared = alight.render(scene, spp=32, threads=2, spp_per_pass=8)
    np.testing.assert_array_equal(whole.mean, shared.mean)
    first, second = (alight.render(scene, spp=16, first_sample=at) for at in (0, 16))
    np.testing.assert_array_equal(whole.mean, alight.Film.merge(second, first).mean)
