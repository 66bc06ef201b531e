"""Skins: the vertices of a mesh as its skeleton holds them at rest.

The matrix of a joint is G B, with its world matrix G and its inverse bind matrix B. The transform
of the mesh's own node plays no part, so it is taken out again.

Source: Khronos Group, glTF 2.0 specification, section 3.7.3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.formats.geometry.skinning import Matrices, held
from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item


def joint_matrices(
    document: Document, skin: Item, worlds: dict[int, Matrices], to_world: Matrices
) -> Matrices:
    """From the vertices as they are stored to those in the space of the mesh's node.

    Parameters
    ----------
    worlds : dict of int to (4, 4) float64
        World matrices of the nodes.
    to_world : (4, 4) float64
        Of the mesh's node.

    Returns
    -------
    (n, 4, 4) float64
        One for each joint.
    """
    joints = skin.indices("joints", len(document.list("nodes")), "nodes")
    if not worlds.keys() >= set(joints):
        text = f"{skin.pointer}: joints outside of the scene that is shown stand at its origin"
        document.report.approximate(text)
    placed = np.array([worlds.get(joint, np.eye(4)) for joint in joints]).reshape(-1, 4, 4)
    accessors = len(document.list("accessors"))
    index = skin.index("inverseBindMatrices", accessors, "accessors")
    bind = np.tile(np.eye(4), (len(joints), 1, 1))
    if index is not None:
        table = read_accessor(document, index)
        if table.shape[1] != 16 or len(table) < len(joints):
            text = f"must hold a matrix for each of {len(joints)} joints"
            raise skin.fatal("inverseBindMatrices", text)
        # Columns come one after the other.
        rows = table[: len(joints)].astype(np.float64).reshape(-1, 4, 4)
        bind = rows.transpose(0, 2, 1)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.linalg.inv(to_world) @ placed @ bind


def skinned(
    primitive: Item,
    joints: NDArray[np.float32],
    weights: NDArray[np.float32],
    matrices: Matrices,
    vertices: NDArray[np.float32],
    normals: NDArray[np.float32] | None,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Move vertices and normals, each by its joints."""
    attributes = primitive.object("attributes") or primitive
    if not (joints == np.floor(joints)).all():
        raise attributes.fatal("JOINTS_0", "must hold whole numbers")
    if not np.isfinite(weights).all():
        raise attributes.fatal("WEIGHTS_0", "must hold finite numbers")
    if len(joints) and not 0 <= int(joints.max()) < len(matrices):
        text = f"must be below the number of joints, {len(matrices)}, got {int(joints.max())}"
        raise attributes.fatal("JOINTS_0", text)
    moved, turned = held(joints.astype(np.int64), weights, matrices, vertices, normals)
    return moved.astype(np.float32), None if turned is None else turned.astype(np.float32)
