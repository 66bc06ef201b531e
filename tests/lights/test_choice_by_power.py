"""Lights of very unequal power: none that shines is left out."""

import numpy as np
import pytest

from alight.compiled.light_tree import LEAST_SHARE
from alight.core.distributions import UNIT
from alight.lights.directional import Directional
from alight.lights.point import Point
from alight.lights.tables import STRIDE
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, translate
from alight.shapes.rectangle import Rectangle
from tests.shapes.tracing import World

# A sun whose power is that on all of the ground, 10^10 times that of the others.
GROUND = (Rectangle(), np.diag([5000.0, 5000.0, 1.0, 1.0]), None)
SUN = PlacedLight("sun", Directional(irradiance=1000.0), rotate("x", 180).matrix)
MOON = PlacedLight("moon", Directional(irradiance=1e-7), rotate("x", 150).matrix)
LAMP = PlacedLight("lamp", Point(intensity=0.3), translate(0, 0, 2).matrix)
BLACK = PlacedLight("black", Point(intensity=0.0), np.eye(4))


def shares(lights, selection):
    """Probability of each light in the tables."""
    tables = World(GROUND, lights=lights, selection=selection).lights.tables
    return tables.data.array.reshape(-1, STRIDE)[:, 3]


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0), (1, 0, 3, 2)])
def test_a_lamp_is_not_forgotten_beside_a_sun(order):
    lights = [SUN, MOON, LAMP, BLACK]
    sun, moon, lamp, black = shares([lights[i] for i in order], "power")[np.argsort(order)]
    assert moon == pytest.approx(LEAST_SHARE / 3.0, rel=0.02)
    assert lamp == pytest.approx(moon, abs=2.0 * UNIT)
    assert sun == pytest.approx(1.0 - lamp - moon, abs=1e-6) and black == 0.0


def test_a_moon_is_not_forgotten_beside_a_tree():
    sun, moon, lamp = shares([SUN, MOON, LAMP], "tree")
    # The lamp is in the tree, and its way depends on the place.
    assert moon == pytest.approx(0.5 * LEAST_SHARE * (sun + moon), rel=0.02) and lamp == 0.0
