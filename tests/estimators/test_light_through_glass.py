"""Light paths through glass that absorbs and disperses light find what camera paths find."""

import numpy as np
import pytest

import alight
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z

pytestmark = pytest.mark.proofs

SCENE = """
alight: 1
sampler: {type: independent}
integrator: {type: %s, max_depth: 6}
camera: {type: pinhole, fov: 20, transform: {look_at: {origin: [0, -6, 2], target: [0, 0, -1]}}}
film: {size: [8, 8], filter: {type: box}}
nodes:
  glass:
    shape: cube
    bsdf: {type: dielectric, int_ior: 1.5, %s}
    transform: [{scale: 0.4}, {rotate: {axis: y, angle: 30}}, {translate: [0.2, 0, 0]}]
  floor:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: 0.8}
    transform: [{scale: 2}, {translate: [0, 0, -1]}]
"""
RED_LAMP = """  lamp:
    shape: {type: sphere, radius: 0.4}
    bsdf: {type: diffuse, reflectance: 0}
    light: {type: area, radiance: [1, 0, 0]}
    transform: {translate: [0.5, 0.6, 1.6]}
"""
SKY = "environment: {type: constant, radiance: [1, 0.5, 0.25]}\n"
CASES = {
    # Weights of some wavelengths are negative in the only channel that there is.
    "a red lamp": ("dispersion: 20", RED_LAMP),
    "a sky": ("attenuation_color: [0.5, 0.8, 0.9], attenuation_distance: 0.5", SKY),
}


@pytest.mark.parametrize("case", CASES)
def test_light_paths_agree_with_camera_paths(case):
    glass, light = CASES[case]
    found = []
    for integrator, spp in (("path", 1 << 16), ("light", 1 << 14)):
        scene = loads(SCENE % (integrator, glass) + light)
        film = alight.render(scene, spp=spp, seed=6, replicates=32)
        # Pixels of light paths share them: replicates tell the error of the whole.
        means = film.replicate_means()[0][..., 0].astype(np.float64)
        # The glass itself is black for light paths: pixels of the floor alone.
        whole = means[4:].mean(axis=(0, 1))
        found.append((whole.mean(), whole.std(ddof=1) / np.sqrt(whole.size)))
    (a, da), (b, db) = found
    assert abs(a - b) < LARGEST_Z * np.hypot(da, db), found
    # A tenth more would be found.
    assert LARGEST_Z * np.hypot(da, db) < 0.1 * a, found
