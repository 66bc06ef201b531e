"""alight's acceleration structure for the benchmarks that look at it alone."""

from typing import Any

import numpy as np
from rays import Intersect


def build(vertices: np.ndarray, faces: np.ndarray, threads: int) -> Any:
    """Build the tree over one mesh."""
    from alight.accel.batch import build

    return build(vertices, faces, threads=threads)[0]


def intersector(tree: Any) -> Intersect:
    """Wrap the closest-hit query, one ray after another on the calling thread."""
    from alight.accel.batch import intersect_batch

    def intersect(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return intersect_batch(tree, origins, directions)[:2]

    return intersect
