"""Finer triangles for the same surface: every edge is halved until none is longer than a bound.

Whether an edge is halved depends on its two ends alone, so triangles on both sides agree: no vertex
ends up in the middle of a neighbour's edge, also where two charts of texture coordinates meet at
vertices of their own. What vertices carry is interpolated linearly, as kernels do in a triangle.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from alight.meshes.triangles import MeshArrays

Table = NDArray[np.float64]
Indices = NDArray[np.int64]


#: Vertices nearer than half of this share of the longest side of their box are at one place; the
#: cells of a grid of such steps are numbered with 3 times 21 bits.
NEAREST = 2.0**-20


class TooManyTrianglesError(ValueError):
    """The bound of the edges would make more triangles than are allowed."""


def tessellated(mesh: MeshArrays, longest: float, most: int) -> MeshArrays:
    """Halve edges.

    Parameters
    ----------
    mesh : MeshArrays
    longest : float, metres
        No edge of the result is longer.
    most : int
        Triangles of the result at most.

    Raises
    ------
    TooManyTrianglesError
    """
    columns, widths = _columns_of(mesh)
    table = np.concatenate(columns, axis=1).astype(np.float64)
    faces = mesh.faces.astype(np.int64)
    while True:
        table, finer = _halved(table, faces, longest, most)
        if finer is faces:
            break
        faces = finer
    parts = np.split(table.astype(np.float32), np.cumsum(widths)[:-1], axis=1)
    return _mesh_of(mesh, parts, faces.astype(np.int32))


def welded(vertices: NDArray[np.float32]) -> NDArray[np.float32]:
    """Vertices that differ by rounding alone are put at one place: that of the first of them.

    Seams of computed surfaces are such: sin(2 pi) is not 0 in any floating point.
    """
    low = vertices.min(axis=0).astype(np.float64)
    longest = float((vertices.max(axis=0) - low).max())
    if longest == 0.0:
        return vertices
    at = (vertices - low) / (longest * NEAREST)
    # Whatever is less than half a cell apart shares a cell in one of the eight grids.
    for shift in product((0.0, 0.5), repeat=3):
        cell = np.floor(at + shift).astype(np.int64)
        keys = cell[:, 0] << 42 | cell[:, 1] << 21 | cell[:, 2]
        _, first, which = np.unique(keys, return_index=True, return_inverse=True)
        if len(first) < len(keys):
            at, vertices = at[first[which]], vertices[first[which]]
    return vertices


def _columns_of(mesh: MeshArrays) -> tuple[list[np.ndarray], list[int]]:
    """All that vertices carry, side by side, and how many numbers each part has."""
    more = [] if mesh.more_uvs is None else list(mesh.more_uvs)
    tables = [mesh.vertices, mesh.normals, mesh.uvs, mesh.colors, *more]
    columns = [table for table in tables if table is not None]
    return columns, [table.shape[1] for table in columns]


def _mesh_of(like: MeshArrays, parts: list[np.ndarray], faces: np.ndarray) -> MeshArrays:
    """The reverse of `_columns_of`."""
    left = iter(parts)
    named = {
        name: None if getattr(like, name) is None else next(left)
        for name in ("vertices", "normals", "uvs", "colors")
    }
    more = None if like.more_uvs is None else np.stack(list(left))
    return like._replace(**named, more_uvs=more, faces=faces)


def _halved(table: Table, faces: Indices, longest: float, most: int) -> tuple[Table, Indices]:
    """Halve once all edges that are too long; the same faces if there are none."""
    count = len(table)
    start, end = faces, np.roll(faces, -1, axis=1)
    keys, which = np.unique(
        np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True
    )
    a, b = np.divmod(keys, count)
    long = np.square(table[a, :3] - table[b, :3]).sum(axis=1) > longest * longest
    cut = long[which.reshape(faces.shape)]
    if not cut.any():
        return table, faces
    triangles = len(faces) + int(cut.sum())
    if triangles > most:
        raise TooManyTrianglesError(triangles)
    number = np.full(len(keys), -1, np.int64)
    number[long] = count + np.arange(int(long.sum()))
    table = np.concatenate([table, 0.5 * (table[a[long]] + table[b[long]])])
    return table, _cut(table, faces, cut, number[which.reshape(faces.shape)])


def _cut(table: Table, faces: Indices, cut: np.ndarray, middles: Indices) -> Indices:
    """Cut triangles into two, three or four, by the edges that have a middle."""
    cuts = cut.sum(axis=1)
    # Turned so that the edges that are halved come first.
    turn = np.where(cuts == 1, cut.argmax(axis=1), 0)
    turn = np.where(cuts == 2, (cut.argmin(axis=1) + 1) % 3, turn)
    order = (turn[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(faces, order, axis=1)
    middles = np.take_along_axis(middles, order, axis=1)
    parts = [faces[cuts == 0]]
    (a, b, c), m = corners[cuts == 1].T, middles[cuts == 1, 0]
    parts += [_stacked(a, m, c), _stacked(m, b, c)]
    (a, b, c), (m, n) = corners[cuts == 2].T, middles[cuts == 2, :2].T
    parts.append(_stacked(m, b, n))
    # Of the other four corners the nearer ones across are joined.
    first = _distances(table, a, n) <= _distances(table, m, c)
    parts += [
        _stacked(a, m, np.where(first, n, c)),
        _stacked(np.where(first, a, m), n, c),
    ]
    (a, b, c), (m, n, o) = corners[cuts == 3].T, middles[cuts == 3].T
    parts += [_stacked(a, m, o), _stacked(m, b, n), _stacked(o, n, c), _stacked(m, n, o)]
    return np.concatenate(parts)


def _stacked(*corners: Indices) -> Indices:
    return np.stack(corners, axis=1)


def _distances(table: Table, a: Indices, b: Indices) -> np.ndarray:
    return np.square(table[a, :3] - table[b, :3]).sum(axis=1)
