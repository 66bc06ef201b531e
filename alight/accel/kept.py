"""Trees of meshes, kept for as long as the arrays that they are of."""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.accel.build import build_bvh
from alight.accel.layout import Bvh
from alight.core.by_arrays import once

#: By the arrays; those of a scene are never changed.
_BOXES: dict[tuple, np.ndarray] = {}

#: By the arrays and the builder; arrays of a scene are never changed.
_TREES: dict[tuple[int, int, str], tuple[Bvh, dict[str, Any]]] = {}


def tree_of(
    vertices: np.ndarray, faces: np.ndarray, *, method: str, threads: int
) -> tuple[Bvh, dict[str, Any]]:
    """The tree of a mesh in its own space, as `build_bvh` builds it, and its figures.

    Of read-only arrays it is built once: who moves an instance gets it again.
    """
    return once(
        _TREES, (vertices, faces), method,
        lambda: build_bvh(vertices, faces, method=method, threads=threads),
    )  # fmt: skip


def own_box(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Bounds of the vertices that the faces (F, 3) of a mesh use, (2, 3) float32, metres."""

    def found() -> np.ndarray:
        used = np.zeros(len(vertices), bool)
        used[faces.ravel()] = True
        return np.array([vertices[used].min(axis=0), vertices[used].max(axis=0)])

    return once(_BOXES, (vertices, faces), None, found)
