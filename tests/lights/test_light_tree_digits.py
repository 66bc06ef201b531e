"""Random numbers have 24 bits, and improbable choices use them up: what is left must still do."""

import numpy as np
import pytest

from alight.compiled.light_tree import MOST_OUTER
from alight.core.distributions import UNIT
from alight.lights.directional import Directional
from alight.lights.point import Point
from alight.lights.spot import Spot
from alight.lights.tree.traversal import OUTER, choose_by_tree
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, translate
from tests.lights.test_light_tree import NONE, points, run
from tests.shapes.tracing import World

FAR = 400


def far_and_near(spread, beside):
    """Equal lamps that are far from the origin, within `spread` metres, and bright ones near it.

    `beside`: a sun, which takes most of the numbers.
    """
    rng, down = np.random.default_rng(1), rotate("x", 180).matrix
    far = [
        PlacedLight(
            "far",
            Spot(cutoff_angle=80.0),
            translate(300.0 + x, y, 100.0).matrix @ down,
        )
        for x, y in spread * rng.uniform(-1, 1, (FAR, 2))
    ]
    places = ((0, 0.01, 0.05), (0.02, 0, 0.05), (0, 0.03, 0.05), (-0.01, 0.01, 0.05))
    bright = 0.08 if beside else 0.5
    near = [PlacedLight("near", Point(intensity=bright), translate(*at).matrix) for at in places]
    sun = [PlacedLight("sun", Directional(irradiance=1e6), np.eye(4))] if beside else []
    return World(lights=far + near + sun, selection="tree")


def chosen(world, u, u2):
    """`Choice` at the origin."""
    n = len(u)
    at, on = points((0, 0, 0), n), np.ones(n, bool)
    return run(choose_by_tree, world.scene, at, points(NONE, n), np.float32(u), u2, on)


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("spread", [1.0, 60.0])
def test_each_lamp_of_an_improbable_group_is_chosen_about_as_often_as_it_says(spread, beside):
    rng, times, world = np.random.default_rng(2), 600, far_and_near(spread, beside)
    begin = round(float(world.scene.lights.cdf.array[OUTER]) / UNIT)
    assert begin == round(MOST_OUTER / UNIT) if beside else begin == 0
    # The group of all far lamps has the probability of some seventy numbers at one of the ends.
    near = np.arange(256)
    u = np.tile(np.append(begin + near, 2**24 - 256 + near), times) * UNIT
    found = chosen(world, u, rng.random((2, len(u)), np.float32))
    there = (found.index < FAR) & (found.pmf > 0.0)
    said = np.full(FAR, 1e-12)
    said[found.index[there]] = found.pmf[there]
    ratio = np.bincount(found.index[there], minlength=FAR) / (times * said / UNIT)
    # The numbers at both ends of the group belong to it in part only.
    assert np.quantile(ratio, 0.05) > 0.6 and np.quantile(ratio, 0.95) < 1.5
    assert 16.0 < said.sum() / UNIT < 256.0
