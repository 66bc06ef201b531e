"""Build of the bounding volume hierarchy on several threads.

First the whole set is divided until there are enough parts for all threads (`top_division`); the
binary trees over those are tasks, largest first. At last nodes take up what levels of the whole
binary tree they can hold (`collapse`). Chunks and tasks depend on the number of primitives only, so
the tree is the same for any number of threads.
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
from alight.accel.fill import expected_fill
from alight.accel.layout import BLOCK, CHILD, NODE, UPPER, Bvh, aligned_zeros, check_blocks
from alight.accel.references import refer_to_triangles
from alight.accel.splitting import MEDIAN, SAH, Rules, divide_alone, halve
from alight.accel.subtree import Source, build_subtree, pack
from alight.accel.top_division import SMALLEST_TASK, TopDivision
from lanewise.jit import instantiate
from lanewise.view import View

METHODS = {"sah": SAH, "median": MEDIAN}


def build_bvh(
    vertices: np.ndarray,
    faces: np.ndarray,
    others: np.ndarray | None = None,
    boxes: np.ndarray | None = None,
    *,
    method: str = "sah",
    threads: int = 1,
    many: int = 0,
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
    many : int
        How many of the others are one of many (`fill`).

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
        builder = _Builder(kernels(), pool, METHODS[method], vertices, faces, others, boxes, many)
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

    def __init__(self, compiled, pool, method, vertices, faces, others, boxes, many=0):
        self.compiled, self.pool = compiled, pool
        self.rules = Rules(method, expected_fill(vertices, faces, len(others), many))
        self.source = Source(View(vertices), View(faces), len(faces), View(others))
        self.top = TopDivision(compiled, pool, self.rules, self.source, boxes)

    def run(self) -> tuple[Bvh, dict]:
        """All steps: references, top, subtrees, nodes, packing."""
        self.scale = 1.0 / self.top.largest_edge()
        sets, parts = self.top.divide()
        tasks = [k for k in range(len(sets)) if k not in parts]
        totals = self._build_subtrees([sets[k][0] for k in tasks])
        rows, starts = self._join(sets, parts, tasks, totals)
        return self._pack(rows, starts, totals)

    def _build_subtrees(self, tasks: list[int]) -> np.ndarray:
        """Build all tasks, given as records; (tasks, 3) int64: rows, blocks, leaves of each."""
        top, totals = self.top, np.zeros((len(tasks), 3), np.int64)
        # Most trees have far fewer rows than the worst, so each thread has room for that and what
        # is used is kept.
        room = 2 * max(top.size(record) for record in tasks)
        local = threading.local()
        self.built = [np.zeros((0, ROW), np.float32)] * len(tasks)

        def build_one(k: int) -> None:
            if not hasattr(local, "rows"):
                local.rows = View(aligned_zeros(room, ROW))
            self.compiled.subtree(
                top.work, local.rows, top.records, tasks[k],
                self.rules, self.source, View(totals[k]),
            )  # fmt: skip
            count = int(totals[k, 0])
            self.compiled.costs(local.rows, count, self.scale)
            self.built[k] = local.rows.array.reshape(-1, ROW)[:count].copy()

        self.pool.run(build_one, sorted(range(len(tasks)), key=lambda k: -top.size(tasks[k])))
        return totals

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
        order = self.top.work.order
        del self.top
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
            self.compiled.pack(order, rows, first, end, bvh, block, self.source)

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
