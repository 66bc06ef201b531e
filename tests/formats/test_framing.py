"""Models without a camera fill the picture, whatever their shape and the picture's."""

import itertools

import numpy as np
import pytest

from alight.cameras.basis import perspective_half_extents, project_points
from alight.formats import load
from alight.formats.geometry.bounds import FOV, MARGIN, NEAREST, Bounds
from alight.meshes import ply
from alight.meshes.triangles import MeshArrays
from alight.scene import flatten

# Two triangles for each side of a box; windings do not matter here.
CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
FACES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]]
BOXES = [(1, 1, 1), (9, 1, 1), (1, 9, 1), (1, 1, 9), (9, 0, 9), (9, 9, 0), (0, 9, 9), (9, 0, 0)]
# Towards the automatic camera.
RIGHT, ABOVE = np.radians([30.0, 20.0])
TOWARDS = np.array([np.sin(RIGHT) * np.cos(ABOVE), np.sin(ABOVE), np.cos(RIGHT) * np.cos(ABOVE)])


def write(path, points):
    faces = np.array(FACES, np.int32)
    ply.save(path, MeshArrays(np.asarray(points, np.float32), faces, None, None, None))


def seen(path, size=None, changes=()):
    """Vertices in the picture, from 0 to 1 in both directions, and depths."""
    sizes = [] if size is None else [f"film.size=[{size[0]}, {size[1]}]"]
    flat = flatten(load(path, [*sizes, *changes]))
    placed, size = flat.camera, flat.film.size
    lens = dict(placed.camera)
    extents = perspective_half_extents(lens["fov"], lens["fov_axis"], *size)
    points = flat.geometries[0].vertices
    film = project_points(points, extents, size, placed.to_world, perspective=True)
    return film[:, :2] / size, film[:, 2]


@pytest.mark.parametrize("size", [None, (600, 800), (300, 300), (1600, 200), (200, 1600)])
@pytest.mark.parametrize("sides", BOXES)
def test_a_box_touches_the_margin_on_two_opposite_sides(sides, size, tmp_path):
    write(tmp_path / "box.ply", (CORNERS * sides + (5.0, -3.0, 2.0)) * 0.01)
    places, _ = seen(tmp_path / "box.ply", size)
    low, high = places.min(axis=0), places.max(axis=0)
    assert (low >= MARGIN - 1e-5).all()
    assert (high <= 1.0 - MARGIN + 1e-5).all()
    assert (high - low).max() == pytest.approx(1.0 - 2.0 * MARGIN, abs=1e-4)


def test_vertices_count_not_the_corners_of_their_box(tmp_path):
    # An octahedron's box has corners far outside of it.
    points = [*np.eye(3), *-np.eye(3), [0, 0, 0], [0, 0, 0]]
    write(tmp_path / "octahedron.ply", points)
    places, _ = seen(tmp_path / "octahedron.ply")
    assert (places.max(axis=0) - places.min(axis=0)).max() == pytest.approx(0.9, abs=1e-4)


def test_a_rod_that_points_at_the_camera_is_seen_from_a_distance(tmp_path):
    ends = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])[:, None]
    write(tmp_path / "rod.ply", 10.0 * ends * TOWARDS + 0.001 * CORNERS)
    _, depths = seen(tmp_path / "rod.ply")
    assert depths.min() == pytest.approx(5.0 * NEAREST, rel=1e-2)


def test_a_camera_that_was_chosen_stays(tmp_path):
    write(tmp_path / "box.ply", CORNERS)
    lens = "camera.fov=10"
    (near, depths), (far, others) = (
        seen(tmp_path / "box.ply", size, [lens]) for size in ((800, 600), (80, 60))
    )
    np.testing.assert_array_equal(depths, others)
    np.testing.assert_allclose(near, far)


@pytest.mark.parametrize("points", [[], [[7.0, 8.0, 9.0]], [[0.0, 0.0, 0.0]] * 4])
def test_nothing_and_a_point_are_seen_as_from_outside_a_unit_sphere(points):
    bounds = Bounds()
    if points:
        bounds.add(points, np.eye(4))
    origin, target = bounds.viewpoint((800, 600))
    center = points[0] if points else [0.0, 0.0, 0.0]
    np.testing.assert_allclose(
        np.subtract(origin, center) / np.linalg.norm(np.subtract(origin, center)), TOWARDS
    )
    np.testing.assert_allclose(target, center, atol=1e-12)
    tangent = np.tan(0.5 * np.radians(FOV)) * 600 / 800 * (1.0 - 2.0 * MARGIN)
    distance = np.linalg.norm(np.subtract(origin, target))
    assert distance == pytest.approx(1.0 / np.sin(np.arctan(tangent)))
