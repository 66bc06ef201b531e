"""What a finished tree costs its rays, and how they share the time."""

from __future__ import annotations

import numpy as np

from alight.accel.layout import CHILD, LEAF, NODE, Bvh

#: Rays wait for memory where a tree has more bytes than this (about a core's own cache) ...
BIG = 4 << 20

#: ... and where they visit so little of it that the next node is seldom one of the last.
COSTLY = 100.0

#: More steps than any ray takes.
ENDLESS = 1 << 40


def sah_cost(tree: Bvh) -> float:
    """Expected work of a ray that meets the root box, in tests of a block (Wald 2007).

    Every child costs its surface area relative to the root's: one step if it is a node, its blocks
    if it is a leaf.
    """
    rows = tree.nodes.array.reshape(-1, NODE)
    low, high = rows[:, :24].reshape(-1, 3, 8), rows[:, 24:48].reshape(-1, 3, 8)
    there = low[:, 0] <= high[:, 0]
    x, y, z = np.moveaxis(np.where(there[:, None], high - low, 0.0).astype(np.float64), 1, 0)
    area = x * y + y * z + z * x
    child = rows[:, CHILD : CHILD + 8].view(np.uint32)
    cost = np.where(child >= LEAF, child & 15, 1)
    root = rows[0, :48].reshape(6, 8)
    x, y, z = (root[3:].max(axis=1) - root[:3].min(axis=1)).astype(np.float64)
    whole = x * y + y * z + z * x
    return float(1.0 + (area * cost).sum() / whole) if whole > 0.0 else 1.0


def patience(tree: Bvh, cost: float) -> int:
    """Steps that a ray takes before the others of its packet go on.

    One in a tree whose rays wait for memory, as their waits overlap so; elsewhere all, as a change
    of rays costs more than it gains. Both limits were measured (decision 11).
    """
    waits = tree.nodes.array.nbytes + tree.blocks.array.nbytes > BIG and cost < COSTLY
    return 1 if waits else ENDLESS
