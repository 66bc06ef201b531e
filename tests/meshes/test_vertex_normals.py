"""Vertex normals of meshes without any: the faces around, weighted by angle."""

from itertools import product

import numpy as np
import pytest

from alight.meshes.normals import vertex_normals

CORNERS = np.array([*product((-1.0, 1.0), repeat=3)], np.float32)
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.mark.parametrize("cuts", [0, 0b111111, 0b010110])
def test_normals_of_a_box_do_not_depend_on_how_its_sides_are_cut(cuts):
    """Three right angles meet at each corner, whatever the areas of the sides are."""
    faces = []
    for i, side in enumerate(SIDES):
        a, b, c, d = side if cuts >> i & 1 else side[1:] + side[:1]
        faces += [[a, b, c], [a, c, d]]
    box = CORNERS * np.float32([1.0, 2.0, 5.0])
    found = vertex_normals(box, np.array(faces, np.int32))
    np.testing.assert_allclose(found, CORNERS / np.sqrt(3.0), atol=1e-6)


def test_vertices_without_a_face_have_no_normal():
    found = vertex_normals(CORNERS, np.array([[0, 4, 6]], np.int32))
    assert np.all(found[[1, 2, 3, 5, 7]] == 0.0)
    np.testing.assert_array_equal(found[[0, 4, 6]], [[0.0, 0.0, 1.0]] * 3)
