"""Polygons cut into triangles, concave ones too.

A fan around a corner covers a polygon if none of its triangles is turned over, seen along the
polygon's normal. Convex polygons are cut around their first corner, as all programs do. Where that
turns triangles over, another corner is tried, which always does for four corners. What is left is
cut ear by ear: an ear is a convex corner whose triangle holds no other corner, and every polygon
that does not cross itself has two of them. Each cut changes the state of two corners only, so n
corners take O(n r) time, r of them being reflex.

Source: Meisters, Polygons have ears, American Mathematical Monthly 82 (1975); Held, FIST: fast
industrial-strength triangulation of polygons, Algorithmica 30 (2001), section 3; Sutherland,
Sproull and Schumacker 1974 for the normal (Newell's method).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.meshes.triangles import fan

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Polygons with more corners stay fans: the time for ears grows with the square.
MOST_CORNERS = 2000
#: Corners of all polygons of a file that are cut ear by ear; what is beyond stays a fan.
MOST_EARS = 200_000
#: Part of a polygon's area that a triangle may be turned over by: rounding.
TOLERANCE = 1e-6


def cut_polygons(points: NDArray[np.floating], sizes: Integers) -> tuple[Integers, Integers]:
    """Cut polygons into triangles that cover them.

    Parameters
    ----------
    points : (c, 3) float
        Positions of all corners, one polygon after the other.
    sizes : (p,) int64
        Corners of each polygon; those with fewer than 3 give no triangle.

    Returns
    -------
    corners : (m, 3) int64
        Rows of `points`.
    polygons : (m,) int64
        The polygon of each triangle. One that crosses itself gets some n - 2 triangles.
    """
    corners, polygons = fan(sizes)
    if sizes.max(initial=0) > 3:
        first_triangle = np.cumsum(np.maximum(sizes - 2, 0)) - np.maximum(sizes - 2, 0)
        starts = np.cumsum(sizes) - sizes
        ears = MOST_EARS
        for size in np.unique(sizes[(sizes > 3) & (sizes <= MOST_CORNERS)]).tolist():
            same = np.flatnonzero(sizes == size)
            cut, used = _cut_alike(points, starts[same], size, ears // size)
            ears -= used * size
            rows = first_triangle[same][:, None] + np.arange(size - 2)
            corners[rows] = starts[same][:, None, None] + cut
    return corners, polygons


def _cut_alike(
    points: NDArray[np.floating], starts: Integers, size: int, most: int
) -> tuple[Integers, int]:
    """Triangles (p, size - 2, 3) of polygons with `size` corners, as numbers of their corners.

    Also how many, at most `most`, were cut ear by ear.
    """
    local, _ = fan(np.array([size], np.int64))
    result = np.tile(local, (len(starts), 1, 1))
    left = np.arange(len(starts))
    # Around a far corner a fan is rarely better than ears, and large polygons are few.
    for apex in range(min(size, 8)):
        around = (local + apex) % size
        p = _shapes(points, starts[left], size)
        good = _covers(p, around)
        result[left[good]] = around
        left = left[~good]
        if not len(left):
            return result, 0
    # Four corners without a fan cross themselves.
    left = left[: most if size > 4 else 0]
    for polygon, p in zip(left.tolist(), _shapes(points, starts[left], size), strict=True):
        result[polygon] = _ears(p)
    return result, len(left)


def _shapes(points: NDArray[np.floating], starts: Integers, size: int) -> Floats:
    """Corners (p, size, 3), seen from each polygon's first one."""
    p = np.asarray(points[starts[:, None] + np.arange(size)], np.float64)
    return p - p[:, :1]


def _area_vectors(p: Floats) -> Floats:
    """Twice the area times the normal of each polygon (..., 3): Newell's sum."""
    return np.cross(p, np.roll(p, -1, axis=-2)).sum(axis=-2)


def _covers(p: Floats, triangles: Integers) -> NDArray[np.bool_]:
    """Whether no triangle of each polygon (p, size, 3) is turned over."""
    normal = _area_vectors(p)
    a, b, c = (p[:, triangles[:, i]] for i in range(3))
    turned = np.einsum("ptk,pk->pt", np.cross(b - a, c - a), normal)
    # NaN and infinity are reported elsewhere: such a polygon is no case for ears.
    return ~(turned < -TOLERANCE * (normal**2).sum(axis=1)[:, None]).any(axis=1)


def _ears(p: Floats) -> Integers:
    """Triangles (n - 2, 3) of one polygon (n, 3), ear by ear."""
    flat = _flattened(p)
    n = len(flat)
    before, after = np.roll(np.arange(n), 1), np.roll(np.arange(n), -1)
    before, after = before.tolist(), after.tolist()
    reflex = np.array([_turn(flat, before[i], i, after[i]) <= 0.0 for i in range(n)])
    is_ear = [_is_ear(flat, before[i], i, after[i], reflex) for i in range(n)]
    triangles, at, waited = [], 0, 0
    while len(triangles) < n - 2:
        # Without an ear the polygon crosses itself: any corner will do.
        if is_ear[at] or waited > n:
            triangles.append((before[at], at, after[at]))
            left, right = before[at], after[at]
            after[left], before[right] = right, left
            is_ear[at], reflex[at], waited = False, False, 0
            for i in (left, right):
                reflex[i] = _turn(flat, before[i], i, after[i]) <= 0.0
            for i in (left, right):
                is_ear[i] = _is_ear(flat, before[i], i, after[i], reflex)
            # Every other corner: triangles do not all meet in one.
            at = after[right]
        else:
            at, waited = after[at], waited + 1
    return np.array(triangles, np.int64)


def _flattened(p: Floats) -> Floats:
    """Corners (n, 2) seen along the normal, counter-clockwise."""
    normal = _area_vectors(p)
    axis = int(np.abs(normal).argmax())
    flat = np.delete(p, axis, axis=1)
    # Without y the other two run clockwise.
    return flat if (normal[axis] > 0.0) == (axis != 1) else flat[:, ::-1]


def _turn(p: Floats, a: int, b: int, c: int) -> float:
    """Twice the area of a triangle; positive to the left."""
    (ax, ay), (bx, by), (cx, cy) = p[a], p[b], p[c]
    return float((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))


def _is_ear(p: Floats, a: int, b: int, c: int, reflex: NDArray[np.bool_]) -> bool:
    """Whether corner b is convex, and no reflex corner lies in its triangle.

    Corners in the places of its own are not counted: seams of holes run there and back.
    """
    if reflex[b]:
        return False
    others = p[reflex]
    inside = np.ones(len(others), bool)
    for s, e in ((a, b), (b, c), (c, a)):
        edge = p[e] - p[s]
        inside &= edge[0] * (others[:, 1] - p[s, 1]) - edge[1] * (others[:, 0] - p[s, 0]) >= 0.0
    for i in (a, b, c):
        inside &= (others != p[i]).any(axis=1)
    return not inside.any()
