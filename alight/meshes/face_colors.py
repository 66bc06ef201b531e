"""Colours of faces as colours of vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.meshes.triangles import MeshArrays


def with_face_colors(mesh: MeshArrays, colors: NDArray[np.float32]) -> MeshArrays:
    """Give each triangle one colour.

    Faces of one colour go on sharing vertices, so that smooth surfaces stay smooth but where
    colours meet.

    Parameters
    ----------
    mesh : MeshArrays
        Without colours of vertices.
    colors : (m, 3) float32
        Linear, one a triangle.
    """
    _, painted = np.unique(colors, axis=0, return_inverse=True)
    # A vertex for each pair of an old one and a colour.
    pairs = mesh.faces.astype(np.int64) + len(mesh.vertices) * painted.reshape(-1, 1)
    _, first, faces = np.unique(pairs, return_index=True, return_inverse=True)
    old = mesh.faces.reshape(-1)[first]

    def spread(table: NDArray[np.float32] | None) -> NDArray[np.float32] | None:
        return None if table is None else table[..., old, :]

    return MeshArrays(
        mesh.vertices[old],
        faces.reshape(-1, 3).astype(np.int32),
        spread(mesh.normals),
        spread(mesh.uvs),
        colors[first // 3],
        spread(mesh.more_uvs),
    )
