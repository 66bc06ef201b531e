"""When the light tree is worth its time, as a whole and for single groups of lights."""

import numpy as np
import pytest

from alight.compiled.light_gain import LEAST_IN_GROUP, MOST_GAIN, even_groups, gain_of_tree
from alight.compiled.lights import MOST_WITHOUT_TREE
from alight.lights.constant import Constant
from alight.lights.directional import Directional
from alight.lights.point import Point
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, translate
from alight.shapes.rectangle import Rectangle
from tests.lights.test_light_tree import TREE, UP, choices, irradiance, leaves_at
from tests.sampling.statistics import LARGEST_Z
from tests.shapes.tracing import World


def test_auto_takes_the_tree_where_it_gains():
    floor = (Rectangle(), np.diag([5.0, 5.0, 1.0, 1.0]), None)
    rng = np.random.default_rng(1)
    for height, expected in ((1.0, True), (300.0, False)):
        spots = np.append(rng.uniform(-5, 5, (40, 2)), np.full((40, 1), height), axis=1)
        lamps = [PlacedLight("lamp", Point(), translate(*at).matrix) for at in spots]
        assert World(floor, lights=lamps, selection="auto").lights.has_tree == expected
        assert World(floor, lights=lamps, selection="tree").lights.has_tree


def test_gain_of_two_lamps():
    # Seen from the origin: 1 and 1/4 of the light a watt, with probabilities 1/4 and 3/4.
    ends = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]])
    leaves = leaves_at(ends, -ends / np.linalg.norm(ends, axis=1)[:, None])
    leaves = leaves._replace(intensity=np.array([1.0, 3.0]))
    shapes = World((Rectangle(), np.diag([1e-6, 1e-6, 1.0, 1.0]), None)).shapes
    expected = (0.25 + 0.75 / 16.0) / (0.25 + 0.75 / 4.0) ** 2
    assert gain_of_tree(leaves, shapes, np.zeros(1, bool)) == pytest.approx(expected, rel=1e-3)
    assert gain_of_tree(leaves, shapes, np.ones(1, bool)) == MOST_GAIN


def test_a_tree_without_gain_chooses_by_intensity():
    # A ring of lamps around a small floor: near, and all as far.
    floor = (Rectangle(), np.eye(4), None)
    turns = [rotate("z", 18.0 * k).matrix @ translate(6, 0, 3).matrix for k in range(20)]
    lamps = [PlacedLight("lamp", Point(intensity=k + 1.0), at) for k, at in enumerate(turns)]
    found, _ = choices(World(floor, lights=lamps, selection="tree"), (0.5, 0.0, 0.0), UP)
    np.testing.assert_allclose(found.pmf, (found.index + 1.0) / 210.0, rtol=1e-5)
    np.testing.assert_array_equal(found.pmf, found.mis_pmf)


def test_even_groups_are_those_that_gain_little():
    # Two lamps at heights 1 and 2 above one point, two at 9 and 9.5; all of one intensity.
    heights = np.array([1.0, 2.0, 9.0, 9.5])
    places = np.outer(heights, [0.0, 0.0, 1.0])
    leaves = leaves_at(places, np.tile([0.0, 0.0, -1.0], (4, 1)))
    points = np.zeros((32, 3))
    begin, end = np.array([0, 0, 2]), np.array([4, 2, 4])
    light = 1.0 / heights**2
    gain = [
        2.0 * (light[a:b] ** 2).sum() / light[a:b].sum() ** 2 - 1.0 for a, b in ((0, 2), (2, 4))
    ]
    assert gain[1] < LEAST_IN_GROUP < gain[0]
    assert even_groups(points, leaves, begin, end).tolist() == [False, False, True]
    # Too few points tell nothing.
    assert not even_groups(points[:8], leaves, begin, end).any()


def test_few_lights_have_no_tree():
    few = [PlacedLight("lamp", Point(), translate(k, 0, 0).matrix) for k in range(64)]
    assert not World(lights=few[:MOST_WITHOUT_TREE], selection="auto").lights.has_tree
    assert World(lights=few[: MOST_WITHOUT_TREE + 1], selection="auto").lights.has_tree
    assert not World(lights=few, selection="power").lights.has_tree
    suns = [PlacedLight("sun", Directional(), np.eye(4))] * 64
    assert not World(lights=suns, selection="auto").lights.has_tree


def test_a_tree_of_few_lights_or_none():
    for count in (0, 1, 2):
        places = [translate(0, 0, k + 1.0).matrix for k in range(count)]
        lamps = [PlacedLight("lamp", Point(), place) for place in places]
        world = World(lights=lamps, environment=Constant(), selection="tree")
        value, error = irradiance(world, TREE, (0.0, 0.0, 0.0), UP, 4)
        expected = np.pi + sum(1.0 / (k + 1.0) ** 2 for k in range(count))
        assert abs(value - expected) < LARGEST_Z * error
