"""Subdivision by Catmull and Clark against closed forms, and triangles that lose nothing."""

import numpy as np
import pytest

from alight.meshes.polygons import Polygons, subdivided, triangulated, vertex_normals

CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def polygons(points, faces, **options):
    counts = np.array([len(face) for face in faces])
    return Polygons(np.asarray(points, float), counts, np.concatenate(faces), **options)


def edges_of_cube():
    pairs = {tuple(sorted(p)) for s in SIDES for p in zip(s, s[1:] + s[:1], strict=True)}
    return np.array(sorted(pairs))


def rounded(points):
    return {tuple(row) for row in np.round(np.abs(points), 9).tolist()}


def test_one_step_on_a_cube_gives_the_points_of_the_paper():
    fine = subdivided(polygons(CUBE, SIDES), 1)
    assert len(fine.counts) == 24
    assert (fine.counts == 4).all()
    # Faces keep their middles, edges go to 3/4, corners to 5/9.
    ninth = round(5 / 9, 9)
    expected = {(ninth,) * 3}
    expected |= {tuple(0.0 if i == k else 0.75 for i in range(3)) for k in range(3)}
    expected |= {tuple(1.0 if i == k else 0.0 for i in range(3)) for k in range(3)}
    assert rounded(fine.points) == expected
    assert (fine.origin == np.repeat(np.arange(6), 4)).all()


def test_faces_keep_their_outer_side():
    fine = subdivided(polygons(CUBE, SIDES), 2)
    triangles = triangulated(fine)
    a, b, c = (triangles.vertices[triangles.faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    original = triangulated(polygons(CUBE, SIDES))
    a, b, c = (original.vertices[original.faces[:, i]] for i in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0 == pytest.approx(8.0)
    assert 2.0 < volume < 4.5
    outward = np.einsum("ij,ij->i", vertex_normals(fine), fine.points)
    assert (outward > 0.5).all()


def test_a_cube_of_sharp_edges_stays_a_cube():
    mesh = polygons(CUBE, SIDES, creases=edges_of_cube(), sharpness=np.full(12, 10.0))
    fine = subdivided(mesh, 3)
    assert np.abs(fine.points).max(axis=1) == pytest.approx(np.ones(len(fine.points)))
    assert len(fine.counts) == 6 * 64


def test_sharpness_lasts_as_many_steps_as_it_says():
    mesh = polygons(CUBE, SIDES, creases=edges_of_cube(), sharpness=np.full(12, 1.0))
    once = subdivided(mesh, 1)
    np.testing.assert_allclose(once.points[:8], CUBE)
    twice = subdivided(mesh, 2)
    # The second step is a smooth one on the once divided cube: its corners have three faces.
    center, middle = np.array([0.5, 0.5, 1.0]), np.array([1.0, 1.0, 0.5])
    expected = (center.mean() * 1.0 + 2.0 * middle.mean()) / 3.0
    np.testing.assert_allclose(np.abs(twice.points[:8]), np.full((8, 3), expected))


def test_borders_follow_a_cubic_spline_and_corners_stay():
    row = np.arange(3.0)
    points = [[x, y, 0.0] for y in row for x in row]
    faces = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    points[1] = [1.0, -1.0, 0.0]
    fine = subdivided(polygons(points, faces), 1)
    np.testing.assert_allclose(fine.points[0], [0.0, 0.0, 0.0])
    np.testing.assert_allclose(fine.points[1], [1.0, (0.0 + 6.0 * -1.0 + 0.0) / 8.0, 0.0])


def test_an_edge_of_three_faces_is_sharp():
    """As one of a border is: no side is the other one. So all points stay where they are."""
    points, faces = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], []
    for angle in (0.0, 0.7, 2.0):
        faces.append([0, 1, len(points), len(points) + 1])
        points += [[x, np.cos(angle), np.sin(angle)] for x in (1.0, 0.0)]
    fine = subdivided(polygons(points, faces), 1)
    corners = np.array(points)[faces]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    wanted = np.concatenate([corners, middles, corners.mean(axis=1, keepdims=True)], axis=1)
    wanted = np.unique(np.round(wanted.reshape(-1, 3), 9), axis=0)
    np.testing.assert_allclose(np.unique(np.round(fine.points, 9), axis=0), wanted, atol=1e-8)


def test_pinned_vertices_stay():
    fine = subdivided(polygons(CUBE, SIDES, pinned=np.array([7])), 1)
    np.testing.assert_allclose(fine.points[7], CUBE[7])
    assert np.abs(fine.points[:7]).max() == pytest.approx(5 / 9)


def test_values_of_corners_are_interpolated_linearly():
    square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    uvs = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    mesh = polygons(square, [[0, 1, 2, 3]], values={"uvs": uvs})
    triangles = triangulated(subdivided(mesh, 2))
    # A plane square, whose corners stay: u = x, v = y everywhere.
    np.testing.assert_allclose(triangles.values["uvs"], triangles.vertices[:, :2], atol=1e-12)
    assert len(triangles.faces) == 32


def test_triangles_share_vertices_where_all_values_agree():
    square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.0]]
    faces = [[0, 1, 2, 3], [1, 4, 2]]
    shared = triangulated(polygons(square, faces))
    assert (len(shared.vertices), len(shared.faces)) == (5, 3)
    assert shared.origin.tolist() == [0, 0, 1]
    values = np.arange(7.0)[:, None]
    split = triangulated(polygons(square, faces, values={"colors": values}))
    assert len(split.vertices) == 7
    for face, row in zip(split.faces, [[0, 1, 2], [0, 2, 3], [4, 5, 6]], strict=True):
        assert split.values["colors"][face, 0].tolist() == row


def test_normals_weigh_faces_by_area():
    # A long and a short wall meet: the normal leans to the larger one.
    points = [[0, 0, 0], [0, 0, 1], [3, 0, 1], [3, 0, 0], [0, 1, 0], [0, 1, 1]]
    mesh = polygons(points, [[0, 1, 2, 3], [0, 4, 5, 1]])
    normal = vertex_normals(mesh)[0]
    np.testing.assert_allclose(normal, np.array([1.0, 3.0, 0.0]) / np.sqrt(10.0), atol=1e-12)
