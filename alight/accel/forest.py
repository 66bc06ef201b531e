"""The tree of a scene, and the trees of its instanced geometries in the same arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from alight.accel.build import build_bvh
from alight.accel.kept import own_box, tree_of
from alight.accel.layout import (
    BLOCK,
    CHILD,
    CHILDREN,
    CORNERS,
    IDS,
    INSTANCE,
    LEAF,
    MOVING,
    MOVING_TREE,
    NODE,
    OTHER,
    TREE,
    TRIANGLES,
    Bvh,
    aligned_zeros,
    check_blocks,
    kinds_in_order,
    number_of,
)
from alight.accel.primitives import Analytic, Instance, Many, Moving, TriangleSet
from lanewise.view import View

#: An instance's box is enlarged by this part of the coordinates: rays are rounded on their way to
#: object space.
INSTANCE_MARGIN = 2.0**-19


class Forest:
    """Everything that goes into trees.

    Parameters
    ----------
    triangles : TriangleSet
        Sorted by (shape, prim).
    analytic : list of Analytic
    instances : list of Instance
    geometries : list of (vertices, faces)
    moving : list of Moving
    many : list of Many
    """

    def __init__(self, triangles, analytic, instances, geometries, moving=(), many=()):
        self.triangles: TriangleSet = triangles
        self.analytic: list[Analytic] = analytic
        self.instances: list[Instance] = [i for i in instances if len(geometries[i.geometry][1])]
        self.geometries: list[tuple[np.ndarray, np.ndarray]] = geometries
        self.moving: list[Moving] = [
            m for m in moving if m.kind != TRIANGLES or len(geometries[m.row][1])
        ]
        self.many: list[Many] = list(many)

    def build(self, method: str, threads: int) -> tuple[Bvh, View, tuple[str, ...], dict[str, Any]]:
        """Build all trees.

        Returns
        -------
        tree : Bvh
            The scene's tree starts at node 0.
        box : View
            Lower and upper bounds, (6,) float32.
        plan : tuple of str
            () if there is nothing in the tree.
        stats : dict
        """
        others = len(self.analytic) + len(self.instances) + len(self.moving)
        others += sum(len(one.low) for one in self.many)
        if len(self.triangles.faces) + others == 0:
            empty = View(np.zeros(0, np.float32))
            tree = Bvh(empty, empty, View(np.zeros(0, np.uint32)), 0)
            return tree, View(np.zeros(6, np.float32)), (), {}
        used = {i.geometry for i in self.instances}
        used = sorted(used | {m.row for m in self.moving if m.kind == TRIANGLES})
        trees = [tree_of(*self.geometries[g], method=method, threads=threads) for g in used]
        blocks, boxes = np.zeros((others, BLOCK), np.float32), np.zeros((others, 2, 3), np.float32)
        self._describe_analytic(blocks, boxes)
        self._describe_instances(blocks, boxes)
        self._describe_moving(blocks, boxes)
        self._describe_many(blocks, boxes)
        vertices = np.ascontiguousarray(self.triangles.vertices, np.float32)
        faces = np.ascontiguousarray(self.triangles.faces, np.int32)
        many = sum(len(one.low) for one in self.many)
        main, stats = build_bvh(
            vertices, faces, blocks, boxes, method=method, threads=threads, many=many
        )
        tree, roots = _joined([main, *(t for t, _ in trees)])
        if trees:
            self._point_to_roots(tree, dict(zip(used, roots[1:], strict=True)))
        for _, more in trees:
            for key in ("nodes", "blocks", "leaves", "bytes"):
                stats[key] += more[key]
            stats["depth"] = max(stats["depth"], more["depth"])
        ids = np.zeros((len(faces) + others, 2), np.uint32)
        ids[: len(faces), 0], ids[: len(faces), 1] = self.triangles.shape, self.triangles.prim
        alone = (*self.analytic, *self.instances, *self.moving)
        at = len(faces) + len(alone)
        ids[len(faces) : at, 0] = [p.shape for p in alone]
        for one in self.many:
            rows = ids[at : at + len(one.low)]
            rows[:, 0], rows[:, 1] = one.shape, np.arange(len(rows))
            at += len(rows)
        stats["bytes"] += ids.nbytes
        kinds = {a.kind for a in self.analytic} | ({INSTANCE} if self.instances else set())
        kinds |= {one.kind for one in self.many}
        plan = (TREE, *(f"{TREE} {kind}" for kind in kinds_in_order(kinds)))
        kinds = {m.kind for m in self.moving}
        plan += tuple(f"{MOVING_TREE} {kind}" for kind in kinds_in_order(kinds))
        return tree._replace(ids=View(ids)), View(box_of(main)), plan, stats

    def _describe_analytic(self, blocks: np.ndarray, boxes: np.ndarray) -> None:
        """Fill the first rows of the blocks (`layout`) and boxes of primitives but triangles."""
        words = blocks.view(np.uint32)
        words[:, CORNERS:IDS] = OTHER
        words[:, IDS] = len(self.triangles.faces) + np.arange(len(blocks))
        for row, a in enumerate(self.analytic):
            words[row, 0], words[row, 1] = number_of(a.kind), a.row
            boxes[row] = np.asarray([a.low, a.high])

    def _describe_instances(self, blocks: np.ndarray, boxes: np.ndarray) -> None:
        """Fill the further rows; the root is filled in once the trees are joined."""
        boxes_of = {g: own_box(*self.geometries[g]) for g in {i.geometry for i in self.instances}}
        if not self.instances:
            return
        place = slice(len(self.analytic), len(self.analytic) + len(self.instances))
        blocks.view(np.uint32)[place, 0] = number_of(INSTANCE)
        maps = np.array([one.to_object for one in self.instances], np.float32)
        blocks[place, 2:14] = maps.reshape(len(maps), -1)
        boxes[place] = placed_boxes(self.instances, boxes_of)

    def _describe_moving(self, blocks: np.ndarray, boxes: np.ndarray) -> None:
        """The same for what moves; of meshes the root is filled in once the trees are joined."""
        for row, one in enumerate(self.moving, len(self.analytic) + len(self.instances)):
            words = blocks.view(np.uint32)[row]
            words[:3] = MOVING + number_of(one.kind), one.row, one.motion
            boxes[row] = np.asarray([one.low, one.high])

    def _describe_many(self, blocks: np.ndarray, boxes: np.ndarray) -> None:
        """The same for the shapes of many primitives."""
        at = len(self.analytic) + len(self.instances) + len(self.moving)
        for one in self.many:
            place = slice(at, at + len(one.low))
            words = blocks.view(np.uint32)[place]
            words[:, 0], words[:, 1] = number_of(one.kind), one.rows
            boxes[place, 0], boxes[place, 1] = one.low, one.high
            at += len(one.low)

    def _point_to_roots(self, tree: Bvh, roots: dict[int, int]) -> None:
        """Write the root node of each instance's and moving mesh's geometry into its block."""
        words = tree.blocks.array.view(np.uint32).reshape(-1, BLOCK)
        first = len(self.triangles.faces) + len(self.analytic)
        geometries = [i.geometry for i in self.instances]
        geometries += [m.row if m.kind == TRIANGLES else -1 for m in self.moving]
        root_of = np.array([roots.get(number, 0) for number in geometries], np.uint32)
        numbers = number_of(INSTANCE), MOVING + number_of(TRIANGLES)
        leads_on = (words[:, IDS - 1] == OTHER) & np.isin(words[:, 0], numbers)
        words[leads_on, 1] = root_of[words[leads_on, IDS].astype(np.int64) - first]


def box_of(tree: Bvh) -> np.ndarray:
    """Lower and upper bounds of a tree, (6,) float32, metres."""
    root = tree.nodes.array[:NODE].reshape(-1, CHILDREN)
    return np.concatenate([root[:3].min(axis=1), root[3:6].max(axis=1)])


def _joined(trees: list[Bvh]) -> tuple[Bvh, list[int]]:
    """One pair of arrays for several trees, and the number of each root."""
    if len(trees) == 1:
        return trees[0], [0]
    first_node = np.cumsum([0, *(tree.nodes.size // NODE for tree in trees)])
    first_block = np.cumsum([0, *(tree.blocks.size // BLOCK for tree in trees)])
    check_blocks(int(first_block[-1]))
    nodes = aligned_zeros(int(first_node[-1]), NODE)
    blocks = aligned_zeros(int(first_block[-1]), BLOCK)
    for i, tree in enumerate(trees):
        rows = nodes[first_node[i] : first_node[i + 1]]
        rows[:] = tree.nodes.array.reshape(-1, NODE)
        blocks[first_block[i] : first_block[i + 1]] = tree.blocks.array.reshape(-1, BLOCK)
        child = rows[:, CHILD : CHILD + CHILDREN].view(np.uint32)
        is_leaf = child >= LEAF
        child[is_leaf] += np.uint32(first_block[i] << 4)
        # A missing child stays 0.
        child[~is_leaf & (child > 0)] += np.uint32(first_node[i])
    joined = Bvh(View(nodes), View(blocks), trees[0].ids, trees[0].waits)
    return joined, [int(node) for node in first_node[:-1]]


def placed(one: Instance, vertices: np.ndarray, faces: np.ndarray) -> TriangleSet:
    """The triangles of an instance in world space."""
    matrix = np.asarray(one.to_world, np.float64)
    world = vertices.astype(np.float64) @ matrix[:, :3].T + matrix[:, 3]
    return TriangleSet(
        world.astype(np.float32),
        faces,
        np.full(len(faces), one.shape, np.uint32),
        np.arange(len(faces), dtype=np.uint32),
    )


def placed_boxes(instances: list[Instance], boxes: Mapping[int, np.ndarray]) -> np.ndarray:
    """Bounds of instances in the world, (n, 2, 3) float32, metres.

    Parameters
    ----------
    instances : list of Instance
    boxes : mapping of int to ndarray
        `own_box` of each geometry.
    """
    if not instances:
        return np.zeros((0, 2, 3), np.float32)
    own = np.array([boxes[one.geometry] for one in instances], np.float64)
    matrices = np.array([one.to_world for one in instances], np.float64)
    # Corner k takes the upper bound of the axes whose bits are set in k.
    upper = (np.arange(8)[:, None] >> np.arange(3)) & 1
    corners = np.where(upper, own[:, None, 1], own[:, None, 0])
    world = corners @ matrices[:, :, :3].transpose(0, 2, 1) + matrices[:, None, :, 3]
    margin = INSTANCE_MARGIN * np.abs(world).max(axis=(1, 2))[:, None]
    return np.stack([world.min(axis=1) - margin, world.max(axis=1) + margin], axis=1).astype(
        np.float32
    )
