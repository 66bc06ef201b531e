"""Boxes around shapes at rest, before there are tables of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.shapes.model import SHAPES

#: Lower and upper corner, metres.
Box = tuple[NDArray[np.float64], NDArray[np.float64]]


def box_of(flat: FlatScene, placed: PlacedShape) -> Box | None:
    """The box around a shape at rest, metres; None where it has none."""
    if placed.geometry != NO_GEOMETRY:
        points = flat.geometries[placed.geometry].vertices.astype(np.float64)
        points = points @ placed.to_world[:3, :3].T + placed.to_world[:3, 3]
        return points.min(axis=0), points.max(axis=0)
    corners: list[NDArray[np.float64]] = []
    for part, place in placed.shape.parts() or ((placed.shape, np.eye(4)),):
        model = SHAPES[part.type_name()]
        if model.pack is None or model.bounds is None or model.is_many:
            return None
        corners += model.bounds(model.pack(part, placed.to_world @ place))
    points = np.array(corners, np.float64)
    return points.min(axis=0), points.max(axis=0)
