"""Orthonormal frames."""

import numpy as np
import pytest

from alight.core.frame import frame_from_normal, frame_from_tangent, to_local, to_world
from alight.core.vec import cross, dot
from lanewise.vec3 import Vec3
from tests.sampling.statistics import unit_vectors

POLES = np.array(
    [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0], [1e-4, 0, -1], [0, 1e-20, -1], [1, 0, -0.0]]
)


def normals():
    """Random ones, and those at which older constructions fail (z = -1 and beside it)."""
    near_pole = np.stack([1e-4 * unit_vectors(2000, 2)[0], 1e-4 * unit_vectors(2000, 3)[0]])
    near_pole = np.stack([*near_pole, -np.sqrt(1.0 - (near_pole**2).sum(0))])
    poles = POLES.T / np.linalg.norm(POLES, axis=1)
    return np.concatenate([unit_vectors(20_000, 1), near_pole, poles], 1).astype(np.float32)


def assert_right_handed_and_orthonormal(s, t, n, atol=5e-7):
    for a in (s, t, n):
        np.testing.assert_allclose(dot(a, a), 1.0, atol=atol)
    for a, b in ((s, t), (s, n), (t, n)):
        np.testing.assert_allclose(dot(a, b), 0.0, atol=atol)
    w = cross(s, t)
    for seen, expected in zip((w.x, w.y, w.z), (n.x, n.y, n.z), strict=True):
        np.testing.assert_allclose(seen, expected, atol=atol)


def test_frame_from_normal_is_right_handed_and_orthonormal():
    n = Vec3(*normals())
    s, t = frame_from_normal(n)
    assert_right_handed_and_orthonormal(s, t, n)


@pytest.mark.parametrize("angle", [1.5, 0.5, 0.01, 0.0])
def test_frame_from_tangent_is_right_handed_and_orthonormal(angle):
    n = Vec3(*normals())
    side, _ = frame_from_normal(n)
    tangent = 3.0 * (np.float32(np.cos(angle)) * n + np.float32(np.sin(angle)) * side)
    s, t = frame_from_tangent(n, tangent)
    assert_right_handed_and_orthonormal(s, t, n)
    if angle > 0.0:
        # s is the part of the tangent along the surface.
        assert np.min(dot(s, tangent)) > 0.0
        np.testing.assert_allclose(dot(t, tangent), 0.0, atol=3e-6)


def test_frame_from_a_zero_tangent_is_some_frame():
    n = Vec3(*normals())
    zero = np.zeros_like(n.x)
    assert_right_handed_and_orthonormal(*frame_from_tangent(n, Vec3(zero, zero, zero)), n)


def test_to_world_undoes_to_local():
    n = Vec3(*unit_vectors(5000, 4))
    s, t = frame_from_normal(n)
    w = unit_vectors(5000, 5)
    local = to_local(s, t, n, Vec3(*w))
    back = to_world(s, t, n, local)
    np.testing.assert_allclose(np.stack([back.x, back.y, back.z]), w, atol=1e-6)
    np.testing.assert_array_equal(local.z, dot(Vec3(*w), n))


def test_local_z_is_the_normal_and_local_x_the_tangent():
    f = np.float32
    n, tangent = Vec3(f([0.0]), f([0.0]), f([1.0])), Vec3(f([0.0]), f([2.0]), f([0.0]))
    s, t = frame_from_tangent(n, tangent)
    local = to_local(s, t, n, Vec3(f([1.0]), f([2.0]), f([3.0])))
    assert (local.x[0], local.y[0], local.z[0]) == (2.0, -1.0, 3.0)
