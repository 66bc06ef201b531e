r"""The square pictures of pbrt 4's infinite lights: the sphere, folded to an octahedron.

With :math:`r = \sqrt{1 - |z|}` and the angle :math:`\varphi` in the first octant, x = y mapped to
the diagonal, the point lies at :math:`v = \tfrac{2}{\pi} r \varphi, u = r - v` of the upper half;
the lower half fills the corners. All texels are seen under the same solid angle.

Source: Clarberg, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD, Journal of Graphics Tools
13(3), 2008; PBR4 section 3.8.3.
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def to_square(directions: Array) -> Array:
    """Unit vectors, shape (..., 3), to the unit square, shape (..., 2)."""
    x, y, z = np.moveaxis(np.asarray(directions, np.float64), -1, 0)
    r = np.sqrt(np.maximum(0.0, 1.0 - np.abs(z)))
    v = r * (2.0 / np.pi) * np.arctan2(np.abs(y), np.abs(x))
    u = r - v
    below = z < 0.0
    u, v = np.where(below, 1.0 - v, u), np.where(below, 1.0 - u, v)
    return 0.5 * (np.stack([np.copysign(u, x), np.copysign(v, y)], axis=-1) + 1.0)


def to_sphere(points: Array) -> Array:
    """Points of the unit square, shape (..., 2), to unit vectors, shape (..., 3)."""
    u, v = np.moveaxis(2.0 * np.asarray(points, np.float64) - 1.0, -1, 0)
    distance = 1.0 - (np.abs(u) + np.abs(v))
    r = 1.0 - np.abs(distance)
    phi = np.where(r > 0.0, (np.abs(v) - np.abs(u)) / np.where(r > 0.0, r, 1.0) + 1.0, 1.0)
    phi = phi * (np.pi / 4.0)
    across = r * np.sqrt(np.maximum(0.0, 2.0 - r * r))
    x = np.copysign(np.cos(phi), u) * across
    y = np.copysign(np.sin(phi), v) * across
    return np.stack([x, y, np.copysign(1.0 - r * r, distance)], axis=-1)


def to_latitude_longitude(square: Array) -> Array:
    """Resample a square picture to ours of latitude and longitude.

    Parameters
    ----------
    square : (n, n, 3) float32

    Returns
    -------
    (n + 1, 2 n, 3) float32
        +y of our map is +z of pbrt's light, -z is +y. Bilinear between texels; rows at the poles.
    """
    n = len(square)
    azimuth = (np.arange(2 * n) + 0.5) * (np.pi / n)
    theta = np.arange(n + 1)[:, None] * (np.pi / n)
    x, y, z = np.sin(theta) * np.sin(azimuth), np.cos(theta), -np.sin(theta) * np.cos(azimuth)
    y, z = np.broadcast_to(-z, x.shape), np.broadcast_to(y, x.shape)
    place = to_square(np.stack([x, y, z], axis=-1)) * n - 0.5
    first = np.floor(place).astype(np.int64)
    s, t = np.moveaxis((place - first).astype(np.float32), -1, 0)[..., None]
    rows = [
        sum(weight * texel(square, first[..., 0] + i, first[..., 1] + j) for i, weight in along)
        for j, along in ((0, ((0, 1 - s), (1, s))), (1, ((0, 1 - s), (1, s))))
    ]
    return (rows[0] + t * (rows[1] - rows[0])).astype(np.float32)


def texel(square: Array, column: Array, row: Array) -> Array:
    """Look texels of a square up; beyond an edge the other half of the same edge goes on."""
    n = len(square)
    outside = (column < 0) | (column >= n)
    row = np.where(outside, n - 1 - row, row)
    column = np.where(outside, np.where(column < 0, -1 - column, 2 * n - 1 - column), column)
    outside = (row < 0) | (row >= n)
    column = np.where(outside, n - 1 - column, column)
    row = np.where(outside, np.where(row < 0, -1 - row, 2 * n - 1 - row), row)
    return square[row, column]
