"""Strips of triangles: each vertex makes one with the two before it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def triangles_of(values: NDArray[Any], sizes: NDArray[np.int64]) -> NDArray[Any]:
    """Cut strips into triangles, all the same way round.

    Parameters
    ----------
    values : (n,) int or float
        Vertices of all strips, one after the other. A strip also ends where one is -1.
    sizes : (s,) int64
        Length of each strip.

    Returns
    -------
    (m, 3) int64 or float
        Without those whose corners are not three vertices.
    """
    whole = values if values.dtype.kind == "f" else values.astype(np.int64)
    row = np.insert(whole, np.cumsum(sizes), -1)
    places = np.arange(len(row))
    begun = np.maximum.accumulate(np.where(row == -1, places, -1))
    corners = np.stack([row[:-2], row[1:-1], row[2:]], axis=1)
    # Every other one is turned around.
    turned = (places[:-2] - begun[:-2]) % 2 == 0
    corners[turned, :2] = corners[turned, 1::-1]
    a, b, c = corners.T
    return corners[(corners != -1).all(axis=1) & (a != b) & (b != c) & (c != a)]
