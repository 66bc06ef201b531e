"""Build of the bounding volume hierarchy on several threads.

First all threads together divide the whole set, each pass over chunks of references (`top`). Then
each thread takes one of the sets and divides it in two, until there are enough for all; the binary
trees over those are tasks, largest first. At last nodes take up what levels of the whole binary
tree they can hold (`collapse`). Chunks and tasks depend on the number of primitives only, so the
tree is the same for any number of threads.
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
from alight.accel.collapse import RIGHT, ROW, assign_columns, write_all_costs, write_costs_of
from alight.accel.cost import sah_cost, waits_for_memory
from alight.accel.layout import (
    BLOCK,
    CHILD,
    MAX_LEAF,
    NODE,
    OTHERS_IN_LEAF,
    TOP_LEVELS,
    UPPER,
    WIDTH,
    Bvh,
    check_blocks,
)
from alight.accel.references import COUNTS, MARGIN, ROUNDING, TABLE, refer_to_triangles
from alight.accel.splitting import MEDIAN, SAH, Rules, Workspace, divide_alone, halve
from alight.accel.subtree import Source, build_subtree, pack
from lanewise.jit import instantiate
from lanewise.view import View

#: Primitives that one thread takes at a time while all work on the same set.
CHUNK = 65536

#: Sets below this size, or this part of all primitives, become tasks.
SMALLEST_TASK, TASKS = 4096, 32

#: Sets above this part of all primitives are divided by all threads together.
TOGETHER = 8

METHODS = {"sah": SAH, "median": MEDIAN}

#: How shared vertices are estimated: RUNS runs of RUN triangles.
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
    nothing = np.zeros((0, BLOCK), np.float32), np.zeros((0, 2, 3), np.float32)
    # The second has no plane with something on both sides.
    for n, spread in ((16 * SMALLEST_TASK, 1), (2 * SMALLEST_TASK, 0)) if big else ((16, 1),):
        place = spread * np.arange(3 * n, dtype=np.float32)
        vertices = np.stack([place, place % 3, place % 128], axis=1)
        faces = np.arange(3 * n, dtype=np.int32).reshape(n, 3)
        _Builder(kernels(), _Pool(1), SAH, vertices, faces, *nothing).run()


def aligned_zeros(rows: int, columns: int) -> np.ndarray:
    """Zeros of shape (rows, columns), float32, that start at a cache line."""
    n = rows * columns
    memory = np.zeros(n + 16, np.float32)
    skip = (-memory.ctypes.data // 4) % 16
    return memory[skip : skip + n].reshape(rows, columns)


Kernels = namedtuple(
    "Kernels", "refer bin choose partition conclude halve divide subtree costs costs_of assign pack"
)


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
        divide_alone,
        build_subtree,
        write_all_costs,
        write_costs_of,
        assign_columns,
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
        # A set at the top has more than n / TASKS primitives, so a level has fewer than TASKS.
        room = TASKS * (TOP_LEVELS + 1) + 1
        self.records = View(aligned_zeros(room, 16))
        self.ranges = View(np.zeros(3 * room, np.int64))
        rows = -(-n // CHUNK) + 1
        self.tables = View(aligned_zeros(rows, TABLE))
        self.counts = View(np.zeros(rows * COUNTS, np.int64))
        self.result = View(np.zeros(rows + 2, np.int64))
        self.boxes = boxes

    def run(self) -> tuple[Bvh, dict]:
        """All steps: references, top, subtrees, nodes, packing."""
        self._refer()
        self.scale = 1.0 / self._largest_edge()
        sets, parts = self._divide_top()
        tasks = [k for k in range(len(sets)) if k not in parts]
        totals = self._build_subtrees([sets[k][0] for k in tasks])
        rows, starts = self._join(sets, parts, tasks, totals)
        return self._pack(rows, starts, totals)

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

    def _divide_top(self) -> tuple[list[tuple[int, np.ndarray]], dict[int, tuple[int, int]]]:
        """Divide the big sets.

        Returns
        -------
        sets : list of (record, box)
            All there have been, the whole first. The record is that of the set's left-most part.
        parts : dict
            The left and right part of each set that has been divided.
        """
        limit = max(SMALLEST_TASK, self.n // TASKS)
        sets, parts = [(0, self._box(0))], {}
        level = [0]
        for _ in range(TOP_LEVELS):
            level = [k for k in level if self._size(sets[k][0]) > limit]
            pairs = [(sets[k][0], len(sets) // 2 + 1 + i) for i, k in enumerate(level)]
            self._divide_all(pairs)
            for k, pair in zip(level, pairs, strict=True):
                parts[k] = len(sets), len(sets) + 1
                sets += [(record, self._box(record)) for record in pair]
            level = [part for k in level for part in parts[k]]
        return sets, parts

    def _divide_all(self, pairs: list[tuple[int, int]]) -> None:
        """Divide the first record of each pair into both."""
        big = [pair for pair in pairs if self._size(pair[0]) > self.n // TOGETHER]
        small = [pair for pair in pairs if pair not in big]
        for pair in big:
            self._divide(*pair)
        work, records, ranges, rules = self.work, self.records, self.ranges, self.rules
        self.pool.run(lambda pair: self.compiled.divide(work, records, ranges, *pair, rules), small)

    def _box(self, record: int) -> np.ndarray:
        """A copy, as the record will be that of a part: (8,) float32, as that of a reference."""
        return self.records.array[16 * record : 16 * record + 8].copy()

    def _largest_edge(self) -> float:
        """The longest edge of the whole, metres, as `references.largest_edge`."""
        box = self._box(0)
        return float(np.maximum(-(box[:3] + box[4:7]).min(), np.float32(1e-36)))

    def _size(self, record: int) -> int:
        begin, end = self.ranges.array[3 * record : 3 * record + 2]
        return int(end - begin)

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

    def _build_subtrees(self, tasks: list[int]) -> np.ndarray:
        """Build all tasks, given as records; (tasks, 3) int64: rows, blocks, leaves of each."""
        totals = View(np.zeros(3 * len(tasks), np.int64))
        # Most trees have far fewer rows than the worst, so each thread has room for that and what
        # is used is kept.
        room = 2 * max(self._size(record) for record in tasks)
        local = threading.local()
        self.built = [np.zeros((0, ROW), np.float32)] * len(tasks)

        def build_one(k: int) -> None:
            if not hasattr(local, "rows"):
                local.rows = View(aligned_zeros(room, ROW))
            self.compiled.subtree(
                self.work, local.rows, self.records, self.ranges, tasks[k], k,
                self.rules, self.source, totals,
            )  # fmt: skip
            count = int(totals.array[3 * k])
            self.compiled.costs(local.rows, count, self.scale)
            self.built[k] = local.rows.array.reshape(-1, ROW)[:count].copy()

        self.pool.run(build_one, sorted(range(len(tasks)), key=lambda k: -self._size(tasks[k])))
        return totals.array.reshape(-1, 3)

    def _join(self, sets, parts, tasks, totals) -> tuple[View, list[int]]:
        """The whole binary tree, and where the rows of each task start."""
        task_of = {number: k for k, number in enumerate(tasks)}
        place, waiting, at = 0, [0], {}
        while waiting:
            number = waiting.pop()
            at[number] = place
            place += 1 if number in parts else int(totals[task_of[number], 0])
            waiting += reversed(parts.get(number, ()))
        rows = aligned_zeros(place, ROW)
        starts = [at[number] for number in tasks]

        def copy_one(k: int) -> None:
            built = self.built[k]
            right = built.view(np.uint32)[:, RIGHT]
            right[right > 0] += np.uint32(starts[k])
            rows[starts[k] : starts[k] + len(built)] = built

        self.pool.run(copy_one, range(len(tasks)))
        del self.built
        for number, (_, right) in parts.items():
            rows[at[number], :8] = sets[number][1]
            rows[at[number]].view(np.uint32)[RIGHT] = at[right]
        tree = View(rows)
        listed = np.array(sorted((at[number] for number in parts), reverse=True), np.int64)
        self.compiled.costs_of(tree, View(listed), len(listed), self.scale)
        return tree, starts

    def _pack(self, rows: View, starts: list[int], totals: np.ndarray) -> tuple[Bvh, dict]:
        """The final arrays."""
        # The references have done their work; their memory is as much as the final arrays'.
        order = self.work.order
        del self.work
        count = rows.size // ROW
        used, found = View(np.zeros(count, np.int64)), View(np.zeros(2, np.int64))
        self.compiled.assign(rows, count, used, found)
        nodes, depth = (int(k) for k in found.array)
        block_at = np.concatenate([[0], np.cumsum(totals[:, 1])])
        check_blocks(int(block_at[-1]))
        bvh = Bvh(
            View(aligned_zeros(nodes, NODE)),
            View(aligned_zeros(int(block_at[-1]), BLOCK)),
            View(np.zeros(0, np.uint32)),
            0,
        )
        missing = bvh.nodes.array.reshape(-1, NODE)
        missing[:, :UPPER], missing[:, UPPER:CHILD] = np.inf, -np.inf

        def pack_rows(first: int, end: int, block: int) -> None:
            self.compiled.pack(order, rows, first, end, bvh.nodes, bvh.blocks, block, self.source)

        ends = [start + int(n) for start, n in zip(starts, totals[:, 0], strict=True)]
        self.pool.run(lambda k: pack_rows(starts[k], ends[k], int(block_at[k])), range(len(starts)))
        # The rows of the top lie between the tasks.
        for start, end in zip([0, *sorted(ends)], [*sorted(starts), count], strict=True):
            pack_rows(start, end, 0)
        return bvh, {
            "nodes": nodes,
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
