"""Caustics at places that light passes: rough glass, with bodies and colours on either side.

And on a wall behind leaves and what has holes, where a lamp may also be seen straight ahead.
"""

import math

import numpy as np
import pytest

import alight
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from tests.portion import portion

pytestmark = pytest.mark.proofs

SCENE = """
alight: 1
sampler: {type: independent}
integrator: {type: path, max_depth: %d, caustics: %s, russian_roulette: none, light_sampling: bsdf}
camera: {type: pinhole, fov: %g, transform: {look_at: {origin: %s, target: %s, up: [0, 1, 0]}}}
film: {size: [8, 8], filter: {type: box}}
bsdfs:
  rough: {type: rough_dielectric, alpha: 0.3, int_ior: 1.3, ext_ior: 1,
          attenuation_color: [0.8, 0.3, 0.05], attenuation_distance: 1}
  pane: {type: rough_dielectric, alpha: 0.03, dispersion: 5, int_ior: 1.5}
  black: {type: diffuse, reflectance: 0}
  wall: {type: diffuse, reflectance: 0.7}
  leaf: {type: mask, opacity: 0.4, bsdf: wall}
  veil: {type: mask, opacity: 0.6, bsdf: {type: blend, weight: 0.7,
    bsdfs: [wall, {type: dielectric, int_ior: 1.5}]}}
nodes:
"""
BULB = """
  bulb: {shape: {type: sphere, radius: %g, center: %s}, bsdf: {type: dielectric, %s}}
  lamp:
    shape: {type: sphere, radius: %g, center: %s}
    bsdf: black
    light: {type: area, radiance: 1}
"""
BALL = "  ball: {shape: sphere, bsdf: rough}"
PANE = "  pane: {shape: rectangle, bsdf: pane, transform: {scale: 2}}"
#: 3 m from the pane at 64 degrees, where it sends green and blue but no red.
ASIDE = [3.0 * math.sin(math.radians(64.0)), 0.0, 3.0 * math.cos(math.radians(64.0))]
AHEAD, BEHIND = [0.0, 0.0, -2.0], [0.0, 0.0, -0.2]
WALL = "  wall: {shape: rectangle, bsdf: wall}"
SHEET = "\n  sheet: {shape: rectangle, bsdf: %s, transform: {translate: [0, 0, 1]}}"
OVER = [0.0, 0.0, 2.0]
FROM = [-math.sin(math.radians(35.0)), 0.0, -math.cos(math.radians(35.0))]

CASES = {
    "out of coloured glass": (
        (4, 20.0, [0, 0, 0], [0, 0, -1]),
        BALL + BULB % (0.4, AHEAD, "int_ior: 1.2, ext_ior: 1", 0.1, AHEAD),
        (1 << 15, 1 << 11),
    ),
    "into coloured glass": (
        (3, 20.0, [0, 0, 4], [0, 0, 3]),
        BALL + BULB % (0.3, BEHIND, "int_ior: 1, ext_ior: 1.3", 0.08, BEHIND),
        (1 << 16, 1 << 12),
    ),
    "through glass that disperses light": (
        (3, 1.0, FROM, [0, 0, 0]),
        PANE + BULB % (0.4, ASIDE, "int_ior: 1.2, ext_ior: 1", 0.15, ASIDE),
        (1 << 15, 1 << 11),
    ),
    "behind leaves": (
        (5, 20.0, [1, 0, 0.8], [0, 0, 0]),
        WALL + SHEET % "leaf" + BULB % (0.4, OVER, "int_ior: 1.2, ext_ior: 1", 0.1, OVER),
        (1 << 16, 1 << 12),
    ),
    "behind clear glass with holes": (
        (5, 20.0, [1, 0, 0.8], [0, 0, 0]),
        WALL + SHEET % "veil" + BULB % (0.4, [0, 0, -4], "int_ior: 1", 0.1, OVER),
        (1 << 15, 1 << 12),
    ),
}


def mean_of(case, caustics, spp):
    """Mean of the picture and its standard error, by channel."""
    (depth, fov, *look), nodes, _ = CASES[case]
    text = SCENE % (depth, caustics, fov, *look) + nodes.strip("\n")
    film = alight.render(loads(text), spp=spp, seed=4, threads=2)
    error = np.sqrt((film.standard_error.astype(np.float64) ** 2).sum(axis=(0, 1))) / 64.0
    return film.mean.astype(np.float64).mean(axis=(0, 1)), error


@pytest.mark.parametrize("case", portion(CASES))
def test_caustics_are_those_that_paths_find(case):
    of_paths, of_manifold = (
        mean_of(case, caustics, spp)
        for caustics, spp in zip(("paths", "manifold"), CASES[case][2], strict=True)
    )
    noise = np.hypot(of_paths[1], of_manifold[1])
    z = (of_manifold[0] - of_paths[0]) / noise
    assert np.abs(z).max() < LARGEST_Z, (of_paths, of_manifold)
    # A third more or less would be found.
    assert noise.max() * LARGEST_Z < 0.33 * of_paths[0].max()
