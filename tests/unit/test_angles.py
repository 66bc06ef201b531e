"""Angles between vectors: cos from the dot product, sin from the cross product."""

import numpy as np
import pytest

from alight.core.maths import arccos, arcsin, arctan2
from alight.core.vec import cross, dot, length, normalize
from lanewise.vec3 import Vec3
from tests.sampling.statistics import unit_vectors

f = np.float32


def pair(angle, a_length=2.0, b_length=0.5):
    """Two vectors with a given angle between them."""
    a = Vec3(f([a_length]), f([0.0]), f([0.0]))
    b = Vec3(f([b_length * np.cos(angle)]), f([0.0]), f([b_length * np.sin(angle)]))
    return a, b


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0])
def test_angle_by_dot_product(degrees):
    a, b = pair(np.radians(degrees))
    angle = arccos(dot(a, b) / (length(a) * length(b)))
    # The cosine is flat at 0 and 180 degrees: one rounding of it is an angle of 3e-4.
    atol = 3.5e-4 if degrees in (0.0, 180.0) else 5e-7
    np.testing.assert_allclose(angle, np.radians(degrees), atol=atol)


@pytest.mark.parametrize("degrees", [0.0, 1e-3, 30.0, 45.0, 60.0, 89.0])
def test_angle_by_cross_product(degrees):
    a, b = pair(np.radians(degrees))
    angle = arcsin(length(cross(a, b)) / (length(a) * length(b)))
    np.testing.assert_allclose(angle, np.radians(degrees), rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 1e-3, 30.0, 90.0, 150.0, 179.999, 180.0])
def test_angle_by_both_products_is_accurate_everywhere(degrees):
    a, b = pair(np.radians(degrees))
    angle = arctan2(length(cross(a, b)), dot(a, b))
    np.testing.assert_allclose(angle, np.radians(degrees), rtol=1e-6, atol=2e-7)


def test_dot_and_cross_of_random_vectors_obey_pythagoras():
    a, b = Vec3(*unit_vectors(1000, 1)), Vec3(*unit_vectors(1000, 2))
    c = cross(a, b)
    np.testing.assert_allclose(dot(a, b) ** 2 + dot(c, c), 1.0, atol=1e-6)
    np.testing.assert_allclose(dot(c, a), 0.0, atol=3e-7)


def test_cross_product_is_right_handed():
    x, y = Vec3(f(1), f(0), f(0)), Vec3(f(0), f(1), f(0))
    z = cross(x, y)
    assert (z.x, z.y, z.z) == (0.0, 0.0, 1.0)


def test_normalize_keeps_the_direction():
    v = Vec3(f([3.0]), f([0.0]), f([-4.0]))
    n = normalize(v)
    np.testing.assert_allclose([n.x[0], n.y[0], n.z[0]], [0.6, 0.0, -0.8], rtol=1e-6)
