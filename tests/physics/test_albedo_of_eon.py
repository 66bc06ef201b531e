"""The albedo of energy-preserving Oren and Nayar is the mean of what its lobe reflects."""

from types import SimpleNamespace

import numpy as np
import pytest

from alight.bsdfs.matte.eon import EXAMPLES, albedo
from alight.core.vec import Vec3
from alight.laws.materials import Material
from lanewise.jit import instantiate

SPEC = type(EXAMPLES[0])
N = 1 << 16


def by_cosine(numbers):
    """Directions of the upper half with the density cos / pi."""
    r, phi = np.sqrt(numbers[0]), 2.0 * np.pi * numbers[1]
    return np.array([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - numbers[0])], np.float32)


@pytest.mark.parametrize("roughness", [0.0, 0.4, 1.0])
def test_the_albedo_is_the_mean_of_the_lobe(roughness):
    colour = (0.9, 0.5, 0.1)
    material = Material(SPEC(reflectance=colour, roughness=roughness))
    rng = np.random.default_rng(5)
    wo, wi = (by_cosine(rng.random((2, N))) for _ in range(2))
    f_cos, _ = material.evaluate(wo, wi)
    reflected = (f_cos / wi[2] * np.pi).mean(axis=1)
    params = SimpleNamespace(
        reflectance=Vec3(*np.array(colour, np.float32)), roughness=np.float32(roughness)
    )
    told = instantiate(albedo, compiled=False)(params)
    np.testing.assert_allclose([told.x, told.y, told.z], reflected, rtol=0.01)
