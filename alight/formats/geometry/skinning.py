r"""Vertices as a skeleton holds them: linear blending of what moves with each joint.

.. math:: p = \sum_j w_j\, M_j\, v

with the matrices M that take what is stored to where each joint holds it, and weights of sum 1.

Source: Magnenat-Thalmann, Laperriere and Thalmann 1988, Joint-Dependent Local Deformations for Hand
Animation and Object Grasping.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrices = NDArray[np.float64]
Rows = NDArray[np.floating]


def held(
    joints: NDArray[np.int64],
    weights: NDArray[np.floating],
    matrices: Matrices,
    vertices: Rows,
    normals: Rows | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Move vertices and normals, each by its joints.

    Parameters
    ----------
    joints, weights : (n, k)
        Of each vertex its joints, and how much each of them holds it; vertices that none holds
        stay.
    matrices : (m, 4, 4) float64
        Of the joints, for column vectors.
    vertices, normals : (n, 3)
    """
    share = weights.astype(np.float64)
    whole = share.sum(axis=1, keepdims=True)
    share = np.where(whole > 0.0, share / np.where(whole > 0.0, whole, 1.0), 0.0)
    with np.errstate(over="ignore", invalid="ignore"):
        blended = np.einsum("vj,vjab->vab", share, matrices[joints])
        blended[whole[:, 0] <= 0.0] = np.eye(4)
        moved = np.einsum("vab,vb->va", blended[:, :3, :3], vertices) + blended[:, :3, 3]
        if normals is None:
            return moved, None
        cofactors = _cofactors(blended[:, :3, :3])
        turned = np.einsum("vab,vb->va", cofactors, normals.astype(np.float64))
        lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return moved, np.where(lengths > 0.0, turned / np.where(lengths > 0.0, lengths, 1.0), normals)


def _cofactors(m: Matrices) -> Matrices:
    """Matrices that turn normals: the inverse transpose times the determinant."""
    return np.stack(
        [np.cross(m[:, 1], m[:, 2]), np.cross(m[:, 2], m[:, 0]), np.cross(m[:, 0], m[:, 1])], axis=1
    )
