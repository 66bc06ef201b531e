"""Materials with delta and smooth lobes in one: all estimators find all of the light, once."""

from __future__ import annotations

import numpy as np
import pytest

import alight

#: Deviations in standard errors of a mean over a picture; exceeded by chance once in 150 000.
SIGMAS = 4.5

# Under a sky of radiance 1 whatever loses nothing looks like the sky. The ball in the middle is a
# plastic of high index, so that both of its lobes are strong.
SCENE = """alight: 1
camera: {type: pinhole, fov: 30, transform: {look_at: {origin: [0, 0, 6], target: [0, 0, 0]}}}
film: {size: [48, 16]}
sampler: independent
environment: constant
bsdfs:
  white: {type: diffuse, reflectance: 1}
  mirror: {type: mirror}
  coated: {type: plastic, int_ior: 2.4, diffuse_reflectance: 1, nonlinear: true}
  patches: {type: blend, weight: 0.3, bsdfs: [white, {type: blend, bsdfs: [coated, mirror]}]}
  net: {type: mask, opacity: 0.6, bsdf: {type: two_sided, bsdf: patches}}
nodes:
  left: {shape: {type: sphere, radius: 0.7, center: [-1.6, 0, 0]}, bsdf: patches}
  middle: {shape: {type: sphere, radius: 0.7}, bsdf: coated}
"""
NET = """
  right: {shape: {type: sphere, radius: 0.7, center: [1.6, 0, 0]}, bsdf: net}
"""


def assert_white(tmp_path, text, spp):
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    pixels = alight.render(alight.load(path), spp=spp).image.astype(np.float64).mean(2)
    for part in np.split(pixels, 3, axis=1):
        mean, error = part.mean(), part.std(ddof=1) / np.sqrt(part.size)
        assert abs(mean - 1.0) <= SIGMAS * error + 1e-5, (mean, error)
        assert SIGMAS * error < 0.01, "too noisy to see an error of 1 %"


@pytest.mark.parametrize("strategy", ["mis", "bsdf", "emitter"])
def test_white_mixtures_vanish_under_a_white_sky(tmp_path, strategy):
    integrator = f"integrator: {{type: path, light_sampling: {strategy}, rr_depth: 8}}\n"
    assert_white(tmp_path, SCENE + NET + integrator, 256)


def test_the_random_walk_finds_delta_lobes_beside_smooth_ones(tmp_path):
    # Light between the two balls takes more edges than two; after six less than 1e-4 is left.
    assert_white(tmp_path, SCENE + "integrator: {type: random_walk, max_depth: 6}\n", 4096)
