"""Where prims and their points are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.fields import LARGEST
from alight.formats.reading.report import Report
from alight.formats.usd.stage import Stage
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


def say_what_is_inside(
    report: Report, balls: Sequence[tuple[str, Matrix, float]], places: Sequence[Any]
) -> None:
    """Tell why it is dark in lamps that are balls: name, matrix and radius of each.

    Parameters
    ----------
    report : Report
    balls : sequence of (str, (4, 4) float64, float)
    places : sequence of (n, 3) array_like
        World points of the scene, and of the camera.
    """
    for path, to_world, radius in balls:
        if any(is_inside(to_world, radius, points) for points in places):
            text = "it shines outwards only, as UsdLux has it: inside of it is no light"
            report.approximate(f"{path}: {text}; a DomeLight shines from all around")


def is_placement(matrix: Matrix) -> bool:
    """Whether a matrix is affine, of numbers whose products can be formed; NaN is none."""
    is_small = np.abs(matrix).max() <= LARGEST
    return bool(is_small and np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0]))


def are_in_range(stage: Stage, prim: Any, points: NDArray[np.float64]) -> bool:
    """Whether the points (n, 3) of a prim can be computed with; reports the first that cannot."""
    wrong = ~(np.abs(points) <= LARGEST).all(axis=1)
    if wrong.any():
        place = int(wrong.argmax())
        text = f"its points must be finite and at most {LARGEST:g} in size"
        stage.problem(prim, f"{text}, got {points[place].tolist()} at place {place}")
    return not wrong.any()
