r"""The change of basis of cameras: from the camera's own axes (u, v, w) to the world's and back.

A point of the film (x right, y down, in pixels of the full film, the corner of the first pixel at
(0, 0)) lies in the camera's own space at

.. math:: \Bigl(\bigl(\tfrac{2x}{W} - 1\bigr) s_x,\; \bigl(1 - \tfrac{2y}{H}\bigr) s_y,\; -1\Bigr)

where the half extents :math:`s_x, s_y` are tangents of half the opening angles (perspective) or
metres (orthographic). The matrix `to_world` is applied to cameras as to any other geometry: its
columns are the axes u, v, w and the origin, its scale enlarges a lens, and a mirrored camera sees
a mirrored picture.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def perspective_half_extents(fov: float, axis: str, width: int, height: int) -> tuple[float, float]:
    """Tangents of half the horizontal and half the vertical opening angle.

    Parameters
    ----------
    fov : float, degrees
        Opening angle across the side `axis` of the film.
    axis : {"x", "y", "smaller", "larger", "diagonal"}
    width, height : int
        Size of the full film in pixels (pixels are square).
    """
    side = {
        "x": width,
        "y": height,
        "smaller": min(width, height),
        "larger": max(width, height),
        "diagonal": math.hypot(width, height),
    }[axis]
    tangent = math.tan(0.5 * math.radians(fov))
    return tangent * width / side, tangent * height / side


def camera_table(
    half_extents: tuple[float, float],
    size: tuple[int, int],
    to_world: Array,
    *,
    lens_radius: float = 0.0,
    focus_distance: float = 1.0,
) -> Array:
    """Table of a camera's kernel, in world space; slots are named in `alight.cameras.table`.

    The axes are divided by the length of the viewing axis, as directions are normalised anyway;
    `focus_distance` is multiplied by it, so that it stays a distance in the camera's own space.
    """
    (half_x, half_y), (width, height) = half_extents, size
    u, v, w = to_world[:3, 0], to_world[:3, 1], to_world[:3, 2]
    scale = float(np.linalg.norm(w))
    right, down = u * (2.0 * half_x / width), -v * (2.0 * half_y / height)
    parts = [
        [0.5 * width, 0.5 * height, focus_distance * scale],
        to_world[:3, 3],
        -w / scale,
        right / scale,
        down / scale,
        u * lens_radius,
        v * lens_radius,
        right,
        down,
    ]
    return np.concatenate(parts)


def project_points(
    points: ArrayLike,
    half_extents: tuple[float, float],
    size: tuple[int, int],
    to_world: Array,
    perspective: bool,
) -> Array:
    """World points, shape (..., 3), to film coordinates and depth, shape (..., 3).

    Depth is the distance along the viewing axis in the camera's own space. Points that no ray of
    a perspective camera reaches (depth <= 0) get NaN film coordinates.
    """
    p = (np.asarray(points, np.float64) - to_world[:3, 3]) @ np.linalg.inv(to_world[:3, :3]).T
    depth = -p[..., 2]
    distance = np.where(depth > 0.0, depth, np.nan) if perspective else np.ones_like(depth)
    x = (p[..., 0] / (distance * half_extents[0]) + 1.0) * (0.5 * size[0])
    y = (1.0 - p[..., 1] / (distance * half_extents[1])) * (0.5 * size[1])
    return np.stack([x, y, depth], axis=-1)


def unproject_points(
    raster: ArrayLike,
    half_extents: tuple[float, float],
    size: tuple[int, int],
    to_world: Array,
    perspective: bool,
) -> Array:
    """The inverse of `project_points`: film coordinates and depth to world points."""
    raster = np.asarray(raster, np.float64)
    depth = raster[..., 2]
    distance = depth if perspective else np.ones_like(depth)
    x = (2.0 * raster[..., 0] / size[0] - 1.0) * half_extents[0] * distance
    y = (1.0 - 2.0 * raster[..., 1] / size[1]) * half_extents[1] * distance
    return np.stack([x, y, -depth], axis=-1) @ to_world[:3, :3].T + to_world[:3, 3]
