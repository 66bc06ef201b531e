"""Tables of the bodies that absorb light, and where they are; the ball around those without end."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.bsdfs.interiors.bodies import NO_BODY, BodyTables, body_below
from alight.bsdfs.nesting import scatters_inside
from alight.compiled.boxes import box_of
from alight.compiled.materials import MaterialTables
from alight.compiled.shapes import CompiledShapes
from alight.meshes.volume import enclosed_volume
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from lanewise.view import View

#: Materials of scenes with bodies that absorb light.
AbsorbingMaterials = namedtuple("AbsorbingMaterials", (*MaterialTables._fields, "bodies"))


def with_bodies(materials: MaterialTables, flat: FlatScene) -> AbsorbingMaterials:
    """The tables of a scene in which bodies absorb light."""
    bodies = [body_below(bsdf) for bsdf in flat.bsdfs]
    numbers = np.array([body or NO_BODY for body in bodies], np.float32)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for placed in flat.shapes:
        if any(bodies[placed.bsdf] or ()):
            box = None if placed.motion else box_of(flat, placed)
            around = box or (np.full(3, -np.inf), np.full(3, np.inf))
            low, high = np.minimum(low, around[0]), np.maximum(high, around[1])
    corners = np.concatenate([low, high]).astype(np.float32)
    return AbsorbingMaterials(*materials, BodyTables(View(numbers.ravel()), View(corners)))


# ---------------------------------------------------------------- bodies without an end

#: Materials of scenes with bodies that may have no end, with and without such as absorb light.
EndlessMaterials = namedtuple("EndlessMaterials", (*MaterialTables._fields, "ball"))
AbsorbingAndEndless = namedtuple("AbsorbingAndEndless", (*AbsorbingMaterials._fields, "ball"))


def may_be_endless(flat: FlatScene, shapes: CompiledShapes) -> bool:
    """Whether walks through bodies may leave all shapes behind, which have an end themselves.

    Below a plane walks come back wherever they are, so there must be none.
    """
    return not shapes.unbounded and bool(open_bodies(flat))


def open_bodies(flat: FlatScene) -> list[int]:
    """Numbers of the shapes with a body below that have no inside on their own."""
    inner = [scatters_inside(bsdf) for bsdf in flat.bsdfs]
    bodies = ((n, placed) for n, placed in enumerate(flat.shapes) if inner[placed.bsdf])
    return [number for number, placed in bodies if not _is_closed(flat, placed)]


def _is_closed(flat: FlatScene, placed: PlacedShape) -> bool:
    if placed.geometry == NO_GEOMETRY:
        return placed.shape.closed
    mesh = flat.geometries[placed.geometry]
    return enclosed_volume(mesh.vertices, mesh.faces) != 0.0


def with_ball(
    materials: MaterialTables | AbsorbingMaterials, shapes: CompiledShapes
) -> EndlessMaterials | AbsorbingAndEndless:
    """The tables with the ball around all shapes: its centre and its radius, metres."""
    both = isinstance(materials, AbsorbingMaterials)
    ball = np.array([*shapes.center, shapes.radius], np.float32)
    return (AbsorbingAndEndless if both else EndlessMaterials)(*materials, View(ball))
