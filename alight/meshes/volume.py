"""The volume inside of a closed mesh, and where an open one ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.by_arrays import once
from alight.meshes.tessellation import welded

#: A volume of less than this part of a cube with the mesh's diagonal is none.
FLAT = 1e-8

#: By the arrays.
_VOLUMES: dict[tuple, float] = {}
_EDGES: dict[tuple, NDArray[np.float64]] = {}


def enclosed_volume(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> float:
    """The volume that triangles enclose, by Gauss's theorem.

    Parameters
    ----------
    vertices : (n, 3) float32, metres
    faces : (t, 3) int32

    Returns
    -------
    float
        m^3; negative if they face inwards, 0 if they are open: where an edge has a triangle on one
        side only. Of read-only arrays it is worked out once.
    """
    return once(_VOLUMES, (vertices, faces), None, lambda: _volume(vertices, faces))


def _volume(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> float:
    _, places = np.unique(welded(vertices), axis=0, return_inverse=True)
    corners = places.reshape(-1)[faces].astype(np.int64)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    real = start != end
    there = np.sort(start[real] * len(vertices) + end[real])
    back = np.sort(end[real] * len(vertices) + start[real])
    if not np.array_equal(there, back):
        return 0.0
    points = vertices.astype(np.float64)
    points -= points.mean(axis=0)
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    parts = (a * np.cross(b, c)).sum(axis=1)
    volume = float(parts.sum() / 6.0)
    # What is flat encloses nothing, whatever rounding says.
    largest = float((np.ptp(points, axis=0) ** 2).sum()) ** 1.5
    return volume if abs(volume) > FLAT * largest else 0.0


def open_edges(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Vertices (n, 3) on edges that belong to one triangle only, whichever way it faces.

    Of read-only arrays they are looked for once.
    """
    return once(_EDGES, (vertices, faces), None, lambda: _open_edges(vertices, faces))


def _open_edges(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    points, places = np.unique(welded(vertices), axis=0, return_inverse=True)
    corners = places.reshape(-1)[faces].astype(np.int64)
    ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2))
    ends = ends[ends[:, 0] != ends[:, 1]]
    keys, counts = np.unique(ends[:, 0] * len(points) + ends[:, 1], return_counts=True)
    alone = keys[counts == 1]
    return points[np.unique([alone // len(points), alone % len(points)])].astype(np.float64)


def has_inside(*meshes: Any) -> bool:
    """Whether triangles, of several meshes together, are closed and face outwards."""
    if len(meshes) == 1:
        # Its own arrays, of which it may be known.
        return enclosed_volume(meshes[0].vertices, meshes[0].faces) > 0.0
    vertices = [np.asarray(mesh.vertices) for mesh in meshes]
    starts = np.cumsum([0, *(len(points) for points in vertices)])
    faces = [np.asarray(mesh.faces) + start for mesh, start in zip(meshes, starts, strict=False)]
    return enclosed_volume(np.concatenate(vertices), np.concatenate(faces)) > 0.0
