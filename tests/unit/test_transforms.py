"""Transforms against closed forms: rotations, order, normals, the look-at basis."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alight.core.errors import SceneError
from alight.scene.transform import (
    IDENTITY,
    Transform,
    look_at,
    matrix,
    rotate,
    scale,
    translate,
)

COS, SIN = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
finite = st.floats(-100.0, 100.0)
vectors = st.tuples(finite, finite, finite)


@pytest.mark.parametrize(
    ("axis", "rows"),
    [
        ("x", [[1, 0, 0], [0, COS, -SIN], [0, SIN, COS]]),
        ("y", [[COS, 0, SIN], [0, 1, 0], [-SIN, 0, COS]]),
        ("z", [[COS, -SIN, 0], [SIN, COS, 0], [0, 0, 1]]),
    ],
)
def test_rotation_about_each_axis_is_the_textbook_matrix(axis, rows):
    np.testing.assert_allclose(rotate(axis, 30.0).matrix[:3, :3], rows, atol=1e-15)


def test_rotation_about_the_diagonal_by_120_degrees_permutes_the_axes():
    turned = rotate((1, 1, 1), 120.0)
    np.testing.assert_allclose(turned.apply_point((1, 2, 3)), (3, 1, 2), atol=1e-15)


@pytest.mark.parametrize("turns", [-5, -2, -1, 0, 1, 2, 3, 4, 7])
def test_quarter_turns_are_exact(turns):
    entries = rotate("y", 90.0 * turns).matrix
    assert set(np.abs(entries).ravel()) <= {0.0, 1.0}
    angle = math.radians(90.0 * turns)
    np.testing.assert_allclose(entries[0, 2], math.sin(angle), atol=1e-12)


@given(axis=vectors.filter(lambda v: max(map(abs, v)) > 1e-3), angle=st.floats(-720.0, 720.0))
def test_rotations_are_orthogonal_and_keep_handedness(axis, angle):
    linear = rotate(axis, angle).matrix[:3, :3]
    np.testing.assert_allclose(linear @ linear.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(linear), 1.0, atol=1e-12)


def test_trs_scales_first_and_translates_last():
    composed = translate(10, 0, 0) @ rotate("z", 90.0) @ scale(2.0)
    # (1, 0, 0) -> (2, 0, 0) -> (0, 2, 0) -> (10, 2, 0)
    np.testing.assert_allclose(composed.apply_point((1, 0, 0)), (10, 2, 0), atol=1e-15)
    assert [step.name for step in composed.steps] == ["scale", "rotate", "translate"]


def test_vectors_ignore_translation():
    np.testing.assert_array_equal(translate(1, 2, 3).apply_vector((4, 5, 6)), (4, 5, 6))


@given(
    factors=st.tuples(*[st.floats(0.1, 10.0) | st.floats(-10.0, -0.1)] * 3),
    axis=vectors.filter(lambda v: max(map(abs, v)) > 1e-3),
    angle=st.floats(-180.0, 180.0),
    u=vectors,
    v=vectors,
)
def test_normals_stay_perpendicular_to_transformed_tangents(factors, axis, angle, u, v):
    moved = rotate(axis, angle) @ scale(*factors)
    normal = moved.apply_normal(np.cross(u, v))
    size = np.linalg.norm(normal) * max(np.linalg.norm(moved.apply_vector(u)), 1e-300)
    assert abs(normal @ moved.apply_vector(u)) <= 1e-10 * max(size, 1.0)


def test_normal_of_a_slope_under_a_non_uniform_scale():
    # The plane x + y = 0 has normal (1, 1, 0); stretched by 2 in x it is x / 2 + y = 0.
    normal = scale(2.0, 1.0, 1.0).apply_normal((1, 1, 0))
    np.testing.assert_allclose(normal / normal[1], (0.5, 1.0, 0.0))


def test_look_at_basis():
    camera = look_at((1, 2, 3), (1, 2, -7), (0, 5, 0))
    np.testing.assert_allclose(camera.apply_vector((0, 0, -1)), (0, 0, -1), atol=1e-15)
    np.testing.assert_allclose(camera.apply_vector((1, 0, 0)), (1, 0, 0), atol=1e-15)
    np.testing.assert_allclose(camera.apply_point((0, 0, 0)), (1, 2, 3))
    side = look_at((5, 0, 0), (0, 0, 0))
    np.testing.assert_allclose(side.apply_vector((0, 0, -1)), (-1, 0, 0), atol=1e-15)
    # Looking along -x with +y up, +z is to the left, so the right is -z.
    np.testing.assert_allclose(side.apply_vector((1, 0, 0)), (0, 0, -1), atol=1e-15)


@given(origin=vectors, target=vectors, up=vectors)
def test_look_at_is_a_right_handed_orthonormal_frame_or_refused(origin, target, up):
    try:
        camera = look_at(origin, target, up)
    except SceneError:
        return
    linear = camera.matrix[:3, :3]
    np.testing.assert_allclose(linear.T @ linear, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(linear), 1.0, atol=1e-9)
    view = np.subtract(target, origin) / np.linalg.norm(np.subtract(target, origin))
    np.testing.assert_allclose(camera.apply_vector((0, 0, -1)), view, atol=1e-9)
    assert camera.apply_vector((0, 1, 0)) @ np.array(up) >= 0.0


@pytest.mark.parametrize(
    ("origin", "target", "up", "message"),
    [
        ((0, 0, 0), (0, 0, 0), (0, 1, 0), "target must differ from origin"),
        ((0, 0, 0), (0, 5, 0), (0, 1, 0), "must not be parallel to the view"),
        ((0, 5, 0), (0, 0, 0), (0, 1, 0), "must not be parallel to the view"),
        ((0, 0, 0), (0, 0, 1), (0, 0, 0), "up must not have length 0"),
    ],
)
def test_look_at_refuses_what_gives_no_frame(origin, target, up, message):
    with pytest.raises(SceneError, match=message):
        look_at(origin, target, up)


def test_inverse_undoes():
    moved = translate(1, 2, 3) @ rotate((1, 2, 3), 40.0) @ scale(2, -3, 0.5)
    np.testing.assert_allclose((moved.inverse() @ moved).matrix, np.eye(4), atol=1e-14)


def test_singular_matrices_are_found_whatever_their_scale():
    assert scale(1, 1, 0).is_singular
    assert matrix([[1, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).is_singular
    assert not scale(1e-6).is_singular
    assert not scale(1e9, 1e-3, 1).is_singular
    with pytest.raises(SceneError, match="singular"):
        scale(0).inverse()


def test_mirrors_flip_handedness():
    assert scale(-1, 1, 1).flips_handedness
    assert scale(-1).flips_handedness
    assert not scale(-1, -1, 1).flips_handedness
    assert not rotate("x", 77).flips_handedness


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([[1, 0], [0, 1]], "shape"),
        (np.full((4, 4), np.nan), "finite"),
        (np.ones((4, 4)), "last row"),
    ],
)
def test_matrix_refuses_what_is_no_affine_map(rows, message):
    with pytest.raises(SceneError, match=message):
        matrix(rows)


def test_value_semantics():
    assert translate(1, 2, 3) == translate(1, 2, 3)
    assert hash(translate(0.0, 0, 0)) == hash(translate(-0.0, 0, 0)) == hash(IDENTITY)
    assert translate(1, 2, 3) != translate(1, 2, 4)
    assert isinstance(IDENTITY @ IDENTITY, Transform)
    with pytest.raises(ValueError, match="read-only"):
        translate(1, 2, 3).matrix[0, 0] = 5.0
