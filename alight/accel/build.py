"""Build of the bounding volume hierarchy on several threads.

First all threads together divide the whole set into 8, each pass over chunks of references (`top`).
Then each thread takes one of the sets and divides it into 8, until there are enough for all; the
subtrees over those are tasks, largest first. Chunks and tasks depend on the number of primitives
only, so the tree is the same for any number of threads.
"""

from __future__ import annotations

import threading
import time
from collections import namedtuple
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np

from alight.accel import top
from alight.accel.cost import sah_cost, waits_for_memory
from alight.accel.layout import BLOCK, CHILD, COUNT, MAX_LEAF, NODE, WIDTH, Bvh
from alight.accel.references import MARGIN, ROUNDING, refer_to_triangles
from alight.accel.splitting import MEDIAN, SAH, Rules, Workspace, halve
from alight.accel.subtree import Source, build_subtree, expand, pack
from alight.core.jit import instantiate
from alight.core.view import View

#: Primitives that one thread takes at a time while all work on the same set.
CHUNK = 65536

#: Sets below this size, or this part of all primitives, become tasks.
SMALLEST_TASK, TASKS = 4096, 32

#: Levels of nodes above the tasks, at most.
TOP_LEVELS = 3

METHODS = {"sah": SAH, "median": MEDIAN}

#: Primitives that are not triangles, at least, before a set of them is divided.
OTHERS_IN_LEAF = 8

#: What tells how many vertices triangles share: so many runs of so many triangles.
RUNS, RUN = 4, 2048

#: Any big odd numbers: what the bits of coordinates are multiplied by.
PLACE = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)


def build_bvh(
    vertices: np.ndarray,
    faces: np.ndarray,
    others: np.ndarray | None = None,
    boxes: np.ndarray | None = None,
    *,
    method: str = "sah",
    threads: int = 1,
) -> tuple[Bvh, dict]:
    """Build a hierarchy over triangles, and over other primitives given by their boxes.

    Parameters
    ----------
    vertices : (V, 3) float32, metres
        Finite.
    faces : (F, 3) int32
        A triangle's index is its row.
    others : (m, BLOCK) float32, optional
        The blocks of other primitives (`layout`); their indices are F and on.
    boxes : (m, 2, 3) float32, optional
        Lower and upper bounds of the others, metres.
    method : {"sah", "median"}
        How sets are divided.
    threads : int

    Returns
    -------
    bvh : Bvh
        Its ids are empty.
    stats : dict
        ``nodes``, ``blocks``, ``leaves``, ``depth``, ``bytes``, ``sah_cost``, ``seconds`` (build
        without compilation).
    """
    if others is None or boxes is None:
        others, boxes = np.zeros((0, BLOCK), np.float32), np.zeros((0, 2, 3), np.float32)
    compile_kernels(len(faces) + len(others) > SMALLEST_TASK)
    begin = time.perf_counter()
    with _Pool(threads) as pool:
        builder = _Builder(kernels(), pool, METHODS[method], vertices, faces, others, boxes)
        bvh, stats = builder.run()
    stats["sah_cost"] = sah_cost(bvh)
    bvh = bvh._replace(waits=waits_for_memory(bvh))
    stats["seconds"] = time.perf_counter() - begin
    return bvh, stats


@lru_cache(maxsize=2)
def compile_kernels(big: bool) -> None:
    """Compile what a small or a big set needs, by building a set of that size."""
    n = 16 * SMALLEST_TASK if big else 16
    place = np.arange(3 * n, dtype=np.float32)
    vertices = np.stack([place, place % 3, place % 128], axis=1)
    faces = np.arange(3 * n, dtype=np.int32).reshape(n, 3)
    nothing = np.zeros((0, BLOCK), np.float32), np.zeros((0, 2, 3), np.float32)
    _Builder(kernels(), _Pool(1), SAH, vertices, faces, *nothing).run()


def aligned_zeros(rows: int, columns: int) -> np.ndarray:
    """Zeros of shape (rows, columns), float32, that start at a cache line."""
    n = rows * columns
    memory = np.zeros(n + 16, np.float32)
    skip = (-memory.ctypes.data // 4) % 16
    return memory[skip : skip + n].reshape(rows, columns)


Kernels = namedtuple("Kernels", "refer bin choose partition conclude halve expand subtree pack")


@lru_cache(maxsize=1)
def kernels() -> Kernels:
    """The build kernels, compiled when they are first called."""
    texts = (
        refer_to_triangles,
        top.bin_chunk,
        top.choose,
        top.partition_chunk,
        top.conclude,
        halve,
        expand,
        build_subtree,
        pack,
    )
    return Kernels(*(instantiate(text) for text in texts))


class _Pool:
    """Threads, or none if one is enough."""

    def __init__(self, threads: int):
        self.executor = ThreadPoolExecutor(threads) if threads > 1 else None

    def __enter__(self) -> _Pool:
        return self

    def __exit__(self, *problem: object) -> None:
        if self.executor is not None:
            self.executor.shutdown()

    def run(self, function: Callable, items: Iterable) -> None:
        """Call the function with each item; return when all are done."""
        if self.executor is None:
            for item in items:
                function(item)
        else:
            list(self.executor.map(function, items))


class _Builder:
    """One build: the arrays that its passes share."""

    def __init__(self, compiled, pool, method, vertices, faces, others, boxes):
        self.compiled, self.pool = compiled, pool
        fill = expected_fill(vertices, faces, len(others))
        self.rules = Rules(method, fill)
        self.triangles = len(faces)
        self.n = n = len(faces) + len(others)
        self.source = Source(View(vertices), View(faces), len(faces), View(others))
        self.work = Workspace(
            View(aligned_zeros(n, 8)),
            View(aligned_zeros(n, 8)),
            View(np.zeros(n, np.uint32)),
        )
        # Room for every set at the top: nodes of TOP_LEVELS levels with 8 children each.
        room = sum(8**level for level in range(TOP_LEVELS + 1))
        self.records = View(aligned_zeros(room, 16))
        self.ranges = View(np.zeros(3 * room, np.int64))
        self.used = 1
        rows = -(-n // CHUNK) + 1
        self.tables = View(aligned_zeros(rows, top.ROW))
        self.counts = View(np.zeros(rows * top.COUNTS, np.int64))
        self.result = View(np.zeros(rows + 2, np.int64))
        self.boxes = boxes
        self.boxes_of_top: list[np.ndarray] = []

    def run(self) -> tuple[Bvh, dict]:
        """All steps: references, top, subtrees, packing."""
        self._refer()
        nodes, tasks = self._build_top()
        totals = self._build_subtrees(tasks)
        return self._pack(nodes, tasks, totals)

    def _refer(self) -> None:
        """References to all primitives; record 0 becomes the whole set."""
        starts = range(0, self.triangles, CHUNK)
        bounds = View(aligned_zeros(len(starts) + 1, 16))
        self.pool.run(
            lambda begin: self.compiled.refer(
                self.source.vertices,
                self.source.faces,
                self.work.a,
                bounds,
                begin // CHUNK,
                begin,
                min(begin + CHUNK, self.triangles),
            ),
            starts,
        )
        references = self.work.a.array.reshape(-1, 8)[self.triangles :]
        references[:] = references_of_boxes(self.boxes, self.triangles)
        centers = references[:, :4] - references[:, 4:]
        others = np.hstack([references, centers, -centers])
        rows = np.concatenate([bounds.array.reshape(-1, 16)[: len(starts)], others])
        self.records.array[:16] = rows.min(axis=0)
        self.ranges.array[:3] = 0, self.n, 0

    def _build_top(self) -> tuple[list[list[int]], list[tuple[int, int]]]:
        """Divide the big sets.

        Returns
        -------
        nodes : list of list of int
            The children of each top node: its number if >= 0, else -1 - (number of a task).
        tasks : list of (record, level)
        """
        limit = max(SMALLEST_TASK, self.n // TASKS)
        nodes: list[list[int]] = []
        tasks: list[tuple[int, int]] = []
        # (record, its parent node and place there)
        waiting = [(0, None)]
        for level in range(TOP_LEVELS + 1):
            big = [w for w in waiting if self._size(w[0]) > limit and level < TOP_LEVELS]
            for record, parent in waiting:
                if (record, parent) not in big:
                    if parent is not None:
                        nodes[parent[0]][parent[1]] = -1 - len(tasks)
                    tasks.append((record, level))
            waiting = []
            for (_, parent), children in zip(big, self._expand([w[0] for w in big]), strict=True):
                if parent is not None:
                    nodes[parent[0]][parent[1]] = len(nodes)
                waiting += [(child, (len(nodes), i)) for i, child in enumerate(children)]
                nodes.append([0] * len(children))
                self.boxes_of_top.append(self.records.array.reshape(-1, 16)[children, :8].copy())
        return nodes, tasks

    def _expand(self, sets: list[int]) -> list[list[int]]:
        """Divide each of the sets into 8; the records of their parts."""
        if len(sets) == 1:
            return [self._divide_into_children(sets[0])]
        sizes = View(np.zeros(self.records.size // 16, np.int64))
        first = {record: self.used + 8 * k for k, record in enumerate(sets)}
        self.used += 8 * len(sets)
        self.pool.run(
            lambda record: self.compiled.expand(
                self.work, self.records, self.ranges, record, first[record], self.rules, sizes
            ),
            sorted(sets, key=self._size, reverse=True),
        )
        return [[first[r] + k for k in range(int(sizes.array[r]))] for r in sets]

    def _size(self, record: int) -> int:
        begin, end = self.ranges.array[3 * record : 3 * record + 2]
        return int(end - begin)

    def _area(self, record: int) -> float:
        box = self.records.array[16 * record : 16 * record + 8].astype(np.float64)
        x, y, z = -(box[:3] + box[4:7])
        return x * y + y * z + z * x

    def _divide_into_children(self, record: int) -> list[int]:
        """Divide a set into 8; the records of the parts."""
        children = [record]
        while len(children) < 8:
            large = [c for c in children if self._size(c) > self.rules.fill]
            if not large:
                break
            self._divide(max(large, key=self._area), self.used)
            children.append(self.used)
            self.used += 1
        return children

    def _divide(self, i: int, j: int) -> None:
        """Divide record i into i and j, all threads together."""
        first, end = (int(k) for k in self.ranges.array[3 * i : 3 * i + 2])
        starts = range(first, end, CHUNK)
        rows = len(starts)

        def bin_one(begin: int) -> None:
            self.compiled.bin(
                self.work,
                self.records,
                self.ranges,
                i,
                begin,
                min(begin + CHUNK, end),
                (begin - first) // CHUNK + 1,
                self.tables,
                self.counts,
            )

        self.pool.run(bin_one, starts)
        self.compiled.choose(
            self.records, self.ranges, i, rows, self.tables, self.counts, self.rules, self.result
        )
        if self.result.array[0] < 0:
            self.compiled.halve(self.work, self.records, self.ranges, i, j)
            return
        lefts = np.concatenate([[0], np.cumsum(self.result.array[2 : 2 + rows])])
        middle = first + int(lefts[-1])

        def partition_one(begin: int) -> None:
            row = (begin - first) // CHUNK
            left = int(lefts[row])
            self.compiled.partition(
                self.work,
                self.records,
                self.ranges,
                i,
                begin,
                min(begin + CHUNK, end),
                first + left,
                middle + (begin - first - left),
                self.result,
                row + 1,
                self.tables,
            )

        self.pool.run(partition_one, starts)
        self.compiled.conclude(
            self.records, self.ranges, i, j, rows, self.tables, self.result, middle
        )

    def _build_subtrees(self, tasks: list[tuple[int, int]]) -> np.ndarray:
        """Build all tasks; (tasks, 4) int64: nodes, blocks, leaves and levels of each."""
        totals = View(np.zeros(4 * len(tasks), np.int64))
        records, ranges = (
            View(aligned_zeros(len(tasks), 16)),
            View(np.zeros(3 * len(tasks), np.int64)),
        )
        for k, (record, _) in enumerate(tasks):
            records.array[16 * k : 16 * k + 16] = self.records.array[16 * record : 16 * record + 16]
            ranges.array[3 * k : 3 * k + 3] = self.ranges.array[3 * record : 3 * record + 3]
        # A subtree over n primitives has at most n / 2 + 1 nodes: a node without 8 children has
        # leaves only, and holds more primitives than fill a block unless it is the root. Most
        # have far fewer, so each thread has room for the worst and what is used is kept.
        room = max(self._size(record) for record, _ in tasks) // 2 + 2
        local = threading.local()
        self.built = [View(np.zeros(0, np.float32))] * len(tasks)

        def build_one(k: int) -> None:
            if not hasattr(local, "nodes"):
                local.nodes = View(aligned_zeros(room, NODE))
            self.compiled.subtree(
                self.work,
                local.nodes,
                records,
                ranges,
                k,
                tasks[k][1],
                self.rules,
                self.source,
                totals,
            )
            count = int(totals.array[4 * k])
            kept = aligned_zeros(count, NODE)
            kept[:] = local.nodes.array.reshape(-1, NODE)[:count]
            self.built[k] = View(kept)

        self.pool.run(build_one, sorted(range(len(tasks)), key=lambda k: -self._size(tasks[k][0])))
        return totals.array.reshape(-1, 4)

    def _pack(self, top_nodes, tasks, totals) -> tuple[Bvh, dict]:
        """The final arrays: top nodes, then the subtrees one after another."""
        # The references have done their work; their memory is as much as the final arrays'.
        order = self.work.order
        del self.work
        node_at = len(top_nodes) + np.concatenate([[0], np.cumsum(totals[:, 0])])
        block_at = np.concatenate([[0], np.cumsum(totals[:, 1])])
        bvh = Bvh(
            View(aligned_zeros(int(node_at[-1]), NODE)),
            View(aligned_zeros(int(block_at[-1]), BLOCK)),
            View(np.zeros(0, np.uint32)),
            0,
        )
        for node, children in enumerate(top_nodes):
            row = bvh.nodes.array.reshape(-1, NODE)[node]
            row[:24], row[24:48] = np.inf, -np.inf
            for i, child in enumerate(children):
                box = self.boxes_of_top[node][i]
                row[i:24:8], row[24 + i : 48 : 8] = box[:3], -box[4:7]
                row[CHILD:].view(np.uint32)[i] = child if child >= 0 else node_at[-1 - child]
            row[COUNT:].view(np.uint32)[0] = len(children)

        def pack_one(k: int) -> None:
            self.compiled.pack(
                order,
                self.built[k],
                int(totals[k, 0]),
                bvh.nodes,
                int(node_at[k]),
                bvh.blocks,
                int(block_at[k]),
                self.source,
            )

        self.pool.run(pack_one, range(len(tasks)))
        depth = max(int(t) + level for t, (_, level) in zip(totals[:, 3], tasks, strict=True))
        return bvh, {
            "nodes": int(node_at[-1]),
            "blocks": int(block_at[-1]),
            "leaves": int(totals[:, 2].sum()),
            "depth": depth,
            "bytes": bvh.nodes.array.nbytes + bvh.blocks.array.nbytes,
        }


def expected_fill(vertices: np.ndarray, faces: np.ndarray, others: int) -> int:
    """How many primitives a block is expected to take.

    Parameters
    ----------
    vertices, faces
        As of `build_bvh`.
    others : int
        Primitives that are not triangles.

    Returns
    -------
    int
        As many triangles as there is room for if neighbours share their vertices, fewer if each
        has its own.
    """
    n = len(faces)
    if n == 0:
        return OTHERS_IN_LEAF
    fill = min(max(round(WIDTH * n / _count_vertices(vertices, faces)), WIDTH // 3), WIDTH)
    if others == 0:
        return fill
    return min(round((n * fill + others * OTHERS_IN_LEAF) / (n + others)), MAX_LEAF)


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


def references_of_boxes(boxes: np.ndarray, first: int) -> np.ndarray:
    """References to primitives given by their boxes (m, 2, 3); their indices are `first` and on."""
    references = np.zeros((len(boxes), 8), np.float32)
    references[:, :3], references[:, 4:7] = boxes[:, 0], -boxes[:, 1]
    size = (boxes[:, 1] - boxes[:, 0]).max(axis=1, initial=0.0)
    references -= size[:, None] * MARGIN + np.abs(references) * ROUNDING
    references[:, 3] = np.arange(first, first + len(boxes), dtype=np.uint32).view(np.float32)
    references[:, 7] = 0.0
    return references
