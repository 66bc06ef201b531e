"""Matrices that place prims."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.fields import LARGEST
from alight.scene.transform import is_singular

Matrix = NDArray[np.float64]


def is_inside(to_world: Matrix, radius: float, points: Any) -> bool:
    """Whether world points are all within a ball around the origin of a prim."""
    if is_singular(to_world) or not len(points) or not np.isfinite(points).all():
        return False
    return bool((np.linalg.norm(_to_local(to_world, points), axis=1) < radius).all())


def _to_local(to_world: Matrix, points: Any) -> Matrix:
    """World points (n, 3) as a prim has them."""
    found = np.linalg.solve(to_world[:3, :3], (np.asarray(points, np.float64) - to_world[:3, 3]).T)
    return np.asarray(found.T, np.float64)


def is_placement(matrix: Matrix) -> bool:
    """Whether a matrix is affine, of numbers whose products can be formed; NaN is none."""
    is_small = np.abs(matrix).max() <= LARGEST
    return bool(is_small and np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0]))
