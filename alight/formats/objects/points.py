"""Clouds of points as small balls: one mesh, so that a million of them are as easy as ten."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.formats.objects.pieces import Array, Look, Piece, wrong

#: Triangles of all balls together are about as many at most; of a ball at most 20 * 4^FINEST.
MOST_TRIANGLES, FINEST = 2_500_000, 3

#: Points whose nearest neighbours are looked for, and the radius as a part of their distance, at
#: least as a part of the diagonal of the box around the points: a pixel or so.
PROBES, FILL, LEAST = 256, 0.6, 0.0015


def balls(points: Array, look: Look, colors: Array | None, values: Array | None) -> Piece:
    """Put a ball at every point.

    Parameters
    ----------
    points : (n, 3) array
    look : Look
    colors, values : arrays or None
        Of the points, see `Piece`.
    """
    if len(points) == 0:
        raise wrong("points", "must hold at least one point, got none")
    if not np.isfinite(points).all():
        row = int(np.argmax(~np.isfinite(points).all(axis=1)))
        raise wrong("points", f"must be finite, got {points[row].tolist()} in row {row}")
    radius = look.point_radius or sensible_radius(points)
    level = 0
    while level < FINEST and 20 * 4 ** (level + 1) * len(points) <= MOST_TRIANGLES:
        level += 1
    normals, faces = ball(level)
    centers = np.asarray(points, np.float64)
    vertices = (centers[:, None, :] + radius * normals).astype(np.float32).reshape(-1, 3)
    every = np.arange(len(points))[:, None, None] * len(normals)
    each = len(normals)
    return Piece(
        vertices,
        (faces + every).reshape(-1, 3),
        normals=np.tile(normals.astype(np.float32), (len(points), 1)),
        colors=None if colors is None else np.repeat(colors, each, axis=0),
        values=None if values is None else np.repeat(values, each),
        name="points",
    )


def sensible_radius(points: Array) -> float:
    """Radius at which neighbours just touch: a part of their median distance.

    It is measured at evenly spread points; those in the same place do not count.
    """
    cloud = np.asarray(points, np.float64)
    probes = cloud[np.linspace(0, len(cloud) - 1, min(PROBES, len(cloud))).astype(int)]
    nearest = []
    for probe in probes:
        squared = ((cloud - probe) ** 2).sum(axis=1)
        apart = squared[squared > 0.0]
        if apart.size:
            nearest.append(apart.min())
    if not nearest:
        return 1.0
    least = LEAST * float(np.linalg.norm(np.ptp(cloud, axis=0)))
    return max(FILL * float(np.sqrt(np.median(nearest))), least)


def ball(level: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """An icosahedron with every face cut into four `level` times, pushed out to the unit sphere."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    one = [(0.0, a, b * golden) for a in (-1, 1) for b in (-1, 1)]
    vertices = np.array([np.roll(p, k) for k in range(3) for p in one])
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    faces = _hull(vertices)
    for _ in range(level):
        corners = vertices[faces]
        middle = corners + np.roll(corners, -1, axis=1)
        middle /= np.linalg.norm(middle, axis=2, keepdims=True)
        a, b, c = (corners[:, k] for k in range(3))
        ab, bc, ca = (middle[:, k] for k in range(3))
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        soup = np.concatenate([np.stack(p, axis=1) for p in parts]).reshape(-1, 3)
        _, kept, number = np.unique(
            np.round(soup, 9), axis=0, return_index=True, return_inverse=True
        )
        vertices, faces = soup[kept], number.reshape(-1, 3)
    return vertices, faces


def _hull(vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """The 20 faces of an icosahedron: triples of vertices at the shortest distance, outwards."""
    distance = np.linalg.norm(vertices[:, None] - vertices, axis=2)
    joined = np.isclose(distance, distance[distance > 0.0].min())
    count = range(len(vertices))
    found = [
        (i, j, k)
        for i in count
        for j in count
        for k in count
        if i < j < k and joined[i, j] and joined[j, k] and joined[i, k]
    ]
    faces = np.array(found)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inwards = (np.cross(b - a, c - a) * a).sum(axis=1) < 0.0
    faces[inwards] = faces[inwards][:, ::-1]
    return faces
