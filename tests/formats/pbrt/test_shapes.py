"""Shapes of pbrt: what a file says becomes the shape that was meant."""

import gzip
import math

import numpy as np
import pytest

from alight.meshes.ply import save
from alight.meshes.triangles import MeshArrays
from alight.shapes.mesh import Mesh
from tests.formats.pbrt.reading import (
    messages,
    node,
    read,
    world,
)

TENT = '"point3 P" [0 0 0  1 0 0  1 1 0  0 1 1] "integer indices" [0 1 2  0 2 3]'
CHECKS = 'Texture "c" "spectrum" "checkerboard"\nMaterial "diffuse" "texture reflectance" "c"\n'


def test_triangles():
    mesh = node(read(f'Shape "trianglemesh" {TENT}')).shape
    np.testing.assert_array_equal(mesh.vertices[3], [0, 1, 1])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3]])
    assert mesh.normals is None
    assert mesh.uvs is None
    normals = '"normal N" [0 0 -1 0 0 -1 0 0 -1 0 0 -1] "point2 uv" [0 0 1 0 1 1 0 1]'
    mesh = node(read(f'Shape "trianglemesh" {TENT} {normals}')).shape
    # The sides of triangles are those of their normals.
    np.testing.assert_array_equal(mesh.faces, [[0, 2, 1], [0, 3, 2]])
    np.testing.assert_array_equal(mesh.uvs[2], [1, 1])


def test_triangles_without_coordinates_have_pbrts_where_a_texture_shows_them():
    mesh = node(read(f'{CHECKS}Shape "trianglemesh" {TENT}')).shape
    np.testing.assert_array_equal(mesh.uvs, [[0, 0], [1, 0], [1, 1]] * 2)
    np.testing.assert_array_equal(mesh.vertices[mesh.faces[1]], [[0, 0, 0], [1, 1, 0], [0, 1, 1]])


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("reverse", [False, True])
def test_sides_of_surfaces(mirrored, reverse):
    before = ("Scale -1 1 1\n" if mirrored else "") + ("ReverseOrientation\n" if reverse else "")
    for shape in ('"sphere"', '"disk"', '"cylinder"', '"sphere" "float zmax" .5'):
        found = node(read(f"{before}Shape {shape}")).shape
        assert found.flip_normals == (mirrored != reverse), shape
    assert node(read(f'{before}Shape "trianglemesh" {TENT}')).shape.flip_normals == reverse


def test_ply_files_packed_or_not(tmp_path):
    arrays = MeshArrays(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
    save(tmp_path / "m.ply", arrays)
    (tmp_path / "m.ply.gz").write_bytes(gzip.compress((tmp_path / "m.ply").read_bytes()))
    for name in ("m.ply", "m.ply.gz"):
        shape = f'Shape "plymesh" "string filename" "{name}"'
        scene = read(f"{shape}\n{shape}", folder=tmp_path)
        first, second = (n.shape for n in scene.nodes.values())
        # One mesh in memory, however often it stands there.
        assert first is second
        np.testing.assert_array_equal(first.vertices, arrays.vertices)
    (tmp_path / "bad.ply.gz").write_bytes(b"\x1f\x8b" + bytes(30))
    [message] = messages('Shape "plymesh" "string filename" "bad.ply.gz"', folder=tmp_path)
    assert "cannot read" in message


def test_disks_and_cylinders():
    scene = read('Shape "disk" "float radius" 3 "float height" 2')
    assert world(scene, (1, 0, 0)) == [3, 0, 2]
    shape = node(read('Shape "cylinder" "float radius" 2 "float zmin" -3 "float zmax" 1')).shape
    assert (shape.p0, shape.p1, shape.radius) == ((0, 0, -3), (0, 0, 1), 2.0)


def test_parts_of_shapes_with_formulas_are_meshes():
    scene = read('Shape "sphere" "float radius" 2 "float zmin" 0 "float phimax" 180')
    mesh = node(scene).shape
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 2.0, rtol=1e-6)
    assert mesh.vertices.min(axis=0) == pytest.approx([-2, 0, 0], abs=1e-6)
    # u goes around, v from the lower to the upper end.
    at = int(np.flatnonzero((mesh.uvs == [0.5, 0.0]).all(axis=1))[0])
    np.testing.assert_allclose(mesh.vertices[at], [0, 2, 0], atol=1e-6)
    assert area(mesh) == pytest.approx(4 * math.pi, rel=1e-3)
    assert any("part of a sphere" in warning for warning in scene.warnings)
    ring = node(read('Shape "disk" "float radius" 2 "float innerradius" 1')).shape
    assert area(ring) == pytest.approx(3 * math.pi, rel=1e-3)
    tube = node(read('Shape "cylinder" "float phimax" 90')).shape
    assert area(tube) == pytest.approx(math.pi, rel=1e-3)
    for part in (mesh, ring, tube):
        a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
        across = np.cross(b - a, c - a)
        assert ((across * part.normals[part.faces[:, 0]]).sum(axis=1) > -1e-9).all()


def area(mesh: Mesh) -> float:
    assert mesh.vertices is not None
    assert mesh.faces is not None
    a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_texture_of_a_sphere_hangs_as_in_pbrt():
    scene = read(f'{CHECKS}Shape "sphere"')
    # Our v runs from the pole +z of the node; pbrt's reaches 1 there.
    assert world(scene, (0, 0, 1)) == [0, 0, -1]
    assert world(scene, (1, 0, 0)) == [1, 0, 0]


def test_bilinear_patches():
    flat = '"point3 P" [0 0 0  2 0 0  0 1 0  2 1 0]'
    mesh = node(read(f'Shape "bilinearmesh" {flat}')).shape
    assert (len(mesh.faces), area(mesh)) == (2, pytest.approx(2.0))
    np.testing.assert_array_equal(mesh.uvs[mesh.vertices.tolist().index([2, 0, 0])], [1, 0])
    scene = read('Shape "bilinearmesh" "point3 P" [0 0 0  2 0 0  0 1 0  2 1 1]')
    mesh = node(scene).shape
    middle = int(np.flatnonzero((mesh.uvs == 0.5).all(axis=1))[0])
    np.testing.assert_allclose(mesh.vertices[middle], [1, 0.5, 0.25], atol=1e-6)
    # Across the two directions there: (2, 0, 1/2) and (0, 1, 1/2).
    normal = np.cross([2, 0, 0.5], [0, 1, 0.5])
    np.testing.assert_allclose(mesh.normals[middle], normal / np.linalg.norm(normal), atol=1e-6)
    assert any("is not flat" in warning for warning in scene.warnings)
