"""Polygons -> triangles: fans where they are convex, ears where they are not.

A fan around the first corner covers what lies outside of a concave polygon. One of four corners has
its fan around the corner that points inwards. A larger one is seen along its mean normal, and ears
are cut off: triangles of three corners in a row that hold no other corner. A simple polygon has two
of them at any time, so nothing is left over. Of a polygon that cuts itself what has no ear stays a
fan, and so does one of more than `MOST_CORNERS`, as the time grows with their square at least.

Source: Meisters 1975, "Polygons have ears"; the normal after Newell, in Sutherland, Sproull and
Schumacker 1974, "A characterization of ten hidden-surface algorithms".
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from alight.scene.formats.triangles import fan

MOST_CORNERS = 4096
#: Turns in the other direction count from so much on, in units of twice the polygon's area.
_LEAST_TURN = 1e-6


def triangulated(points: NDArray[np.floating], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut polygons into triangles.

    Parameters
    ----------
    points : (c, 3)
        Of the corners of all polygons, one polygon after the other.
    sizes : (p,) int64
        Corners of each polygon; those with fewer than 3 give no triangle.

    Returns
    -------
    (m, 3) int64
        Rows of `points`; of each polygon in its own sense, its triangles one after the other.
    """
    triangles, polygons = fan(sizes)
    starts = np.cumsum(sizes) - sizes
    found, inwards, normals = _concave(points, sizes)
    rows = np.searchsorted(polygons, found)
    four = sizes[found] == 4
    around = starts[found[four], None] + (inwards[four, None] + np.arange(4)) % 4
    triangles[rows[four]] = around[:, [0, 1, 2]]
    triangles[rows[four] + 1] = around[:, [0, 2, 3]]
    larger = ~four & (sizes[found] <= MOST_CORNERS)
    for polygon, row, normal in zip(found[larger], rows[larger], normals[larger], strict=True):
        own = int(starts[polygon]) + np.arange(int(sizes[polygon]))
        triangles[row : row + len(own) - 2] = own[_ears(_seen_along(normal, points[own]))]
    return triangles


def _concave(
    points: NDArray[np.floating], sizes: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Polygons that turn both ways, the first corner of each that points inwards, and normals."""
    large = np.flatnonzero(sizes > 3)
    if not len(large):
        return large, large, np.zeros((0, 3))
    starts, counts = (np.cumsum(sizes) - sizes)[large], sizes[large]
    owner = np.repeat(np.arange(len(large)), counts)
    begin = np.cumsum(counts) - counts
    within = np.arange(len(owner)) - begin[owner]
    here = starts[owner] + within
    after = starts[owner] + (within + 1) % counts[owner]
    edges = points[after].astype(np.float64) - points[here]
    before = begin[owner] + (within - 1) % counts[owner]
    from_first = points[here].astype(np.float64) - points[starts[owner]]
    with np.errstate(over="ignore", invalid="ignore"):
        normals = np.add.reduceat(np.cross(from_first, edges), begin)
        turns = (np.cross(edges[before], edges) * normals[owner]).sum(axis=1)
        squares = (normals**2).sum(axis=1)
        bad = np.flatnonzero(turns < -_LEAST_TURN * squares[owner])
    found, first = np.unique(owner[bad], return_index=True)
    return large[found], within[bad[first]], normals[found]


def _seen_along(normal: NDArray[np.float64], points: NDArray[np.floating]) -> NDArray[np.float64]:
    """Coordinates in which a polygon turns to the left: (n, 2)."""
    axis = int(np.abs(normal).argmax())
    flat = points[:, [(axis + 1) % 3, (axis + 2) % 3]].astype(np.float64)
    return flat if normal[axis] > 0.0 else flat * [1.0, -1.0]


def _ears(corners: NDArray[np.float64]) -> NDArray[np.int64]:
    """Triangles of a polygon that turns to the left: (n - 2, 3) indices."""
    left = list(range(len(corners)))
    found, at, misses = [], 0, 0
    while len(left) > 3 and misses < len(left):
        at %= len(left)
        triple = [left[at - 1], left[at], left[(at + 1) % len(left)]]
        if _is_ear(corners[triple], corners[left]):
            found.append(triple)
            del left[at]
            # The corner before may be an ear now; going back also keeps slivers short.
            at, misses = at - 1, 0
        else:
            at, misses = at + 1, misses + 1
    found += [[left[0], b, c] for b, c in pairwise(left[1:])]
    return np.array(found, np.int64)


def _is_ear(triangle: NDArray[np.float64], others: NDArray[np.float64]) -> bool:
    """Whether three corners turn to the left and no other corner lies in their triangle."""
    edges = np.roll(triangle, -1, axis=0) - triangle
    if edges[0, 0] * edges[1, 1] - edges[0, 1] * edges[1, 0] <= 0.0:
        return False
    offsets = others[:, None] - triangle
    sides = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
    # Corners in the same place as one of the three are where a hole is joined to the outside.
    same = (offsets == 0.0).all(axis=2).any(axis=1)
    return not ((sides >= 0.0).all(axis=1) & ~same).any()
