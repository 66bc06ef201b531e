"""Rays and boxes: what is met is met, and nothing else, or the search would be long."""

import numpy as np

from alight.accel.node_test import meet_slabs
from alight.compiled.program import Program
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3


def test_a_box_is_met_where_the_ray_is_in_all_three_slabs_at_once():
    """By float64; only within rounding of an edge may a ray that misses enter."""
    rng, n = np.random.default_rng(1), 200_000
    low = rng.uniform(-2.0, 0.0, (3, n))
    high = low + rng.exponential(2.0, (3, n))
    o, d, t = rng.normal(size=(3, n)), rng.normal(size=(3, n)), rng.exponential(4.0, n)
    slabs = np.sort([(low - o) / d, (high - o) / d], axis=0)
    near, far = (Vec3(*side.astype(np.float32)) for side in slabs)
    enter, met = instantiate(meet_slabs, Program(), compiled=False)(near, far, np.float32(t))
    entry, exit_ = np.maximum(slabs[0].max(axis=0), 0.0), np.minimum(slabs[1].min(axis=0), t)
    certain = np.abs(exit_ - entry) > 1e-4 * (1.0 + np.abs(entry))
    assert 0.05 < (entry <= exit_).mean() < 0.5
    np.testing.assert_array_equal(met[certain], (entry <= exit_)[certain])
    np.testing.assert_allclose(enter[met], entry[met], rtol=1e-5, atol=1e-6)
