"""Bodies that scatter light inside and will not look as they should: what is said about them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.nesting import scatters_inside
from alight.meshes.volume import enclosed_volume
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.shapes.model import SHAPES

Box = tuple[NDArray[np.float64], NDArray[np.float64]]

INSIDE_OUT = "a body whose normals point inwards is black: give its shape flip_normals: true"
TURNED_OVER = "a body whose normals point inwards is black: leave out flip_normals"


def suspicious_bodies(flat: FlatScene) -> tuple[str, ...]:
    """Warn of bodies that are inside out, and of those in fog that does not end at them."""
    inner = [scatters_inside(bsdf) for bsdf in flat.bsdfs]
    bodies = [placed for placed in flat.shapes if inner[placed.bsdf]]
    found, volumes = [], {}
    for placed in bodies:
        number = placed.geometry
        if number == NO_GEOMETRY:
            if placed.shape.closed and getattr(placed.shape, "flip_normals", False):
                found.append(f"{placed.name}: {TURNED_OVER}")
            continue
        if number not in volumes:
            mesh = flat.geometries[number]
            volumes[number] = enclosed_volume(mesh.vertices, mesh.faces)
        turned = getattr(placed.shape, "flip_normals", False)
        if volumes[number] * (-1.0 if turned else 1.0) < 0.0:
            found.append(f"{placed.name}: {TURNED_OVER if turned else INSIDE_OUT}")
    return (*found, *_in_fog(flat, bodies))


def _in_fog(flat: FlatScene, bodies: list[PlacedShape]) -> list[str]:
    """Bodies in a medium that fills another shape, and not told that it ends at them."""
    alone = [placed for placed in bodies if placed.border is None]
    filled = [placed for placed in flat.shapes if placed.border and placed.border[0]]
    if not (flat.integrator.sees_media and alone and filled):
        return []
    boxes = [(placed.name, box) for placed in filled if (box := box_of(flat, placed))]
    found = []
    for placed in alone:
        own = box_of(flat, placed)
        if own is None:
            continue
        for name, (low, high) in boxes:
            if (own[0] >= low).all() and (own[1] <= high).all():
                text = "scatters light inside; if the medium of a shape around it goes on there"
                found.append(f"{placed.name}: {text}, give it the interior of {name} as exterior")
                break
    return found


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
