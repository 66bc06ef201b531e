"""Warnings of bodies that scatter light inside and will not look as they should."""

from __future__ import annotations

from alight.bsdfs.nesting import scatters_inside
from alight.compiled.boxes import box_of
from alight.meshes.volume import enclosed_volume
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape

INSIDE_OUT = "a body whose normals point inwards is black: give its shape flip_normals: true"
TURNED_OVER = "a body whose normals point inwards is black: leave out flip_normals"


def warnings_of_bodies(flat: FlatScene) -> tuple[str, ...]:
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
    """Bodies in a medium that fills another shape, without a border where it ends at them."""
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
