"""Water that is computed: what its formula promises, and that the mesh is its surface."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats import load, loads, save
from alight.scene.builtin import waves

MESH = waves.builtin_mesh("builtin:waves")
NORMALS = MESH.normals
assert NORMALS is not None
SIDE = waves.CELLS + 1


def test_vertices_lie_on_the_water():
    x, y, z = MESH.vertices.astype(float).T
    assert np.allclose(y, waves.height(x, z)[0], atol=1e-7)
    assert {x.min(), x.max(), z.min(), z.max()} == {-1.0, 1.0}


def test_normals_are_those_of_the_water():
    x, _, z = MESH.vertices.astype(float).T
    step = 1e-5
    along_x = (waves.height(x + step, z)[0] - waves.height(x - step, z)[0]) / (2.0 * step)
    along_z = (waves.height(x, z + step)[0] - waves.height(x, z - step)[0]) / (2.0 * step)
    nx, ny, nz = NORMALS.astype(float).T
    assert (ny > 0.0).all()
    assert np.allclose([-nx / ny, -nz / ny], [along_x, along_z], atol=1e-6)


def test_triangles_cover_the_square_and_look_up():
    a, b, c = (MESH.vertices[MESH.faces[:, corner]].astype(float) for corner in range(3))
    normals = np.cross(b - a, c - a)
    assert np.isclose(0.5 * normals[:, 1].sum(), 4.0)
    assert (normals[:, 1] > 0.0).all()
    # They are small enough for the waves: they turn from the normal between them by 3 degrees.
    between = NORMALS[MESH.faces].astype(float).sum(axis=1)
    cosine = np.sum(normals * between, axis=1)
    cosine /= np.linalg.norm(normals, axis=1) * np.linalg.norm(between, axis=1)
    assert np.degrees(np.arccos(cosine.min())) < 3.0


def test_squares_continue_each_other():
    heights = MESH.vertices[:, 1].reshape(SIDE, SIDE)
    normals = NORMALS.reshape(SIDE, SIDE, 3)
    for table in (heights, normals):
        assert np.allclose(table[0], table[-1], atol=1e-6)
        assert np.allclose(table[:, 0], table[:, -1], atol=1e-6)


def test_the_slope_is_as_told():
    # Trapezoids are exact for waves of whole numbers: at most 20 of 160 cells.
    x, _, z = MESH.vertices.reshape(SIDE, SIDE, 3)[:-1, :-1].astype(float).transpose(2, 0, 1)
    y, along_x, along_z = waves.height(x, z)
    assert np.isclose(np.sqrt(np.mean(along_x**2 + along_z**2)), waves.SLOPE, rtol=1e-6)
    assert abs(y.mean()) < 1e-8


def test_a_misspelt_mesh_names_the_nearest():
    text = 'alight: 1\ncamera: {}\nnodes: {a: {shape: {type: mesh, file: "builtin:wave"}}}\n'
    with pytest.raises(SceneError, match='did you mean "waves"'):
        loads(text)


def test_computed_meshes_keep_their_name_in_saved_scenes(tmp_path):
    scene = load("under-water")
    save(scene, tmp_path / "copy.yaml")
    assert load(tmp_path / "copy.yaml").nodes == scene.nodes
    assert [path.name for path in tmp_path.iterdir()] == ["copy.yaml"]
