"""R = L - 2 (L . N) N, and the mirror of the local frame."""

import numpy as np

from alight.core.vec import dot, reflect
from lanewise.vec3 import Vec3
from tests.sampling.statistics import unit_vectors


def stack(v):
    return np.stack([v.x, v.y, v.z])


def test_reflection_is_l_minus_twice_l_dot_n_times_n():
    toward, n = unit_vectors(1000, 1), unit_vectors(1000, 2)
    # L travels towards the surface; our directions point away from it, so w = -L.
    expected = toward - 2.0 * np.sum(toward.astype(float) * n, axis=0) * n
    np.testing.assert_allclose(stack(reflect(Vec3(*-toward), Vec3(*n))), expected, atol=5e-7)


def test_reflection_at_45_degrees():
    f = np.float32
    w = Vec3(f([-0.6]), f([0.0]), f([0.8]))
    r = reflect(w, Vec3(f([0.0]), f([0.0]), f([1.0])))
    np.testing.assert_allclose(stack(r)[:, 0], [0.6, 0.0, 0.8], atol=1e-7)


def test_reflection_keeps_the_angle_and_the_plane():
    w, n = Vec3(*unit_vectors(1000, 3)), Vec3(*unit_vectors(1000, 4))
    r = reflect(w, n)
    np.testing.assert_allclose(dot(r, n), dot(w, n), atol=5e-7)
    np.testing.assert_allclose(dot(r, r), 1.0, atol=1e-6)
    normal_of_plane = np.cross(stack(w).T.astype(float), stack(n).T)
    np.testing.assert_allclose(np.sum(normal_of_plane * stack(r).T, axis=1), 0.0, atol=5e-7)


def test_reflecting_twice_changes_nothing():
    w, n = Vec3(*unit_vectors(1000, 5)), Vec3(*unit_vectors(1000, 6))
    np.testing.assert_allclose(stack(reflect(reflect(w, n), n)), stack(w), atol=1e-6)
