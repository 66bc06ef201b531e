r"""A photographer's table: light around an object, and the floor below it.

``builtin:studio`` is a map of latitude and longitude: a large soft box above and to the left of the
front (+z), a weaker one to the right, a strip behind for the edges, walls that grow darker
downwards. Soft boxes are rectangles on a plane across their axis, as metals mirror them.

``builtin:studio-floor`` is the albedo of a round floor along its radius,

.. math:: \rho(r) = \rho_1 + (\rho_0 - \rho_1) (1 - r^2)^k

brighter in the middle, where the object stands. What lies below the horizon of the map is as bright
as the floor's edge, :math:`\rho_1 E / \pi` with the irradiance E of the upper half, and so is the
wall right above it: floor and backdrop meet without a line, from wherever they are seen.

White paper shows 0.9 where it faces the brightest light.

Source: Hunter, Biver and Fuqua, Light: Science and Magic (2015), for the set: a key light above, a
fill, an edge light, and bright and dark fields for glass and metal to mirror.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROWS = 128
#: Texels of the floor's radius.
STEPS = 1024
#: Albedo of the floor in the middle and at its edge, and k.
MIDDLE, EDGE, POWER = 0.5, 0.22, 24
#: Radiance of the walls at the zenith, and their colour.
CEILING, WALLS = 0.25, (0.94, 0.97, 1.0)
#: Sine of the height up to which the wall is as bright as the floor's edge, and of that at which
#: it is on its own.
SWEEP = (0.05, 0.5)
#: Direction (+x right, +y up, +z front), half width and height (radians, by their tangents),
#: radiance, colour.
SOFT_BOXES = (
    ((-0.8, 1.0, 0.7), (0.62, 0.48), 3.3, (1.0, 0.96, 0.9)),
    ((1.0, 0.55, 0.45), (0.35, 0.42), 1.1, (0.9, 0.95, 1.0)),
    ((0.45, 0.8, -1.0), (0.16, 0.5), 2.6, (1.0, 1.0, 1.0)),
)
#: Part of a soft box in which it falls off to its edge.
SOFT = 0.35


def studio() -> NDArray[np.float32]:
    """Radiance around the object, linear sRGB, shape (128, 256, 3), top row first."""
    azimuth = (np.arange(2 * ROWS) + 0.5) * (np.pi / ROWS)
    theta = (np.arange(ROWS) * (np.pi / (ROWS - 1)))[:, None]
    x, y, z = np.sin(theta) * np.sin(azimuth), np.cos(theta), -np.sin(theta) * np.cos(azimuth)
    y = y * np.ones_like(x)
    boxes = sum(_soft_box(x, y, z, *box) for box in SOFT_BOXES)
    up = smoothstep(y, *SWEEP)[:, :, None]
    above = boxes + up * (CEILING * np.asarray(WALLS))
    # Irradiance from above over pi, and the wall's own part in it: E / pi = a + b edge.
    solid = np.maximum(y, 0.0) * np.sin(theta) * (np.pi / (ROWS - 1)) * (np.pi / ROWS) / np.pi
    a = np.einsum("ij,ijk->k", solid, above)
    b = float((solid * (1.0 - up[:, :, 0])).sum())
    edge = EDGE * a / (1.0 - EDGE * b)
    return (above + (1.0 - up) * edge).astype(np.float32)


def studio_floor() -> NDArray[np.float32]:
    """Albedo of the floor from its middle to its edge, shape (1, 1024, 3)."""
    r = (np.arange(STEPS) + 0.5) / STEPS
    albedo = EDGE + (MIDDLE - EDGE) * (1.0 - r * r) ** POWER
    return np.repeat(albedo[None, :, None], 3, axis=2).astype(np.float32)


def smoothstep(x: Array, low: float, high: float) -> Array:
    """0 up to `low`, 1 from `high` on, a cubic between them."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _soft_box(
    x: Array,
    y: Array,
    z: Array,
    axis: tuple[float, float, float],
    half: tuple[float, float],
    strength: float,
    color: tuple[float, float, float],
) -> Array:
    front = np.array(axis) / np.linalg.norm(axis)
    right = np.cross([0.0, 1.0, 0.0], front)
    right /= np.linalg.norm(right)
    up = np.cross(front, right)
    across, along, ahead = (x * v[0] + y * v[1] + z * v[2] for v in (right, up, front))
    safe = np.where(ahead > 1e-3, ahead, 1.0)
    inside = np.where(ahead > 1e-3, 1.0, 0.0)
    for side, size in zip((across, along), half, strict=True):
        inside = inside * smoothstep(1.0 - np.abs(side / safe) / size, 0.0, SOFT)
    return strength * inside[:, :, None] * np.asarray(color)
