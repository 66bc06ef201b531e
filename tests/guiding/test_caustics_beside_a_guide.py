"""Manifold sampling where paths follow a guide: it adds the same light as without one."""

import numpy as np

import alight
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from tests.estimators.test_caustics import blocks
from tests.estimators.test_caustics_of_delta_lights import HEAD, UNDER_WATER


def test_walks_add_the_same_light_beside_a_guide():
    text = HEAD % (40.0, "0, 0.5, 0.001", "0, 0, 0", "path", 5, ", caustics: manifold")
    scene = loads(text + UNDER_WATER)
    guided = scene.replaced(integrator=scene.integrator.replaced(guiding="on"))
    (a, error_a), (b, error_b) = (
        blocks(alight.render(each, spp=1024, seed=seed)) for each, seed in ((guided, 1), (scene, 2))
    )
    error = np.hypot(error_a, error_b)
    assert np.abs((a - b) / error).max() < LARGEST_Z
    total, noise = (a - b).sum((0, 1)), np.sqrt((error**2).sum((0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), total / noise
    assert (noise < 0.04 * b.sum((0, 1))).all(), noise / b.sum((0, 1))
