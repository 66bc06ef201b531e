"""Arrays as mesh files hold them, and polygons cut into triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError


class MeshArrays(NamedTuple):
    """What a mesh file holds, unchecked; shapes as in `alight.shapes.mesh.Mesh`."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None = None
    uvs: NDArray[np.float32] | None = None
    colors: NDArray[np.float32] | None = None
    more_uvs: NDArray[np.float32] | None = None


def joined_sets(
    tables: Sequence[NDArray[np.float32] | None],
) -> tuple[NDArray[np.float32] | None, NDArray[np.float32] | None]:
    """`uvs` and `more_uvs` of a mesh from its sets of texture coordinates; v upwards.

    Where a set is lacking, another one takes its place.
    """
    found = [table for table in tables if table is not None]
    if not found:
        return None, None
    own, *more = (found[0] if table is None else table for table in tables)
    return own, np.stack(more) if more else None


def broken(message: str) -> SceneError:
    """Make the error of a broken file; the caller adds the file's name."""
    return SceneError([Issue("", message)])


def fan(sizes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut polygons into fans of triangles around their first corners.

    Parameters
    ----------
    sizes : (p,) int64
        Corners of each polygon; those with fewer than 3 give no triangle.

    Returns
    -------
    corners : (m, 3) int64
        Positions in the concatenated list of all corners.
    polygons : (m,) int64
        The polygon of each triangle.
    """
    counts = np.maximum(sizes - 2, 0)
    polygons = np.repeat(np.arange(len(sizes)), counts)
    starts = np.cumsum(sizes) - sizes
    # 0, 1, 2, ... within each polygon
    within = np.arange(len(polygons)) - np.repeat(np.cumsum(counts) - counts, counts)
    first = starts[polygons]
    return np.stack([first, first + within + 1, first + within + 2], axis=1), polygons


def srgb_to_linear(color: NDArray[np.float32]) -> NDArray[np.float32]:
    """Undo the sRGB curve (IEC 61966-2-1), in which files store 8-bit colours."""
    low = color / np.float32(12.92)
    high = ((color + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(color <= 0.04045, low, high).astype(np.float32)
