r"""Normals of surfaces that come without: smooth but for creases.

A corner of a face has the mean normal of those faces at its vertex whose own normal differs from
the face's by no more than an angle, weighted by their angles there as in `alight.meshes.normals`:
a fine sphere is round, a cube keeps its edges. Vertices that have several normals are split.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Corners of a vertex that are compared each with each.
MOST_PAIRED = 1000
#: Pairs that are held in memory.
MOST_AT_A_TIME = 2**24
#: Cells along an axis for the directions of more: about 3 degrees, and at most some 7000 of them.
CELLS = 32
PLACES = np.array([(CELLS + 1) ** 2, CELLS + 1, 1])


def creased(
    vertices: NDArray[np.float32], faces: NDArray[np.int64], angle: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
    """Split vertices at creases.

    Parameters
    ----------
    vertices : (n, 3) float
    faces : (m, 3) int
    angle : float, degrees
        Largest one between faces that are shaded as one.

    Returns
    -------
    origin : (k,) int64
        The vertex that each new one is a copy of.
    faces : (m, 3) int64
        Of the new vertices.
    normals : (k, 3) float32
        Of the new vertices; 0 where all faces at one are degenerate.
    """
    corners = vertices.astype(np.float64)[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    across = _unit(np.cross(edges[:, 0], -edges[:, 2]))
    unit = _unit(edges)
    angles = np.arccos(np.clip(-(unit * np.roll(unit, 1, axis=1)).sum(axis=2), -1.0, 1.0))
    weighted = (across[:, None, :] * angles[:, :, None]).reshape(-1, 3)
    owner, at = np.repeat(np.arange(len(faces)), 3), faces.reshape(-1)
    mean = _unit(_summed(weighted, at, len(vertices)))
    # Faces within half the angle of the mean are within the angle of each other.
    near = (across[owner] * mean[at]).sum(axis=1) >= np.cos(np.radians(0.5 * angle))
    is_creased = np.zeros(len(vertices), bool)
    is_creased[at[~near]] = True
    split = np.flatnonzero(is_creased[at])
    normals = [mean, _normals_of_corners(split, at, owner, across, weighted, angle)]
    numbers = at.copy()
    numbers[split] = len(vertices) + np.arange(len(split))
    origin = np.concatenate([np.arange(len(vertices)), at[split]])
    used, new = np.unique(numbers, return_inverse=True)
    joined = np.concatenate(normals)[used].astype(np.float32)
    return origin[used], new.reshape(-1, 3), joined


def are_of(normals: Any, vertices: Any, faces: NDArray[np.int64]) -> bool:
    """Whether normals belong to a surface.

    Those of merged vertices of a box, say, are the normals of one face, or means over its edges:
    50 degrees and more from those of the faces.
    """
    corners = np.asarray(vertices, np.float64)[faces]
    across = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    cosine = np.einsum("fkc,fc->fk", _unit(np.asarray(normals, np.float64))[faces], across)
    return float((np.abs(cosine) < 0.64).mean()) < 0.05


def _normals_of_corners(
    split: NDArray[np.int64],
    at: NDArray[np.int64],
    owner: NDArray[np.int64],
    across: Array,
    weighted: Array,
    angle: float,
) -> Array:
    """Normals of some corners, each from those at the same vertex that are near enough."""
    order = split[np.argsort(at[split], kind="stable")]
    _, starts, counts = np.unique(at[order], return_index=True, return_counts=True)
    cosine = np.cos(np.radians(angle)) - 1e-9
    total = np.zeros((len(at), 3))
    for i in np.flatnonzero(counts > MOST_PAIRED):
        rows = order[starts[i] : starts[i] + counts[i]]
        total[rows] = _of_many(across[owner[rows]], weighted[rows], cosine)
    # All pairs of corners of a vertex, for vertices with as many corners at a time.
    for count in np.unique(counts[counts <= MOST_PAIRED]):
        alike = order[starts[counts == count][:, None] + np.arange(count)]
        for rows in np.array_split(alike, 1 + alike.size * count // MOST_AT_A_TIME):
            own = across[owner[rows]]
            with_own = np.einsum("vik,vjk->vij", own, own) >= cosine
            # A degenerate face has no normal to compare.
            with_own |= np.eye(count, dtype=bool)
            total[rows] = np.einsum("vij,vjk->vik", with_own.astype(float), weighted[rows])
    return _unit(total[split])


def _of_many(own: Array, weighted: Array, cosine: float) -> Array:
    """The sums of a vertex with very many corners, whose alike directions are taken together.

    Pairs of all corners would take the square of their number in time and memory.
    """
    cells = np.floor((own + 1.0) * (0.5 * CELLS)).astype(np.int64) @ PLACES
    _, first, cell = np.unique(cells, return_index=True, return_inverse=True)
    sums = _summed(weighted, cell.reshape(-1), len(first))
    with_own = own[first] @ own[first].T >= cosine
    with_own |= np.eye(len(first), dtype=bool)
    return (with_own.astype(float) @ sums)[cell.reshape(-1)]


def _summed(rows: Array, at: NDArray[np.int64], count: int) -> Array:
    sums = [np.bincount(at, rows[:, k], count) for k in range(3)]
    return np.stack(sums, axis=1).astype(np.float64)


def _unit(vectors: Any) -> Any:
    """Vectors of length 1; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
