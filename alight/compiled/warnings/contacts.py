"""Boundaries of bodies that lie in one another: rays meet only one of the two.

A ray starts again beyond the rounding of the point that it has met (`alight.shapes.hit`), and with
it beyond a second face in the same place. Which face it meets is left to chance or to the order of
the scene; the path is then in the wrong medium, or leaves glass that it never entered. Faces are
looked at that lie across an axis, as those of boxes do.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.bsdfs.model import BSDFS
from alight.bsdfs.nesting import leaves
from alight.core.spec import Bsdf
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.shapes.model import SHAPES

_Corners = tuple[NDArray[np.float64], NDArray[np.float64]]

#: Steps of float32 within which faces are in one place, and within which they are flat: boxes have
#: room for rounding.
NEAR, FLAT = 4.0, 64.0

#: Boundaries, triangles of one mesh, those of them across an axis, and faces in one plane that are
#: looked at: scenes are compiled at every edit, and this must not be felt.
MOST_BOUNDARIES, LARGEST_MESH, MOST_TRIANGLES, MOST_FACES = 512, 1 << 16, 4096, 512


class Faces(NamedTuple):
    """Boxes without thickness: (n,) numbers of their shapes, and (n, 3) corners, metres."""

    shape: NDArray[np.int64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def warnings_of_contacts(flat: FlatScene, origin: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[str, ...]:
    """Warn of two boundaries of media or glass that share a part of a face.

    Parameters
    ----------
    flat : FlatScene
        In rendering space.
    origin : (3,) float, metres
        Where in the world its origin is.
    """
    bends = [_bends(bsdf) for bsdf in flat.bsdfs]
    bounding = [
        number
        for number, placed in enumerate(flat.shapes)
        if placed.motion is None and (placed.border is not None or bends[placed.bsdf])
    ][:MOST_BOUNDARIES]
    if len(bounding) < 2:
        return ()
    found = [_faces(flat, flat.shapes[number]) for number in bounding]
    faces = Faces(
        np.repeat(bounding, [len(low) for low, _ in found]),
        *(np.concatenate(side) for side in zip(*found, strict=True)),
    )
    size = np.maximum(np.abs(faces.low), np.abs(faces.high))
    is_across = faces.high - faces.low <= _steps(size, FLAT)
    for axis, name in enumerate("xyz"):
        across = Faces(*(part[is_across[:, axis]] for part in faces))
        pair = _first_pair(across, axis)
        if pair is not None:
            first, second, place = pair
            names = " and ".join(flat.shapes[number].name for number in (first, second))
            where = f"{name} = {place + np.asarray(origin, float)[axis]:.6g}"
            text = (
                f"{names} have faces in one place, {where}: rays meet only one of them, and light "
                "is lost or gained; leave a gap, or one face as the boundary of both"
            )
            return (text,)
    return ()


def _bends(bsdf: Bsdf) -> bool:
    """Whether light that enters a body of the material is refracted."""
    models = (BSDFS[leaf.bsdf.type_name()] for leaf in leaves(bsdf))
    return any(model.relative_ior is not None or model.inner_index is not None for model in models)


def _steps(size: NDArray[np.float64], count: float) -> NDArray[np.float64]:
    """So many steps of float32 at places of this size."""
    return count * np.spacing(np.abs(size).astype(np.float32)).astype(np.float64)


def _faces(flat: FlatScene, placed: PlacedShape) -> _Corners:
    """Lower and upper corners of the parts of a shape; those with a thickness are no faces."""
    if placed.geometry != NO_GEOMETRY:
        return _faces_of_mesh(flat, placed)
    found = []
    for part, place in placed.shape.parts() or ((placed.shape, np.eye(4)),):
        model = SHAPES[part.type_name()]
        if model.pack is not None and model.bounds is not None and not model.is_many:
            found.append(model.bounds(model.pack(part, placed.to_world @ place)))
    corners = np.array(found, np.float64).reshape(-1, 2, 3)
    return corners[:, 0], corners[:, 1]


def _faces_of_mesh(flat: FlatScene, placed: PlacedShape) -> _Corners:
    """The same of boxes around the triangles in planes across an axis, if these are few."""
    mesh = flat.geometries[placed.geometry]
    nothing = np.zeros((0, 3)), np.zeros((0, 3))
    if len(mesh.faces) > LARGEST_MESH:
        return nothing
    points = mesh.vertices.astype(np.float64) @ placed.to_world[:3, :3].T + placed.to_world[:3, 3]
    corners = points[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    is_flat = high - low <= _steps(np.maximum(np.abs(low), np.abs(high)), NEAR)
    chosen = is_flat.any(axis=1)
    if chosen.sum() > MOST_TRIANGLES:
        return nothing
    return low[chosen], high[chosen]


def _first_pair(faces: Faces, axis: int) -> tuple[int, int, float] | None:
    """Two shapes with faces across an axis that share an area, and where."""
    middle = 0.5 * (faces.low + faces.high)[:, axis]
    order = np.argsort(middle, kind="stable")
    shape, low, high = (part[order] for part in faces)
    places = middle[order]
    starts = np.flatnonzero(np.diff(places, prepend=-np.inf) > _steps(places, NEAR))
    for start, end in pairwise([*starts, len(places)]):
        if end - start < 2:
            continue
        one = slice(start, min(end, start + MOST_FACES))
        below = np.maximum(low[one, None], low[None, one])
        above = np.minimum(high[one, None], high[None, one])
        shared = above - below > _steps(np.maximum(np.abs(below), np.abs(above)), FLAT)
        shared = np.delete(shared, axis, axis=2).all(axis=2)
        pairs = np.argwhere(shared & (shape[one, None] != shape[None, one]))
        if len(pairs):
            first, second = start + pairs[0].min(), start + pairs[0].max()
            return int(shape[first]), int(shape[second]), float(places[first])
    return None
