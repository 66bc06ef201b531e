r"""Vertex normals of meshes that come without: the normals of the faces around, weighted by angle.

.. math:: n_v \propto \sum_{f \ni v} \alpha_{f,v}\, n_f

with :math:`\alpha_{f,v}` the angle of face f at the vertex. The result does not depend on how
polygons were cut into triangles.

Source: Thürmer and Wüthrich, Computing vertex normals from polygonal facets, Journal of Graphics
Tools 3(1), 1998.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def vertex_normals(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Compute unit normals; 0 for vertices without a face, which are shaded flat.

    Parameters
    ----------
    vertices : (n, 3) float32, metres
    faces : (m, 3) int32
    """
    corners = vertices.astype(np.float64)[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    across = np.cross(edges[:, 0], -edges[:, 2])
    across = across / _lengths(across)
    unit = edges / _lengths(edges)
    total = np.zeros((len(vertices), 3))
    for k in range(3):
        # At corner k the edge to the next corner leaves, that from the last one arrives.
        cosine = -(unit[:, k] * unit[:, k - 1]).sum(axis=1)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        np.add.at(total, faces[:, k], across * angle[:, None])
    return (total / _lengths(total)).astype(np.float32)


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths along the last axis; 1 for zero vectors, so that they stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(lengths > 0.0, lengths, 1.0)
