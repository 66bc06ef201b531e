"""Where the tables hold the further sets of texture coordinates of meshes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.core.uv_sets import MOST_SETS, NO_SET
from alight.shapes.hit import UVS


def uv_shifts(
    info: NDArray[np.uint32], further: dict[int, NDArray[np.float32]], vertices: int
) -> NDArray[np.uint32]:
    """What must be added to a vertex of a shape to find its row in a set.

    Parameters
    ----------
    info : (s, 8) uint32
        Rows of the shapes, see `alight.shapes.hit.INFO`.
    further : dict of int to (k, n, 2) float32
        First vertex of a mesh -> its sets after its own. They are stored one after the other, in
        this order, after the meshes' own coordinates.
    vertices : int
        Rows of the own coordinates.

    Returns
    -------
    (s, 8) uint32
        See `alight.core.uv_sets`.
    """
    shifts = np.full((len(info), MOST_SETS), NO_SET, np.uint32)
    shifts[(info[:, 4] & UVS) != 0, 0] = 0
    end = vertices
    for first, sets in further.items():
        mine = (info[:, 6] == first) & (info[:, 7] > 0)
        count, rows = sets.shape[:2]
        shifts[np.ix_(mine, range(1, count + 1))] = end - first + rows * np.arange(count)
        end += count * rows
    return shifts
