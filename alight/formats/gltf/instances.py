"""Meshes at many places of one node.

Source: Khronos Group, EXT_mesh_gpu_instancing.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.core.errors import SceneError
from alight.formats.geometry.skinning import Matrices
from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item
from alight.formats.scenes.surroundings import Bounds
from alight.scene.transform import Matrix

NAME = "EXT_mesh_gpu_instancing"
#: Of a node: each takes a kilobyte or two, which a file of a few bytes must not multiply.
MOST_INSTANCES = 2**18
#: Vertices of all instances; where there are more, the camera sees the boxes around them.
MOST_SEEN = 2**20
_COLUMNS = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}


def instance_matrices(document: Document, node: Item) -> Matrices | None:
    """Where the mesh of a node stands, in the node's space; None without the extension.

    Returns
    -------
    (n, 4, 4) float64

    Raises
    ------
    SceneError
        If the arrays do not fit together, or hold no placements.
    """
    extension = node.extension(NAME)
    if extension is None:
        return None
    attributes = extension.object("attributes")
    if attributes is None:
        raise extension.fatal("attributes", "is missing")
    tables = {key: _table(document, attributes, key) for key in _COLUMNS if attributes.has(key)}
    for key in attributes.value:
        if key not in _COLUMNS:
            document.report.drop(f"{NAME}: {key}: not used")
    counts = {key: len(table) for key, table in tables.items()}
    if len(set(counts.values())) != 1:
        listed = ", ".join(f"{key} {count}" for key, count in counts.items()) or "none"
        raise attributes.fatal("", f"must have TRANSLATION, ROTATION or SCALE alike, has {listed}")
    count = next(iter(counts.values()))
    if count > MOST_INSTANCES:
        raise attributes.fatal("", f"must have at most {MOST_INSTANCES} instances, has {count}")
    document.report.count("instances", count)
    found = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in tables:
        turns = tables["ROTATION"]
        lengths = np.linalg.norm(turns, axis=1)
        if not (lengths > 1e-6).all():
            row = int(np.argmin(lengths))
            raise attributes.fatal("ROTATION", f"must hold unit quaternions, not so in row {row}")
        found[:, :3, :3] = rotations(turns / lengths[:, None])
    if "SCALE" in tables:
        found[:, :3, :3] *= tables["SCALE"][:, None, :]
    if "TRANSLATION" in tables:
        found[:, :3, 3] = tables["TRANSLATION"]
    return found


def _table(document: Document, attributes: Item, key: str) -> NDArray[np.float64]:
    index = attributes.index(key, len(document.list("accessors")), "accessors")
    if index is None:
        raise SceneError(document.report.issues)
    table = read_accessor(document, index).astype(np.float64)
    if table.shape[1] != _COLUMNS[key]:
        text = f"must have {_COLUMNS[key]} components, got {table.shape[1]}"
        raise attributes.fatal(key, text)
    wrong = ~(np.abs(table) <= 1e15).all(axis=1)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise attributes.fatal(key, f"must be finite and at most 1e+15 in size, not in row {row}")
    return table


def rotations(quaternions: NDArray[np.float64]) -> Matrices:
    """The (n, 3, 3) matrices of unit quaternions (x, y, z, w)."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def add_bounds(bounds: Bounds, vertices: ArrayLike, moves: Matrices, to_world: Matrix) -> None:
    """Enclose a mesh at all of its places."""
    points = np.asarray(vertices)
    if len(points) * len(moves) <= MOST_SEEN:
        for move in moves:
            bounds.add(points, to_world @ move)
        return
    box = np.stack([points.min(axis=0), points.max(axis=0)])
    corners = np.array(list(itertools.product(*box.T)), np.float64)
    moved = np.einsum("nab,cb->nca", moves[:, :3, :3], corners) + moves[:, None, :3, 3]
    bounds.add(moved.reshape(-1, 3), to_world)
