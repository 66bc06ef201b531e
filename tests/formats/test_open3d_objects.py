"""Objects of Open3D, by stand-ins of the same interface: what they hold is what is shown."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats import load
from alight.formats.objects import Look, package_of
from alight.formats.objects.open3d_objects import read
from alight.meshes.triangles import srgb_to_linear

POINTS = np.array([[0, 0, 0], [2, 0, 0.5], [2, 1, 0], [0, 1, 0.25]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
COLORS = np.array([[1, 0, 0], [0, 0.5, 0], [0, 0, 0.25], [0.75, 0.5, 0.25]])
NORMALS = np.array([[0, 0, 1], [0, 0.6, 0.8], [0.6, 0, 0.8], [0, -0.6, 0.8]])
#: Of each corner of each face; no two corners of a vertex share them.
UVS = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.4, 0.2], [0.6, 0.7], [0.1, 0.9]])
TEXELS = np.arange(5 * 7 * 4, dtype=np.uint8).reshape(5, 7, 4)


def of_open3d(kind):
    kind.__module__ = "open3d.geometry"
    return kind


@of_open3d
class TriangleMesh:
    def __init__(self, faces=FACES, normals=None, colors=None, uvs=None, textures=()):
        self.vertices, self.triangles = POINTS, faces
        self.vertex_normals, self.vertex_colors = normals, colors
        self.triangle_uvs, self.textures = uvs, list(textures)

    def has_vertex_normals(self):
        return self.vertex_normals is not None

    def has_vertex_colors(self):
        return self.vertex_colors is not None

    def has_triangle_uvs(self):
        return self.triangle_uvs is not None

    def has_textures(self):
        return bool(self.textures)


@of_open3d
class PointCloud:
    def __init__(self, colors=None):
        self.points, self.colors = POINTS, colors

    def has_colors(self):
        return self.colors is not None


@of_open3d
class LineSet(PointCloud):
    lines = ()


@of_open3d
class Tensors:
    def __init__(self, legacy):
        self.legacy = legacy

    def to_legacy(self):
        return self.legacy


def piece_of(value):
    (piece,) = read(value, Look()).pieces
    return piece


def test_it_is_known_by_its_module_and_seen_like_the_same_arrays():
    value = TriangleMesh(colors=COLORS)
    assert package_of(value) == "open3d"
    ours, arrays = load(value), load((POINTS, FACES, COLORS), up="y")
    assert dict(ours) == dict(arrays)
    assert ours.camera is not None


def test_a_mesh_keeps_its_tables():
    piece = piece_of(TriangleMesh(normals=NORMALS, colors=COLORS))
    assert np.array_equal(piece.vertices, POINTS) and np.array_equal(piece.faces, FACES)
    assert np.array_equal(piece.normals, NORMALS)
    assert np.allclose(piece.colors, srgb_to_linear(np.float32(COLORS)), atol=1e-6)
    assert piece.uvs is None and piece.picture is None
    plain = piece_of(TriangleMesh())
    assert plain.normals is None and plain.colors is None


def test_each_corner_of_a_textured_mesh_sees_its_own_texel():
    piece = piece_of(TriangleMesh(normals=NORMALS, colors=COLORS, uvs=UVS, textures=[TEXELS, None]))
    corners = FACES.reshape(-1)
    assert np.array_equal(piece.vertices[piece.faces.reshape(-1)], POINTS[corners])
    assert np.array_equal(piece.normals[piece.faces.reshape(-1)], NORMALS[corners])
    assert piece.colors is None
    # Our pictures have v = 1 at the top, and its first row is the lowest.
    texels = np.asarray(piece.picture.whole)
    rows, columns = texels.shape[:2]
    for u, v in piece.uvs[piece.faces.reshape(-1)]:
        row, column = int(v * rows), int(u * columns)
        assert np.array_equal(texels[rows - 1 - row, column], TEXELS[row, column, :3])
    assert np.array_equal(piece.uvs, UVS)


@pytest.mark.parametrize("textures", [[], [np.zeros((0, 0, 3), np.uint8)]])
def test_without_a_picture_its_colours_are_seen(textures):
    piece = piece_of(TriangleMesh(colors=COLORS, uvs=UVS, textures=textures))
    assert piece.picture is None and len(piece.vertices) == len(POINTS)
    assert piece.colors is not None


@pytest.mark.parametrize("colors", [None, COLORS])
def test_a_cloud_of_points_is_balls(colors):
    again = load(Tensors(PointCloud(colors)), point_radius=0.2)
    assert dict(load(PointCloud(colors), point_radius=0.2)) == dict(again)
    balls = piece_of(PointCloud(colors))
    middles = balls.vertices.reshape(len(POINTS), -1, 3).mean(axis=1)
    assert np.allclose(middles, POINTS, atol=1e-3)
    assert (balls.colors is None) == (colors is None)


def test_tensors_are_read_as_what_they_stand_for():
    value = TriangleMesh(normals=NORMALS, colors=COLORS)
    assert dict(load(Tensors(value))) == dict(load(value))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (TriangleMesh(np.zeros((0, 3), np.int32)), "at least one triangle"),
        (LineSet(), "a LineSet has no surface: give a TriangleMesh or PointCloud"),
    ],
)
def test_what_has_no_surface_is_refused(value, message):
    with pytest.raises(SceneError, match=message):
        load(value)
