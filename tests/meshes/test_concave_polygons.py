"""Polygons of mesh files are covered by their triangles, whatever their shape."""

import numpy as np
import pytest

import alight
from alight.meshes import obj, ply
from alight.meshes.concave import MOST_EARS, cut_polygons

#: An L whose first corner does not see its last arm, counter-clockwise.
ELL = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]]
#: A square frame, cut open along a seam at its lower left.
RING = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0], [1, 1], [1, 3], [3, 3], [3, 1], [1, 1]]
#: Long teeth: no corner sees all of it.
COMB = [[0, 0], [7, 0], [7, 5], [6, 5], [6, 1], [5, 1], [5, 5], [4, 5], [4, 1], [3, 1], [3, 5]]
COMB += [[2, 5], [2, 1], [1, 1], [1, 5], [0, 5]]
#: A dart, its reflex corner opposite the first one or beside it.
DART = [[0, 0], [2, -1], [1, 0], [2, 1]]


def spiral(turns, steps):
    """Two arms of a spiral: the hardest shape for ears."""
    angle = np.linspace(0.0, 2.0 * np.pi * turns, steps)
    outer = np.stack([(angle + 4.0) * np.cos(angle), (angle + 4.0) * np.sin(angle)], axis=1)
    inner = np.stack([(angle + 2.0) * np.cos(angle), (angle + 2.0) * np.sin(angle)], axis=1)
    return np.concatenate([outer, inner[::-1]])


def star(corners, seed):
    """A polygon around the origin with a random radius at each angle."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    return rng.uniform(0.1, 1.0, corners)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)


def somewhere(flat, seed):
    """Points of a plane in space, in float32 as files have them; across an axis below 0."""
    rng = np.random.default_rng(abs(seed))
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    if seed < 0:
        axes = np.roll(np.eye(3), seed, axis=0)
    return (np.asarray(flat, float) @ axes[:2] + rng.normal(size=3)).astype(np.float32)


def area_vectors(points, triangles):
    a, b, c = (np.asarray(points, float)[triangles[:, i]] for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


@pytest.mark.parametrize(
    "flat",
    [ELL, RING, COMB, DART, np.roll(DART, 1, axis=0), spiral(3, 60), star(9, 1), star(40, 2)],
    ids=["ell", "ring", "comb", "dart", "dart_turned", "spiral", "star9", "star40"],
)
@pytest.mark.parametrize("turned", [False, True])
def test_no_triangle_covers_what_the_polygon_does_not(flat, turned):
    flat = np.asarray(flat, float)[::-1] if turned else np.asarray(flat, float)
    for seed in range(-3, 3):
        for first in range(0, len(flat), max(len(flat) // 6, 1)):
            points = somewhere(np.roll(flat, first, axis=0), seed)
            triangles, polygon = cut_polygons(points, np.array([len(points)]))
            assert triangles.shape == (len(points) - 2, 3)
            assert (polygon == 0).all()
            areas = area_vectors(points, triangles)
            # Turned triangles, or such as overlap, make the sum of the areas larger than its size.
            total = np.linalg.norm(areas, axis=1).sum()
            assert total == pytest.approx(np.linalg.norm(areas.sum(axis=0)), rel=1e-5)
            x, y = flat.T
            shoelace = 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
            assert total == pytest.approx(shoelace, rel=1e-5)


def test_convex_polygons_stay_fans_from_their_first_corner():
    angle = np.linspace(0.0, 2.0 * np.pi, 7, endpoint=False)
    round_one = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    bent_quad = np.array([[0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.3]])
    points = np.concatenate([bent_quad, round_one, somewhere(ELL, 0)])
    triangles, polygon = cut_polygons(points, np.array([4, 7, 6]))
    assert triangles[:2].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert triangles[2:7].tolist() == [[4, 4 + i, 5 + i] for i in range(1, 6)]
    assert polygon.tolist() == [0] * 2 + [1] * 5 + [2] * 4
    assert triangles[7:].min() == 11


def test_polygons_that_make_no_sense_end_soon_with_as_many_triangles():
    bow_tie = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]]
    rng = np.random.default_rng(3)
    scribble = rng.normal(size=(200, 3))
    point, line = np.zeros((6, 3)), np.arange(18.0).reshape(6, 3)
    broken = np.full((5, 3), np.nan)
    parts = [np.array(bow_tie, float), scribble, point, line, broken]
    sizes = np.array([len(part) for part in parts])
    with np.errstate(invalid="ignore"):
        triangles, _ = cut_polygons(np.concatenate(parts), sizes)
    assert len(triangles) == (sizes - 2).sum()
    assert (triangles >= 0).all()
    assert (triangles < sizes.sum()).all()
    assert cut_polygons(np.zeros((3, 3)), np.array([1, 2]))[0].shape == (0, 3)


def test_the_work_for_a_file_is_bounded(monkeypatch):
    monkeypatch.setattr("alight.meshes.concave.MOST_EARS", 2 * len(COMB))
    assert MOST_EARS > 1000
    points = np.concatenate([somewhere(COMB, seed) for seed in range(3)])
    triangles, polygon = cut_polygons(points, np.full(3, len(COMB)))
    sums = [
        np.linalg.norm(area_vectors(points, triangles[polygon == i]), axis=1).sum()
        for i in range(3)
    ]
    assert sums[:2] == pytest.approx([23.0, 23.0], rel=1e-5)
    assert sums[2] > 24.0


def test_files_with_concave_faces_keep_their_holes(tmp_path):
    points = np.round(somewhere(RING, 5), 4)
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in points.tolist())
    face = " ".join(str(i + 1) for i in range(len(points)))
    model = tmp_path / "ring.obj"
    model.write_text(f"{text}f {face}\n")
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in points.tolist())
    header = f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 2\nproperty list uchar int vertex_indices\n"
    corners = " ".join(map(str, range(len(points))))
    faces = f"3 0 1 2\n10 {corners}\n"
    scan = f"ply\nformat ascii 1.0\n{header}end_header\n{rows}{faces}".encode()
    for mesh, first in ((obj.read(model.read_bytes()), 0), (ply.read(scan), 1)):
        areas = area_vectors(mesh.vertices, mesh.faces[first:])
        assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(12.0, rel=1e-3)
    shape = next(n for _, _, n in alight.load(model).walk() if n.shape is not None).shape
    assert np.linalg.norm(area_vectors(shape.vertices, shape.faces), axis=1).sum() < 12.1
