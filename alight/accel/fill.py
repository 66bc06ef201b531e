"""How many triangles a block is expected to take, which depends on how many vertices they share."""

from __future__ import annotations

import numpy as np

from alight.accel.layout import MAX_LEAF, OTHERS_IN_LEAF, WIDTH

#: How shared vertices are estimated: RUNS runs of RUN triangles.
RUNS, RUN = 4, 2048

#: Any big odd numbers: what the bits of coordinates are multiplied by.
PLACE = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)


def expected_fill(vertices: np.ndarray, faces: np.ndarray, others: int, many: int = 0) -> int:
    """How many primitives a block is expected to take.

    Parameters
    ----------
    vertices, faces
        As of `build.build_bvh`.
    others : int
        Primitives that are not triangles.
    many : int
        How many of these are one of many: better alone in a box, as their tests take longer than
        that of a node.

    Returns
    -------
    int
        As many triangles as there is room for if neighbours share their vertices, fewer if each
        has its own.
    """
    n = len(faces)
    in_leaves = (others - many) * OTHERS_IN_LEAF + many
    if n == 0:
        return max(round(in_leaves / max(others, 1)), 1)
    fill = min(max(round(WIDTH * n / _count_vertices(vertices, faces)), WIDTH // 3), WIDTH)
    if others == 0:
        return fill
    return min(round((n * fill + in_leaves) / (n + others)), MAX_LEAF)


def _count_vertices(vertices: np.ndarray, faces: np.ndarray) -> float:
    """About how many different vertices there are, wherever files repeat them."""
    n = len(faces)
    if len(vertices) <= n:
        return len(vertices)
    starts = np.unique(np.linspace(0, max(n - RUN, 0), RUNS).astype(np.int64))
    runs = [faces[start : start + RUN].ravel() for start in starts]
    # One number a vertex: two vertices that share it are too few to matter.
    seen = sum(
        len(np.unique(vertices[run].view(np.uint32).astype(np.uint64) @ PLACE)) for run in runs
    )
    return min(seen * n / sum(len(run) // 3 for run in runs), len(vertices))
