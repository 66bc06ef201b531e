"""Open shapes with a body below: light walks out of the opening, into a body without an end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.compiled.bodies import open_bodies
from alight.compiled.shapes import CompiledShapes
from alight.compiled.warnings.sizes import named
from alight.meshes.volume import open_edges
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape

ENDLESS = (
    "what scatters light inside has no end where its shape is open: light that leaves by the "
    "opening is scattered on and on; close the shape"
)

#: Open shapes, and points of an edge, that are asked whether another shape is there: of more, some
#: all along.
MOST_SHAPES, MOST_POINTS = 256, 64

#: What is nearer to an edge than this part of the shape's size touches it.
NEAR = 1e-3


def warnings_of_edges(flat: FlatScene, shapes: CompiledShapes) -> tuple[str, ...]:
    """Warn of bodies at whose edges no other shape is that may close them.

    Boxes decide: where one touches an edge, as a lid's or a floor's may, there is no warning.
    """
    numbers = [number for number in open_bodies(flat) if flat.shapes[number].motion is None]
    numbers = numbers[:: -(-len(numbers) // MOST_SHAPES) or 1]
    if not numbers or not shapes.extents:
        return ()
    rows, *sides = zip(*shapes.extents, strict=True)
    boxes = [[np.atleast_2d(corner) for corner in side] for side in sides]
    owner = np.repeat([shapes.rows[row].source for row in rows], [len(one) for one in boxes[0]])
    low, high = (np.concatenate(side) for side in boxes)
    planes = [np.linalg.inv(placed.to_world) for placed in flat.shapes if not placed.shape.finite]
    found = []
    for number in numbers:
        points = _edge_points(flat, flat.shapes[number])
        if not len(points):
            continue
        near = NEAR * float(np.ptp(points, axis=0).max())
        beside = (low <= points.max(axis=0) + near) & (high >= points.min(axis=0) - near)
        others = (owner != number) & beside.all(axis=1)
        at, below, above = points[:, None], low[others] - near, high[others] + near
        touched = ((at >= below) & (at <= above)).all(axis=2).any(axis=1)
        for inverse in planes:
            # What has no edges itself is the plane z = 0 of its space.
            touched |= np.abs(points @ inverse[2, :3] + inverse[2, 3]) <= near
        if not touched.all():
            found.append(number)
    return (f"{named(flat, np.array(found))} {ENDLESS}",) if found else ()


def _edge_points(flat: FlatScene, placed: PlacedShape) -> NDArray[np.float64]:
    """Some points on the edges of a shape, (n, 3), metres."""
    points = placed.shape.edges()
    if placed.geometry != NO_GEOMETRY:
        mesh = flat.geometries[placed.geometry]
        points = open_edges(mesh.vertices, mesh.faces)
        points = points[:: max(len(points) // MOST_POINTS, 1)]
    return points @ placed.to_world[:3, :3].T + placed.to_world[:3, 3]
