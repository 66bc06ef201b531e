"""Manifold sampling where paths follow a guide: both count the light once."""

import numpy as np

import alight
from alight.laws.statistics import LARGEST_Z
from tests.estimators.test_caustics import THINGS, blocks, scene_of


def test_guided_paths_and_walks_find_what_paths_find(tmp_path):
    scene = scene_of(tmp_path, THINGS, 6, "manifold")
    guided = scene.replaced(integrator=scene.integrator.replaced(guiding="on"))
    paths = scene.replaced(integrator=scene.integrator.replaced(caustics="paths"))
    (a, error_a), (b, error_b) = (
        blocks(alight.render(each, spp=spp, seed=spp))
        for each, spp in ((guided, 1500), (paths, 8000))
    )
    error = np.hypot(error_a, error_b)
    seen = error > 0.0
    z = (a - b)[seen] / error[seen]
    assert np.abs(z).max() < LARGEST_Z, z
    total, noise = (a - b).sum((0, 1)), np.sqrt((error**2).sum((0, 1)))
    assert (np.abs(total) < LARGEST_Z * noise).all(), total / noise
    assert (noise < 0.04 * b.sum((0, 1))).all(), noise / b.sum((0, 1))
