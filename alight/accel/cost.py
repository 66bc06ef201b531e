"""The expected cost of a finished tree for its rays."""

from __future__ import annotations

import numpy as np

from alight.accel.layout import CHILD, CHILDREN, LEAF, NODE, UPPER, Bvh

#: Rays wait for memory where a tree has more bytes than this (about a core's own cache).
BIG = 4 << 20

#: Nodes looked at together.
CHUNK = 1024


def sah_cost(tree: Bvh) -> float:
    """Expected work of a ray that meets the root box, in tests of a block (Wald 2007).

    Every child costs its surface area relative to the root's: one step if it is a node, its blocks
    if it is a leaf.
    """
    rows = tree.nodes.array.reshape(-1, NODE)
    root = rows[0, :CHILD].reshape(6, CHILDREN)
    whole = float(_half_area((root[3:].max(axis=1) - root[:3].min(axis=1)).astype(np.float64)))
    if whole == 0.0:
        return 1.0
    # A chunk's intermediate results stay in the processor's cache.
    total = sum(_work_of(rows[first : first + CHUNK]) for first in range(0, len(rows), CHUNK))
    return 1.0 + total / whole


def _work_of(rows: np.ndarray) -> float:
    """Surface areas of the children of some nodes times what each costs, square metres."""
    low, high = (rows[:, k : k + UPPER].reshape(-1, 3, CHILDREN) for k in (0, UPPER))
    there = low[:, 0] <= high[:, 0]
    edges = np.where(there[:, None], high - low, 0.0).astype(np.float64)
    child = rows[:, CHILD : CHILD + CHILDREN].view(np.uint32)
    cost = np.where(child >= LEAF, child & 15, 1)
    return float((_half_area(np.moveaxis(edges, 1, 0)) * cost).sum())


def _half_area(edges: np.ndarray) -> np.ndarray:
    x, y, z = edges
    return x * y + y * z + z * x


def waits_for_memory(tree: Bvh) -> int:
    """1 where rays wait for memory, so that nodes are asked for before they are needed, else 0."""
    return int(tree.nodes.array.nbytes + tree.blocks.array.nbytes > BIG)
