"""Shapes that are formulas, written to glTF as meshes and read again."""

import numpy as np
import pytest

from alight.formats import load, loads
from alight.formats.gltf.write import write
from alight.scene import flatten
from alight.shapes.cube import sides

HEAD = "alight: 1\ncamera: {type: orthographic}\nnodes:\n"


def flip(side):
    return "true" if side < 0.0 else "false"


def rewritten(shapes, tmp_path):
    """World points, faces' normals (with their areas), texture coordinates; and what was said."""
    lines = [f"  n{i}: {{shape: {shape}}}" for i, shape in enumerate(shapes)]
    flat = flatten(loads(HEAD + "\n".join(lines)))
    lost = write(flat, tmp_path / "a.glb")
    again = flatten(load(tmp_path / "a.glb"))
    found = []
    for placed in again.shapes:
        mesh = again.geometries[placed.geometry]
        points = mesh.vertices @ placed.to_world[:3, :3].T + placed.to_world[:3, 3]
        corners = points[mesh.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if mesh.normals is not None:
            # Vertices' normals and the order of corners agree.
            turned = mesh.normals @ np.linalg.inv(placed.to_world[:3, :3])
            assert ((turned[mesh.faces].mean(axis=1) * across).sum(axis=1) > 0.0).all()
        found.append((points, corners.mean(axis=1), 0.5 * across, mesh.uvs))
    return found, lost


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_spheres(side, tmp_path):
    shape = f"{{type: sphere, center: [1, 2, 3], radius: 0.5, flip_normals: {flip(side)}}}"
    [(points, centers, across, uvs)], lost = rewritten([shape], tmp_path)
    q = (points - [1.0, 2.0, 3.0]) / 0.5
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-6)
    assert (side * ((centers - [1.0, 2.0, 3.0]) * across).sum(axis=1) > 0.0).all()
    assert np.linalg.norm(across, axis=1).sum() == pytest.approx(np.pi, rel=1e-3)
    # (phi / 2 pi, theta / pi), as the sphere has them.
    np.testing.assert_allclose(uvs[:, 1], np.arccos(np.clip(q[:, 2], -1, 1)) / np.pi, atol=2e-4)
    away = np.abs(q[:, 2]) < 0.99
    off = np.arctan2(q[away, 1], q[away, 0]) / (2.0 * np.pi) - uvs[away, 0]
    np.testing.assert_allclose(off, np.round(off), atol=1e-6)
    assert lost == ["spheres: became meshes of 16128 triangles"]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_cylinders(side, tmp_path):
    ends = "p0: [0, 1, 0], p1: [0, 4, 0]"
    shape = f"{{type: cylinder, {ends}, radius: 2, flip_normals: {flip(side)}}}"
    [(points, centers, across, uvs)], _ = rewritten([shape], tmp_path)
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 2]), 2.0, atol=1e-6)
    np.testing.assert_allclose(points[:, 1], 1.0 + 3.0 * uvs[:, 1], atol=1e-6)
    assert (side * (centers * [1, 0, 1] * across).sum(axis=1) > 0.0).all()
    assert np.linalg.norm(across, axis=1).sum() == pytest.approx(12.0 * np.pi, rel=1e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_disks_and_rectangles(side, tmp_path):
    shapes = [f"{{type: {kind}, flip_normals: {flip(side)}}}" for kind in ("disk", "rectangle")]
    [disk, square], lost = rewritten(shapes, tmp_path)
    for (points, _, across, _), area in ((disk, np.pi), (square, 4.0)):
        assert (points[:, 2] == 0.0).all()
        assert (side * across[:, 2] > 0.0).all()
        assert np.abs(across[:, 2]).sum() == pytest.approx(area, rel=1e-3)
    points, _, _, uvs = disk
    np.testing.assert_allclose(uvs[:, 0], np.hypot(points[:, 0], points[:, 1]), atol=1e-6)
    np.testing.assert_allclose(square[3], 0.5 * square[0][:, :2] + 0.5)
    assert [line.split(":")[0] for line in lost] == ["disks"]


def test_cubes_are_their_six_rectangles(tmp_path):
    [(points, centers, across, uvs)], lost = rewritten(["cube"], tmp_path)
    assert lost == []
    assert ((centers * across).sum(axis=1) > 0.0).all()
    assert np.linalg.norm(across, axis=1).sum() == pytest.approx(24.0)
    for i, side in enumerate(sides()):
        own = slice(4 * i, 4 * i + 4)
        flat = np.column_stack([2.0 * uvs[own] - 1.0, np.zeros(4), np.ones(4)])
        np.testing.assert_allclose(points[own], (flat @ side.T)[:, :3], atol=1e-6)


def test_spheres_share_a_mesh_and_keep_their_light(tmp_path):
    text = (
        HEAD
        + """  a: {shape: sphere, light: {type: area, radiance: [4, 2, 1]}}
  b: {shape: {type: sphere, radius: 2}, transform: {translate: [5, 0, 0]}}
  c: {shape: {type: sphere, radius: 3}, transform: {scale: [1, 1, 2]}}
  d: {shape: plane}
"""
    )
    lost = write(flatten(loads(text)), tmp_path / "a.glb")
    assert "d: a plane is not a mesh" in lost
    assert (tmp_path / "a.glb").stat().st_size < 600_000
    again = flatten(load(tmp_path / "a.glb"))
    np.testing.assert_allclose(again.shapes[0].light.radiance, (4.0, 2.0, 1.0))
    assert again.shapes[1].to_world[0, 3] == 5.0
    np.testing.assert_allclose(np.diag(again.shapes[2].to_world)[:3], [3.0, 3.0, 6.0])


def test_the_cornell_box_is_whole(tmp_path):
    lost = write(flatten(load("cornell-box")), tmp_path / "a.glb")
    assert not any("no mesh" in line for line in lost)
    again = flatten(load(tmp_path / "a.glb"))
    assert len(again.shapes) == len(flatten(load("cornell-box")).shapes)
