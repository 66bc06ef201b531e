r"""The transformations of pbrt, (4, 4) float64.

Directives multiply the current matrix from the right, so that the last one acts first.

pbrt's cameras look along +z with x to the right and y up, in a left-handed space; ours along -z.
The coordinates of the world are taken as they are: one mirror in the camera's matrix,
:math:`M_\text{ours} = M_\text{pbrt} \operatorname{diag}(1, 1, -1)`, makes the same picture, and
pbrt's rules for the sides of surfaces, which are rules about numbers, hold unchanged.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Matrix = np.ndarray

#: From our camera's space to pbrt's.
FACING = np.diag([1.0, 1.0, -1.0, 1.0])


def translation(x: float, y: float, z: float) -> Matrix:
    """Move by (x, y, z)."""
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def scaling(x: float, y: float, z: float) -> Matrix:
    """Scale along the axes."""
    return np.diag([x, y, z, 1.0])


def rotation(degrees: float, axis: np.ndarray) -> Matrix | None:
    """Turn about an axis; None if it has no direction. Source: Rodrigues' formula."""
    length = float(np.linalg.norm(axis))
    if not 0.0 < length < math.inf:
        return None
    x, y, z = axis / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(degrees)
    result = np.eye(4)
    result[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return result


def look_at(eye: np.ndarray, target: np.ndarray, up: np.ndarray) -> Matrix | None:
    """From the world to a camera that looks along +z; None if there is no such camera."""
    view = target - eye
    with np.errstate(over="ignore", invalid="ignore"):
        forward = view / np.linalg.norm(view) if np.any(view) else view
        right = np.cross(up / np.linalg.norm(up), forward) if np.any(up) else 0.0 * up
        length = float(np.linalg.norm(right))
    if not 1e-12 < length < math.inf:
        return None
    result = np.eye(4)
    result[:3, 0] = right / length
    result[:3, 1] = np.cross(forward, right / length)
    result[:3, 2] = forward
    result[:3, 3] = eye
    return inverse(result)


def inverse(matrix: Matrix) -> Matrix | None:
    """Invert; None if there is no inverse."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            result = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return None
    return result if np.isfinite(result).all() else None


def turned_to(direction: np.ndarray) -> Matrix:
    """A rotation that takes +z to a direction, which must not have length 0."""
    z = direction / np.linalg.norm(direction)
    # Any axis that is not parallel will do: lights along +z look the same from all around.
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    result = np.eye(4)
    result[:3, 0], result[:3, 1], result[:3, 2] = x, np.cross(z, x), z
    return result


def swaps_handedness(matrix: Matrix) -> bool:
    """Whether it turns a right hand into a left one."""
    return bool(np.linalg.det(matrix[:3, :3]) < 0.0)


def keeps_angles(matrix: Matrix) -> bool:
    """Whether it is made of turns, mirrors and one scale for all axes."""
    square = matrix[:3, :3].T @ matrix[:3, :3]
    return bool(np.allclose(square, np.eye(3) * square[0, 0], rtol=0.0, atol=1e-4 * square[0, 0]))


def steps(matrix: Matrix) -> dict[str, list[list[float]]] | None:
    """Write a matrix as a step of the native format; None for the identity."""
    return None if np.array_equal(matrix, np.eye(4)) else {"matrix": matrix.tolist()}


def keyframes(
    begin: Matrix, end: Matrix, times: tuple[float, float]
) -> dict[str, list[dict[str, object]]]:
    """Write two matrices as keyframes of the native format."""
    pairs = zip(times, (begin, end), strict=True)
    return {"keyframes": [{"time": time, "matrix": matrix.tolist()} for time, matrix in pairs]}


def moving(
    node: dict[str, Any], name: str, begin: Matrix, end: Matrix, times: tuple[float, float]
) -> dict[str, Any]:
    """Let a node move that stands right for the matrix `begin`; unless that has no inverse."""
    placed = np.array(node["transform"]["matrix"]) if "transform" in node else np.eye(4)
    back = inverse(begin)
    if np.array_equal(placed, begin) or back is None:
        return {**node, "transform": keyframes(begin, end, times)}
    rest = {**node, "transform": steps(back @ placed)}
    return {"transform": keyframes(begin, end, times), "children": {name: rest}}


def only_turns(begin: Matrix, end: Matrix) -> bool:
    """Whether what is between two matrices only shifts and turns."""
    back = inverse(begin)
    if back is None or not np.isfinite(end).all():
        return False
    linear = (end @ back)[:3, :3]
    near = np.allclose(linear.T @ linear, np.eye(3), rtol=0.0, atol=1e-9)
    return near and not swaps_handedness(linear)
