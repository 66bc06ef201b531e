"""Polygons of any shape become triangles that cover them, once and nothing else."""

import time

import numpy as np
import pytest

from alight.scene.formats import obj, ply
from alight.scene.formats.ear_clipping import MOST_CORNERS, triangulated
from alight.scene.formats.triangles import fan

DART = [(0, 0), (2, 1), (0, 2), (0.5, 1)]
COMB = [(0, 0), (6, 0), (6, 3), (5, 1), (4, 3), (3, 1), (2, 3), (1, 1), (0, 3)]
# A square with a square hole, joined to the outside by an edge that is passed twice.
RING = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
STEPS = [(0, 0), (3, 0), (3, 1), (2, 1), (2, 2), (1, 2), (1, 3), (0, 3)]


def area(points):
    x, y = np.transpose(points)
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def in_space(points, turn):
    """A polygon of the plane, somewhere in space."""
    axes = np.linalg.qr(np.random.default_rng(turn).normal(size=(3, 3)))[0]
    return np.array(points, float) @ axes[:2] + axes[2]


def areas(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


@pytest.mark.parametrize("shape", [DART, COMB, RING, SQUARE, STEPS])
@pytest.mark.parametrize("turn", [1, 2, 3])
def test_triangles_cover_a_polygon_once(shape, turn):
    for first in range(len(shape)):
        for step in (1, -1):
            plane = np.roll(shape, first, axis=0)[::step]
            points = in_space(plane, turn)
            triangles = triangulated(points, np.array([len(points)]))
            assert triangles.shape == (len(shape) - 2, 3)
            # All have the sense of the polygon, so areas that add up do not overlap.
            found = areas(points, triangles)
            normal = found.sum(axis=0)
            assert np.linalg.norm(normal) == pytest.approx(abs(area(plane)))
            assert (found @ normal >= -1e-9).all()


def test_polygons_beside_each_other_keep_their_places():
    shapes = [SQUARE, DART, [(0, 0), (1, 0)], COMB, [(0, 0), (1, 0), (0, 1)], DART[::-1]]
    points = np.concatenate([in_space(shape, i) for i, shape in enumerate(shapes)])
    sizes = np.array([len(shape) for shape in shapes])
    triangles = triangulated(points, sizes)
    start = row = 0
    for i, shape in enumerate(shapes):
        own = triangles[row : row + max(len(shape) - 2, 0)]
        assert ((own >= start) & (own < start + len(shape))).all()
        alone = triangulated(in_space(shape, i), sizes[i : i + 1])
        np.testing.assert_array_equal(own - start, alone)
        start, row = start + len(shape), row + len(own)
    assert row == len(triangles)


def test_convex_ones_are_fans_and_others_end():
    np.testing.assert_array_equal(
        triangulated(in_space(SQUARE, 1), np.array([4])), [[0, 1, 2], [0, 2, 3]]
    )
    rng = np.random.default_rng(5)
    begin = time.process_time()
    for size in (5, 60, 5000):
        # Polygons that cut themselves have no true triangles; they have as many.
        assert len(triangulated(rng.normal(size=(size, 3)), np.array([size]))) == size - 2
    assert time.process_time() - begin < 5.0
    # Of very large ones, however they are cut, the time would have no bound.
    teeth = [(x, 3 - 2 * (x % 2)) for x in range(MOST_CORNERS, -1, -1)]
    large = in_space([(0, 0), (MOST_CORNERS, 0), *teeth], 1)
    sizes = np.array([len(large)])
    assert len(large) > MOST_CORNERS
    np.testing.assert_array_equal(triangulated(large, sizes), fan(sizes)[0])
    for points in (np.zeros((5, 3)), np.full((6, 3), np.nan)):
        assert len(triangulated(points, np.array([len(points)]))) == len(points) - 2


def test_mesh_files_have_concave_faces():
    points = in_space(COMB, 1).astype(np.float32)
    rows = "\n".join(f"v {x} {y} {z}" for x, y, z in points)
    corners = " ".join(map(str, range(1, 10)))
    head = "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    body = rows.replace("v ", "") + "\n9 " + " ".join(map(str, range(9))) + "\n"
    for mesh in (obj.read(f"{rows}\nf {corners}\n".encode()), ply.read((head + body).encode())):
        found = areas(mesh.vertices.astype(float), mesh.faces)
        assert np.linalg.norm(found, axis=1).sum() == pytest.approx(area(COMB))
