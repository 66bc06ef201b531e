"""The first levels of the binary tree: big sets of primitives, divided by all threads together.

A set in which all threads can work is divided in passes over chunks of references (`top`); of
smaller ones each thread takes one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.accel.layout import TOP_LEVELS, aligned_zeros
from alight.accel.references import COUNTS, MARGIN, ROUNDING, TABLE
from alight.accel.splitting import Records, Rules, Workspace
from alight.accel.subtree import Source
from alight.accel.top import Chunk, Shared
from lanewise.view import View

#: Primitives that one thread takes at a time while all work on the same set.
CHUNK = 65536

#: Sets below this size, or this part of all primitives, become tasks.
SMALLEST_TASK, TASKS = 4096, 32

#: Sets above this part of all primitives are divided by all threads together.
TOGETHER = 8


class TopDivision:
    """Sets of primitives as records (`splitting`), from the whole to those that are tasks.

    Parameters
    ----------
    compiled : build.Kernels
    pool : build.Pool
    rules : Rules
    source : Source
    boxes : (m, 2, 3) float32
        Bounds of the primitives that are not triangles, metres.

    Attributes
    ----------
    work : Workspace
    records : Records
    """

    def __init__(self, compiled: Any, pool: Any, rules: Rules, source: Source, boxes: np.ndarray):
        self.compiled, self.pool, self.rules = compiled, pool, rules
        self.n = n = source.triangles + len(boxes)
        self.work = Workspace(
            View(aligned_zeros(n, 8)),
            View(aligned_zeros(n, 8)),
            View(np.zeros(n, np.uint32)),
        )
        # A set at the top has more than n / TASKS primitives, so a level has fewer than TASKS.
        room = TASKS * (TOP_LEVELS + 1) + 1
        self.records = Records(View(aligned_zeros(room, 16)), View(np.zeros(3 * room, np.int64)))
        rows = -(-n // CHUNK) + 1
        self.shared = Shared(
            View(aligned_zeros(rows, TABLE)),
            View(np.zeros(rows * COUNTS, np.int64)),
            View(np.zeros(rows + 2, np.int64)),
        )
        self._refer(source, boxes)

    def _refer(self, source: Source, boxes: np.ndarray) -> None:
        """References to all primitives; record 0 becomes the whole set."""
        starts = range(0, source.triangles, CHUNK)
        bounds = View(aligned_zeros(len(starts) + 1, 16))
        self.pool.run(
            lambda begin: self.compiled.refer(
                source.vertices,
                source.faces,
                self.work.a,
                bounds,
                begin // CHUNK,
                begin,
                min(begin + CHUNK, source.triangles),
            ),
            starts,
        )
        references = self.work.a.array.reshape(-1, 8)[source.triangles :]
        references[:] = references_of_boxes(boxes, source.triangles)
        centers = references[:, :4] - references[:, 4:]
        others = np.hstack([references, centers, -centers])
        rows = np.concatenate([bounds.array.reshape(-1, 16)[: len(starts)], others])
        self.records.boxes.array[:16] = rows.min(axis=0)
        self.records.ranges.array[:3] = 0, self.n, 0

    def box(self, record: int) -> np.ndarray:
        """A copy, as the record will be that of a part: (8,) float32, as that of a reference."""
        return self.records.boxes.array[16 * record : 16 * record + 8].copy()

    def size(self, record: int) -> int:
        """Primitives in a record."""
        begin, end = self.records.ranges.array[3 * record : 3 * record + 2]
        return int(end - begin)

    def largest_edge(self) -> float:
        """The longest edge of the whole, metres, as `references.largest_edge`."""
        box = self.box(0)
        return float(np.maximum(-(box[:3] + box[4:7]).min(), np.float32(1e-36)))

    def divide(self) -> tuple[list[tuple[int, np.ndarray]], dict[int, tuple[int, int]]]:
        """Divide the sets that are too big for a task.

        Returns
        -------
        sets : list of (record, box)
            All there have been, the whole first. The record is that of the set's left-most part.
        parts : dict
            The left and right part of each set that has been divided.
        """
        limit = max(SMALLEST_TASK, self.n // TASKS)
        sets, parts = [(0, self.box(0))], {}
        level = [0]
        for _ in range(TOP_LEVELS):
            level = [k for k in level if self.size(sets[k][0]) > limit]
            pairs = [(sets[k][0], len(sets) // 2 + 1 + i) for i, k in enumerate(level)]
            self._divide_level(pairs)
            for k, pair in zip(level, pairs, strict=True):
                parts[k] = len(sets), len(sets) + 1
                sets += [(record, self.box(record)) for record in pair]
            level = [part for k in level for part in parts[k]]
        return sets, parts

    def _divide_level(self, pairs: list[tuple[int, int]]) -> None:
        """Divide the first record of each pair into both."""
        big = [pair for pair in pairs if self.size(pair[0]) > self.n // TOGETHER]
        small = [pair for pair in pairs if pair not in big]
        for pair in big:
            self._divide(*pair)
        work, records, rules = self.work, self.records, self.rules
        self.pool.run(lambda pair: self.compiled.divide(work, records, *pair, rules), small)

    def _divide(self, i: int, j: int) -> None:
        """Divide record i into i and j, all threads together."""
        work, records, shared = self.work, self.records, self.shared
        first, end = (int(k) for k in records.ranges.array[3 * i : 3 * i + 2])
        starts = range(first, end, CHUNK)
        rows = len(starts)
        chunks = [
            Chunk(begin, min(begin + CHUNK, end), row) for row, begin in enumerate(starts, start=1)
        ]
        self.pool.run(lambda chunk: self.compiled.bin(work, records, i, chunk, shared), chunks)
        self.compiled.choose(records, i, rows, shared, self.rules)
        if shared.result.array[0] < 0:
            self.compiled.halve(work, records, i, j)
            return
        lefts = np.concatenate([[0], np.cumsum(shared.result.array[2 : 2 + rows])])
        middle = first + int(lefts[-1])

        def partition_one(chunk: Chunk) -> None:
            left = int(lefts[chunk.row - 1])
            right = middle + (chunk.begin - first - left)
            self.compiled.partition(work, records, i, chunk, first + left, right, shared)

        self.pool.run(partition_one, chunks)
        self.compiled.conclude(records, i, j, rows, shared, middle)


def references_of_boxes(boxes: np.ndarray, first: int) -> np.ndarray:
    """References to primitives given by their boxes (m, 2, 3); their indices are `first` and on."""
    references = np.zeros((len(boxes), 8), np.float32)
    references[:, :3], references[:, 4:7] = boxes[:, 0], -boxes[:, 1]
    size = (boxes[:, 1] - boxes[:, 0]).max(axis=1, initial=0.0)
    references -= size[:, None] * MARGIN + np.abs(references) * ROUNDING
    references[:, 3] = np.arange(first, first + len(boxes), dtype=np.uint32).view(np.float32)
    references[:, 7] = 0.0
    return references
