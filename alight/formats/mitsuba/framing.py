"""A camera and light for files of Mitsuba that hold shapes alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.formats.mitsuba.context import Context, Data
from alight.formats.mitsuba.transforms import matrix_of
from alight.formats.surroundings import Bounds, add_camera, add_light
from alight.shapes.mesh import Mesh

MOST_LEVELS = 16
_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def surround(context: Context, data: Data, nodes: dict[str, Any]) -> Bounds:
    """Place a camera that sees all shapes, and a studio around them if nothing shines.

    Returns
    -------
    Bounds
        What the camera sees.
    """
    bounds = Bounds()
    _add(context, bounds, nodes, np.eye(4))
    add_camera(data, context.report, bounds)
    shines = any("light" in node for node in nodes.values())
    if not shines and "environment" not in data:
        add_light(data, context.report, shines=False)
    return bounds


def _add(
    context: Context, bounds: Bounds, nodes: dict[str, Any], matrix: np.ndarray, level: int = 0
) -> None:
    for node in nodes.values():
        placed = matrix @ _matrix(node.get("transform", []))
        points = _points(node.get("shape"))
        if points is not None and len(points):
            bounds.add(points, placed)
        prototype = context.tables["prototypes"].get(node.get("instance"), {})
        if prototype and level < MOST_LEVELS:
            _add(context, bounds, prototype["children"], placed, level + 1)


def _matrix(transform: Any) -> np.ndarray:
    if isinstance(transform, dict):
        transform = transform["keyframes"][0]["steps"]
    return matrix_of(transform)


def _points(shape: Any) -> np.ndarray | None:
    """Points whose box holds a shape."""
    if isinstance(shape, Mesh):
        return shape.vertices
    if not isinstance(shape, dict):
        return None
    if shape["type"] == "sphere":
        return np.array(shape.get("center", [0.0] * 3)) + shape.get("radius", 1.0) * _SIGNS
    if shape["type"] == "cylinder":
        ends = np.array([shape.get("p0", [0.0] * 3), shape.get("p1", [0.0, 0.0, 1.0])])
        return np.concatenate([end + shape.get("radius", 1.0) * _SIGNS for end in ends])
    return _SIGNS if shape["type"] == "cube" else _SIGNS * [1.0, 1.0, 0.0]
