"""Boundaries of bodies that lie in one another: rays meet only one of the two.

A ray starts again beyond the rounding of the point that it has met (`alight.shapes.hit`), and with
it beyond a second face in the same place. Which face it meets is left to chance or to the order of
the scene; the path is then in the wrong medium, or leaves glass that it never entered. Faces are
looked at that lie across an axis, as those of boxes do.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.bsdfs.model import BSDFS
from alight.bsdfs.nesting import leaves
from alight.core.spec import Bsdf
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.shapes.model import SHAPES

#: Steps of float32 within which faces are in one place, and within which they are flat: boxes have
#: room for rounding.
NEAR, FLAT = 4.0, 64.0

#: Faces in one plane of which all pairs are looked at.
MOST_FACES = 256


class Face(NamedTuple):
    """A box without thickness: the number of its shape, and two corners, metres."""

    shape: int
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def suspicious_contacts(flat: FlatScene, origin: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[str, ...]:
    """Warn of the first two boundaries of media or glass that share a part of a face.

    Parameters
    ----------
    flat : FlatScene
        In rendering space.
    origin : (3,) float, metres
        Where in the world its origin is.
    """
    shift = np.asarray(origin, float)
    bends = [_bends(bsdf) for bsdf in flat.bsdfs]
    bounding = [
        (number, placed)
        for number, placed in enumerate(flat.shapes)
        if placed.motion is None and (placed.border is not None or bends[placed.bsdf])
    ]
    if len(bounding) < 2:
        return ()
    faces = [face for number, placed in bounding for face in _faces(flat, number, placed)]
    for axis, name in enumerate("xyz"):
        across = sorted(
            (face for face in faces if _is_across(face)[axis]), key=lambda face: _place(face, axis)
        )
        for first, second in _in_one_place(across, axis):
            if first.shape != second.shape and _overlap(first, second, axis):
                return (
                    _told(flat, first, second, f"{name} = {_place(first, axis) + shift[axis]:.6g}"),
                )
    return ()


def _told(flat: FlatScene, first: Face, second: Face, where: str) -> str:
    names = " and ".join(flat.shapes[face.shape].name for face in (first, second))
    return (
        f"{names} have faces in one place, {where}: rays meet only one of them, and light is lost "
        "or gained; leave a gap, or one face as the boundary of both"
    )


def _bends(bsdf: Bsdf) -> bool:
    """Whether light that enters a body of the material is refracted."""
    models = (BSDFS[leaf.bsdf.type_name()] for leaf in leaves(bsdf))
    return any(model.relative_ior is not None or model.inner_index is not None for model in models)


def _steps(size: NDArray[np.float64], count: float) -> NDArray[np.float64]:
    """So many steps of float32 at places of this size."""
    return count * np.spacing(np.abs(size).astype(np.float32)).astype(np.float64)


def _place(face: Face, axis: int) -> float:
    """Where it lies across an axis."""
    return float(face.low[axis] + face.high[axis]) / 2.0


def _is_across(face: Face) -> NDArray[np.bool_]:
    """Across which axes it lies: it has no thickness along them."""
    size = np.maximum(np.abs(face.low), np.abs(face.high))
    return face.high - face.low <= _steps(size, FLAT)


def _faces(flat: FlatScene, number: int, placed: PlacedShape) -> list[Face]:
    """The faces of a shape that lie across an axis."""
    if placed.geometry != NO_GEOMETRY:
        return _faces_of_mesh(flat, number, placed)
    found = []
    for part, place in placed.shape.parts() or ((placed.shape, np.eye(4)),):
        model = SHAPES[part.type_name()]
        if model.pack is None or model.bounds is None or model.is_many:
            continue
        low, high = model.bounds(model.pack(part, placed.to_world @ place))
        face = Face(number, np.asarray(low, float), np.asarray(high, float))
        found += [face] * bool(_is_across(face).any())
    return found


def _faces_of_mesh(flat: FlatScene, number: int, placed: PlacedShape) -> list[Face]:
    """One face around all triangles in a plane."""
    mesh, found = flat.geometries[placed.geometry], []
    points = mesh.vertices.astype(np.float64) @ placed.to_world[:3, :3].T + placed.to_world[:3, 3]
    corners = points[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    flat_along = high - low <= _steps(np.maximum(np.abs(low), np.abs(high)), NEAR)
    for axis in range(3):
        chosen = flat_along[:, axis]
        planes, of_plane = np.unique(low[chosen, axis].astype(np.float32), return_inverse=True)
        if len(planes) > MOST_FACES:
            continue
        for plane in range(len(planes)):
            inside = of_plane == plane
            below, above = low[chosen][inside], high[chosen][inside]
            found.append(Face(number, below.min(axis=0), above.max(axis=0)))
    return found


def _in_one_place(faces: list[Face], axis: int) -> list[tuple[Face, Face]]:
    """Pairs of neighbours along the axis, of the faces as sorted."""
    found: list[tuple[Face, Face]] = []
    start = 0
    places = np.array([_place(face, axis) for face in faces])
    for end in range(1, len(faces) + 1):
        if end == len(faces) or places[end] - places[end - 1] > _steps(places[end], NEAR):
            found += combinations(faces[start : min(end, start + MOST_FACES)], 2)
            start = end
    return found


def _overlap(a: Face, b: Face, axis: int) -> bool:
    """Whether two faces in one plane share an area."""
    low, high = np.maximum(a.low, b.low), np.minimum(a.high, b.high)
    shared = high - low > _steps(np.maximum(np.abs(low), np.abs(high)), FLAT)
    return bool(np.delete(shared, axis).all())
