"""Building the light tree: from lights with bounds to the table that kernels traverse.

Level by level from the root, all nodes of a level at once (`split`); the cones that are stored
in the end bound all of their lights.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.lights.tree.bounds import (
    CONE,
    EVEN,
    FAR,
    FAR_AWAY,
    INTENSITY,
    NEVER,
    RADIUS,
    ROW,
    WORDS,
    Groups,
    pack,
    unpack,
)
from alight.lights.tree.split import Leaves, split
from alight.lights.tree.traversal import (
    CHILD,
    FIRST_LEAF,
    LEAF,
    MOST_LEVELS,
    NEXT,
    NODE,
    PRIM,
    TOP,
    TOP_BITS,
    TOP_ROW,
    WHOLE,
)

#: Radians: lights whose directions differ by less face much the same way.
SAME_WAY = 0.5


class LightTree(NamedTuple):
    """What kernels walk.

    Attributes
    ----------
    top : (TOP, TOP_ROW) float32
        Children of the root; those that it lacks send nothing.
    nodes : (m, NODE) uint32
        Two children a node, see `alight.lights.tree.traversal`; that of all leaves comes first.
    ways : (n,) uint32
        To each leaf: the root's child, then a bit a node.
    numbers : (n,) uint32
        Of each leaf, so that those of a group follow each other.
    middle, far : (3,) float32, metres, and float, m^2
        Of all lights, and the squared distance from it from which only intensity counts.
    table : (3 n + 1,) uint32
        Sums of intensity, rows and triangles of the leaves.
    """

    top: NDArray[np.float32]
    nodes: NDArray[np.uint32]
    ways: NDArray[np.uint32]
    numbers: NDArray[np.uint32]
    middle: NDArray[np.float32]
    far: float
    table: NDArray[np.uint32]


class BinaryTree(NamedTuple):
    """A `LightTree` before its root is widened; `ways` have a bit a node."""

    nodes: NDArray[np.uint32]
    ways: NDArray[np.uint32]
    numbers: NDArray[np.uint32]
    middle: NDArray[np.float32]
    far: float


def build_tree(
    leaves: Leaves, start: int, find_even: Callable[[Leaves, Any, Any], Any] | None = None
) -> LightTree:
    """Make the tree.

    Parameters
    ----------
    leaves : Leaves
    start : int
        Where the table will begin; the offsets in it count from 0 of the array it is put in.
    find_even : callable, optional
        ``find_even(leaves, begin, end) -> (m,) bool``: of groups of leaves, in the order of their
        numbers, from which of them intensity alone may choose.
    """
    total = max(float(leaves.intensity.sum()), 1e-300)
    leaves = leaves._replace(intensity=leaves.intensity / total)
    start += TOP * TOP_ROW
    tree = binary_tree(leaves, start)
    order = np.argsort(tree.numbers)
    leaves = Leaves(*(column[order] for column in leaves))
    if find_even is not None:
        begin, end = tree.nodes[:, FIRST_LEAF], tree.nodes[:, FIRST_LEAF + 1]
        tree = _with_even_groups(tree, start, find_even(leaves, begin, end))
    top, ways = _widened(tree, start)
    return LightTree(
        top=top, nodes=tree.nodes, ways=ways, numbers=tree.numbers, middle=tree.middle,
        far=tree.far, table=_table(leaves),
    )  # fmt: skip


def binary_tree(leaves: Leaves, start: int) -> BinaryTree:
    """Make the nodes, level by level.

    Parameters
    ----------
    leaves : Leaves
        Of intensities that add up to 1.
    start : int
        Where the nodes will begin.
    """
    count = len(leaves.row)
    ways, numbers = np.zeros(count, np.uint32), np.zeros(count, np.uint32)
    if count < 2:
        nodes = np.zeros((1, NODE), np.uint32)
        nodes[:, [NEXT, CHILD + NEXT]] = LEAF
        if count:
            nodes[:, :CHILD] = _children(leaves, _groups(leaves, numbers, numbers), numbers)
        nodes[0, FIRST_LEAF + 1] = count
        return BinaryTree(nodes, ways, numbers, np.zeros(3, np.float32), NEVER)
    levels: list[np.ndarray] = []
    items, sizes, made, begin = np.arange(count), np.array([count]), 1, np.zeros(1, int)
    whole = _groups(leaves, items, begin)
    for level in range(MOST_LEVELS):
        nodes = np.zeros((len(sizes), NODE), np.uint32)
        nodes[:, FIRST_LEAF], nodes[:, FIRST_LEAF + 1] = begin, begin + sizes
        items, halves = split(leaves, items, sizes, MOST_LEVELS - level)
        begin = np.stack([begin, begin + halves[::2]], axis=1).ravel()
        sizes, starts = halves, np.cumsum(halves) - halves
        second = np.repeat(np.arange(len(sizes)) & 1, sizes).astype(np.uint32)
        ways[items] |= second << np.uint32(level)
        rows = _children(leaves, _groups(leaves, items, starts), items[starts])
        inner = sizes > 1
        number = made + np.cumsum(inner) - 1
        rows[inner, NEXT], rows[inner, PRIM] = start + NODE * number[inner], 0
        nodes[:, : 2 * CHILD] = rows.reshape(-1, 2 * CHILD)
        levels.append(nodes)
        made += int(inner.sum())
        numbers[items[starts[~inner]]] = begin[~inner]
        items, sizes, begin = items[np.repeat(inner, sizes)], sizes[inner], begin[inner]
        if not len(sizes):
            break
    far = FAR_AWAY * float(whole.radius[0]) ** 2 if whole.alike[0] else NEVER
    return BinaryTree(np.concatenate(levels), ways, numbers, whole.center[0], far)


def _with_even_groups(tree: BinaryTree, start: int, even: NDArray[np.bool_]) -> BinaryTree:
    """The same, in which intensity alone chooses below some nodes."""
    nodes = tree.nodes.copy()
    for child in (0, CHILD):
        onward = nodes[:, child + NEXT]
        inner = onward < LEAF
        there = np.where(inner, (onward.astype(np.int64) - start) // NODE, 0)
        nodes[inner & even[there], child + CONE] |= np.uint32(EVEN)
    return tree._replace(nodes=nodes, far=-1.0 if even[0] else tree.far)


def _widened(tree: BinaryTree, start: int) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """The root's children, and the ways that begin with them.

    What is bright and large is opened first: there is most to tell apart.
    """
    top, ways = np.zeros((TOP, TOP_ROW), np.float32), np.zeros_like(tree.ways)
    count = len(ways)
    if not count:
        return top, ways
    found = [_Child(tree.nodes[0, :CHILD], 0, 1, 1)]
    if count > 1:
        found = _pair(tree.nodes, 0, start, 1)
    while len(found) < TOP:
        largest = max(range(len(found)), key=lambda i: found[i].extent)
        if found[largest].extent < 0.0:
            break
        child = found[largest]
        number = (int(child.words[NEXT]) - start) // NODE
        found[largest : largest + 1] = _pair(tree.nodes, number, start, child.depth + 1)
    words = np.array([child.words for child in found])
    top[: len(found), :ROW] = unpack(words[:, :WORDS])
    top[: len(found), ROW:] = np.ascontiguousarray(words[:, NEXT:]).view(np.float32)
    for i, (_, first, end, depth) in enumerate(found):
        mine = (tree.numbers >= first) & (tree.numbers < end)
        ways[mine] = np.uint32(i) | tree.ways[mine] >> np.uint32(depth) << np.uint32(TOP_BITS)
    return top, ways


class _Child(NamedTuple):
    """A child of the root: its words, first leaf, the one behind its last, and how deep it was."""

    words: NDArray[np.uint32]
    first: int
    end: int
    depth: int

    @property
    def extent(self) -> float:
        """Intensity times squared radius; less than 0 for what is not looked into."""
        bounds = unpack(self.words[None, :WORDS])[0]
        is_open = self.words[NEXT] < LEAF and bounds[FAR] >= 0.0
        return float(bounds[INTENSITY] * bounds[RADIUS] ** 2) if is_open else -1.0


def _pair(nodes: NDArray[np.uint32], number: int, start: int, depth: int) -> list[_Child]:
    """Both children of a node."""
    node = nodes[number]
    first, end = int(node[FIRST_LEAF]), int(node[FIRST_LEAF + 1])
    a, b = node[:CHILD], node[CHILD : 2 * CHILD]
    middle = first + 1
    if a[NEXT] < LEAF:
        middle = int(nodes[(int(a[NEXT]) - start) // NODE, FIRST_LEAF + 1])
    return [_Child(a, first, middle, depth), _Child(b, middle, end, depth)]


def _table(leaves: Leaves) -> NDArray[np.uint32]:
    """Sums of intensity, rows and triangles of the leaves, which come in their order."""
    count, share = len(leaves.row), np.cumsum(leaves.intensity)
    # Each has one unit at least, however bright the others are.
    sums = np.arange(1, count + 1) + np.rint(np.minimum(share, 1.0) * (WHOLE - count))
    words = np.concatenate([[0], sums, leaves.row, leaves.prim])
    return words.astype(np.uint32)


def _groups(leaves: Leaves, items: np.ndarray, starts: np.ndarray) -> Groups:
    """Groups of lights that begin at `starts`."""
    sizes = np.diff(np.append(starts, len(items)))
    low = np.minimum.reduceat(leaves.low[items], starts)
    high = np.maximum.reduceat(leaves.high[items], starts)
    center = (0.5 * (low + high)).astype(np.float32)
    # From the rounded centre, and a little more for the rounding of kernels.
    reach = np.maximum(np.abs(high - center), np.abs(low - center))
    radius = np.linalg.norm(reach, axis=1) * (1.0 + 1e-5)
    mean = np.add.reduceat(leaves.axis[items], starts)
    length = np.linalg.norm(mean, axis=1)
    axis = mean / np.where(length > 1e-9, length, 1.0)[:, None]
    cosine = np.sum(np.repeat(axis, sizes, axis=0) * leaves.axis[items], axis=1)
    turn, own = np.arccos(np.clip(cosine, -1.0, 1.0)), leaves.spread[items]
    spread = np.maximum.reduceat(turn + own, starts)
    # What shines everywhere may be turned as it likes.
    differ = np.maximum.reduceat(np.where(own < np.pi, turn, 0.0), starts)
    differ += np.maximum.reduceat(own, starts) - np.minimum.reduceat(own, starts)
    differ = np.where((length > 1e-9) | (np.minimum.reduceat(own, starts) >= np.pi), differ, np.pi)
    spread = np.where(length > 1e-9, np.minimum(spread + 1e-3, np.pi), np.pi)
    # A lone light's cone is not widened: that it faces one way is known.
    spread = np.where(sizes == 1, leaves.spread[items[starts]], spread)
    dark = np.minimum(np.maximum.reduceat(leaves.dark[items], starts), np.pi)
    behind = np.maximum.reduceat(_behind(leaves, items, np.repeat(center, sizes, axis=0)), starts)
    intensity = np.add.reduceat(leaves.intensity[items], starts)
    return Groups(
        center=center, radius=radius, behind=np.minimum(behind, radius),
        axis=axis, cosine=np.cos(spread), dark=np.cos(dark), intensity=intensity,
        flat=np.maximum.reduceat(own, starts) <= 0.0, alike=differ < SAME_WAY,
    )  # fmt: skip


def _behind(leaves: Leaves, items: np.ndarray, center: np.ndarray) -> NDArray[np.float64]:
    """How far each light lies behind a place, against the directions that it faces; (n,) metres."""
    away = center - 0.5 * (leaves.low + leaves.high)[items]
    distance = np.linalg.norm(away, axis=1)
    cosine = np.sum(away * leaves.axis[items], axis=1) / np.where(distance > 0.0, distance, 1.0)
    angle = np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)) - leaves.spread[items], 0.0)
    return distance * np.cos(angle) + leaves.behind[items]


def _children(leaves: Leaves, groups: Groups, first: np.ndarray) -> NDArray[np.uint32]:
    """Rows of groups, as if each were its first light; (n, CHILD)."""
    rows = np.zeros((len(first), CHILD), np.uint32)
    rows[:, :WORDS] = pack(groups)
    rows[:, NEXT], rows[:, PRIM] = leaves.row[first] | np.uint32(LEAF), leaves.prim[first]
    return rows
