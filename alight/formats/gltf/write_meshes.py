"""Meshes as glTF wants them: normals of length 1, coordinates wherever there are pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.meshes.triangles import MeshArrays


def with_unit_normals(mesh: MeshArrays) -> MeshArrays:
    """The mesh with normals of length 1; where one is 0, that of the triangles around takes over.

    Parameters
    ----------
    mesh : MeshArrays
    """
    if mesh.normals is None:
        return mesh
    normals = mesh.normals.astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1)
    if (np.abs(lengths - 1.0) < 1e-6).all():
        return mesh
    if not (lengths > 0.0).all():
        normals = np.where((lengths > 0.0)[:, None], normals, _around(mesh))
        lengths = np.linalg.norm(normals, axis=1)
    return mesh._replace(normals=(normals / lengths[:, None]).astype(np.float32))


def _around(mesh: MeshArrays) -> NDArray[np.float64]:
    """Sum of the normals of the triangles at each vertex, weighted by their areas."""
    points = mesh.vertices.astype(np.float64)
    a, b, c = (points[mesh.faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    found = np.zeros_like(points)
    for i in range(3):
        np.add.at(found, mesh.faces[:, i], across)
    found[np.linalg.norm(found, axis=1) == 0.0] = (0.0, 0.0, 1.0)
    return found


def moved(mesh: MeshArrays, matrix: NDArray[np.float64]) -> MeshArrays:
    """The mesh in another space.

    Parameters
    ----------
    mesh : MeshArrays
    matrix : (3, 3) float64
        Without a mirror.
    """
    vertices = (mesh.vertices.astype(np.float64) @ matrix.T).astype(np.float32)
    if mesh.normals is None:
        return mesh._replace(vertices=vertices)
    normals = mesh.normals.astype(np.float64) @ np.linalg.inv(matrix)
    largest = np.abs(normals).max(axis=1, keepdims=True)
    normals = np.divide(normals, largest, out=normals, where=largest > 0.0)
    return mesh._replace(vertices=vertices, normals=normals.astype(np.float32))


def with_coordinates(mesh: MeshArrays) -> MeshArrays:
    """The mesh with the barycentric coordinates of each triangle as its texture coordinates.

    Parameters
    ----------
    mesh : MeshArrays
        Without coordinates of its own.
    """
    corners = mesh.faces.ravel()
    count = len(corners)
    return MeshArrays(
        vertices=mesh.vertices[corners],
        faces=np.arange(count, dtype=np.int32).reshape(-1, 3),
        normals=None if mesh.normals is None else mesh.normals[corners],
        uvs=np.tile(np.float32([[0, 0], [1, 0], [0, 1]]), (count // 3, 1)),
        colors=None if mesh.colors is None else mesh.colors[corners],
    )
