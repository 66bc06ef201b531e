"""Vertex data of meshes, put one after the other in the tables of shapes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.scene.meshes import Geometry
from alight.shapes.hit import COLORS, FLIP, SMOOTH, UVS


@dataclass
class MeshArrays:
    """Vertex data of all meshes, put one after the other."""

    vertices: list[np.ndarray] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)
    normals: list[np.ndarray] = field(default_factory=list)
    uvs: list[np.ndarray] = field(default_factory=list)
    colors: list[np.ndarray] = field(default_factory=list)
    # First vertex of a mesh -> its further sets of texture coordinates.
    further: dict[int, np.ndarray] = field(default_factory=dict)
    vertex_count: int = 0
    face_count: int = 0

    def add(self, vertices: np.ndarray, normals: np.ndarray | None, mesh: Geometry) -> MeshRange:
        """Append a mesh; attributes that it lacks are filled up if another mesh has them."""
        place = MeshRange(self.face_count, self.vertex_count, len(mesh.faces))
        self.vertices.append(vertices)
        self.faces.append(mesh.faces.astype(np.uint32) + np.uint32(self.vertex_count))
        self.normals.append(_or_zeros(normals, len(vertices), 3))
        self.uvs.append(_or_zeros(mesh.uvs, len(vertices), 2))
        self.colors.append(_or_zeros(mesh.colors, len(vertices), 3))
        if mesh.more_uvs is not None:
            self.further[self.vertex_count] = mesh.more_uvs
        self.vertex_count += len(vertices)
        self.face_count += len(mesh.faces)
        return place


class MeshRange(NamedTuple):
    """Where a mesh lies in the tables."""

    first_face: int
    first_vertex: int
    face_count: int


NO_FACES = MeshRange(0, 0, 0)


def _or_zeros(table: np.ndarray | None, rows: int, columns: int) -> np.ndarray:
    if table is not None:
        return np.ascontiguousarray(table, np.float32)
    return np.broadcast_to(np.float32(0.0), (rows, columns))


def mesh_flags(mesh: Geometry, flip: bool) -> int:
    """Flags of a mesh; `flip`: the outer side is not that of the counter-clockwise order."""
    flags = SMOOTH * (mesh.normals is not None)
    flags |= UVS * (mesh.uvs is not None) | COLORS * (mesh.colors is not None)
    return flags | FLIP * flip


def unit_normals(mesh: Geometry) -> NDArray[np.float32] | None:
    """The vertex normals with length 1; zeros stay, and are shaded flat."""
    if mesh.normals is None:
        return None
    lengths = np.linalg.norm(mesh.normals.astype(np.float64), axis=1, keepdims=True)
    return (mesh.normals / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32)


def triangle_areas(vertices: np.ndarray, faces: np.ndarray) -> NDArray[np.float64]:
    """Area of each triangle, m^2."""
    corners = vertices.astype(np.float64)[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(across, axis=1)


def joined(parts: list[np.ndarray], columns: int, dtype: type, empty: bool = False) -> np.ndarray:
    """Tables one below the other; a row of zeros in place of nothing, unless it may be empty."""
    if not parts:
        return np.zeros((0 if empty else 1, columns), dtype)
    if len(parts) == 1:
        return np.ascontiguousarray(parts[0], dtype)
    return np.concatenate(parts).astype(dtype, copy=False)


def joined_if_any(parts: list[np.ndarray], columns: int) -> np.ndarray:
    """The same for an attribute that all meshes may lack; then no memory is spent on it."""
    lacking = all(0 in part.strides for part in parts)
    return joined([] if lacking else parts, columns, np.float32)


class Triangles(NamedTuple):
    """All triangles that are stored in world space.

    Attributes
    ----------
    vertices : (V, 3) float32, metres
    faces : (F, 3) int32
        Rows of `vertices`.
    shape, prim : (F,) uint32
        The shape of each triangle, and its number within the shape; ascending.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    shape: NDArray[np.uint32]
    prim: NDArray[np.uint32]


def joined_triangles(parts: list[tuple[np.ndarray, np.ndarray, int]]) -> Triangles:
    """All triangles of meshes in the world, each (vertices, faces, number of the shape)."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _, _ in parts])
    return Triangles(
        joined([vertices for vertices, _, _ in parts], 3, np.float32, empty=True),
        joined(
            [f + np.int32(start) for (_, f, _), start in zip(parts, starts, strict=False)],
            3,
            np.int32,
            empty=True,
        ),
        np.repeat(
            np.array([index for _, _, index in parts], np.uint32),
            np.array([len(faces) for _, faces, _ in parts], np.int64),
        ),
        np.concatenate(
            [np.arange(len(faces), dtype=np.uint32) for _, faces, _ in parts]
            or [np.zeros(0, np.uint32)]
        ),
    )
