"""Light paths as tasks of a cluster: samples of the whole window that belong to one replicate.

A light path may add to any pixel, so the answer to a task is a picture. It is that of one replicate
only, whatever the number of samples, and so small: sample i of a pixel belongs to replicate i mod
R, and a task takes every R-th sample. Samples of whole windows can be added to a film one after the
other, since each of them is a picture. Where one takes too long for a task, strips of the window
say which paths start, and the client waits for the last strip.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from alight.films import CELL_SIZE, PartialFilm
from alight.films.archive import pack_archive
from alight.films.fixed_point import LOW_BITS, MAX_SAMPLES, carry
from alight.films.sample_ranges import EMPTY, SampleRanges, cells_of
from alight.films.tiles import add_sums
from alight.rendering.executors.block_tasks import (
    HEADER,
    LARGEST,
    SHARES,
    SharedScene,
    check_counts,
    limbs_of,
    read_from,
    sums_of,
    tallies_of,
)
from alight.rendering.executors.blocks import Add, Block
from alight.rendering.tiles.tile import Scratch
from alight.rendering.tiles.tile_kernel import INVALID, RAYS, SATURATED, Tile
from lanewise.view import View

#: Seconds of a task, about, where there is much to do: its answer is larger than those of others.
LONGEST = 4.0

#: Additions to a pixel after which limb 1 is carried, so that it does not overflow.
_ROOM = 1 << (62 - LOW_BITS)

#: Splats of one path, at most, where its length has no bound.
_MOST_EDGES = 64


@dataclass(frozen=True, kw_only=True)
class LightTask:
    """Light paths that one thread traces: some samples of a replicate, in a strip of the window.

    Attributes
    ----------
    seed : int
        Of the film.
    window, strip : Tile
        The strip's rows are those of whole cells.
    ranges : ndarray of int64, shape (cells_y, cells_x, 2)
        (first, count) of the sample indices that are wanted of each cell of the window; of all
        cells with shape (1, 1, 2).
    replicates, replicate : int
        How many there are, and which one is wanted.
    first, count : int
        Of the samples of this replicate in `ranges`, by their order.
    """

    seed: int
    window: Tile
    strip: Tile
    ranges: np.ndarray
    replicates: int
    replicate: int
    first: int
    count: int

    @property
    def digest(self) -> str:
        """Names all that the answer depends on."""
        of_replicate = self.replicates, self.replicate, self.first, self.count
        numbers = self.seed, *self.window, *self.strip, *of_replicate, *self.ranges.shape
        found = hashlib.sha256(repr(tuple(map(int, numbers))).encode())
        found.update(np.ascontiguousarray(self.ranges, np.int64).tobytes())
        return found.hexdigest()

    @property
    def samples(self) -> float:
        """How many, as if cells at the window's edges were whole."""
        width, height = _size(self.strip)
        return self.count * width * height

    def indices(self) -> tuple[np.ndarray, np.ndarray]:
        """Sample indices of each cell and whether they are wanted, shape (count, cells_y, cells_x).

        The cells are those of the window, or one for all of them.
        """
        first, count = self.ranges[..., 0], self.ranges[..., 1]
        aligned = first + (self.replicate - first) % self.replicates
        steps = np.arange(self.first, self.first + self.count)[:, None, None]
        index = aligned + self.replicates * steps
        return index, index < first + count

    def blocks(self) -> Iterator[Block]:
        """Give the samples one by one, each of the strip."""
        shape = _cells(self.window)
        rows = slice(
            self.strip.y0 // CELL_SIZE - self.window.y0 // CELL_SIZE,
            -(-self.strip.y1 // CELL_SIZE) - self.window.y0 // CELL_SIZE,
        )
        for index, wanted in zip(*self.indices(), strict=True):
            pairs = np.stack([index, wanted.astype(np.int64)], axis=-1)
            pairs = np.broadcast_to(pairs, (*shape, 2))[rows]
            yield Block(self.strip, np.ascontiguousarray(pairs))

    def samples_of_pixels(self) -> np.ndarray:
        """Samples that start at each pixel of the window, int64, shape (height, width)."""
        _, wanted = self.indices()
        x, y, _, _ = self.window
        width, height = _size(self.window)
        of_cell = np.broadcast_to(wanted.sum(axis=0), _cells(self.window))
        rows = np.arange(y, y + height) // CELL_SIZE - y // CELL_SIZE
        columns = np.arange(x, x + width) // CELL_SIZE - x // CELL_SIZE
        found = of_cell[rows[:, None], columns[None, :]].astype(np.int64)
        found[: self.strip.y0 - y] = 0
        found[self.strip.y1 - y :] = 0
        return found

    def cells(self) -> np.ndarray:
        """`SampleRanges` of the samples of each cell, or of one for all."""
        index, wanted = self.indices()
        known: dict[tuple, SampleRanges] = {}
        grid = np.full(index.shape[1:], EMPTY, dtype=object)
        for at in np.ndindex(grid.shape):
            held = tuple(index[(slice(None), *at)][wanted[(slice(None), *at)]].tolist())
            if held not in known:
                known[held] = SampleRanges((i, i + 1) for i in held)
            grid[at] = known[held]
        return grid


def _size(tile: Tile) -> tuple[int, int]:
    return tile.x1 - tile.x0, tile.y1 - tile.y0


def _cells(tile: Tile) -> tuple[int, int]:
    rows, columns = cells_of(tile.x0, tile.y0, *_size(tile))
    return rows.stop - rows.start, columns.stop - columns.start


def render_light_task(shared: SharedScene, task: LightTask) -> bytes:
    """Trace the light paths of a task: a pure function of the scene and the task."""
    settings = shared.settings._replace(seed=task.seed)
    film = Scratch().film(settings, task.window, False)
    sums = film.sums.shaped[:, :, task.replicate]
    width, height = _size(task.strip)
    additions = width * height * min(settings.max_depth + 1, _MOST_EDGES)
    since = 0
    for tile, ranges in task.blocks():
        if since + additions > _ROOM:
            carry(sums)
            since = 0
        since += additions
        places = (tile, task.window)
        shared.kernels.beauty(shared.scene.tables, settings, places, View(ranges), film)
    tally = film.tally.array
    content = {
        "task": task.digest, "invalid": int(tally[INVALID]), "saturated": int(tally[SATURATED]),
        "rays": int(tally[RAYS]),
    }  # fmt: skip
    counts = film.counts.shaped[:, :, task.replicate].copy()
    return b"".join(pack_archive(content, {"counts": counts, **limbs_of("", sums)}))


class LightSums(NamedTuple):
    """What the light paths of a task add to the window, in a form that `Film.add_tile` takes."""

    partial: PartialFilm
    rays: int


def read_light_sums(channels: int, task: LightTask, data: Any) -> LightSums:
    """Read the answer to a task, and refuse what cannot be one.

    Raises
    ------
    FilmError
        As `alight.rendering.executors.block_tasks.read_blocks`.
    """
    expected = task.samples_of_pixels()
    most_bytes = 8 * (2 * channels + 1) * expected.size + HEADER
    with read_from(task, data, most_bytes) as (content, arrays):
        check_counts(arrays, "counts", expected)
        # All paths may reach one pixel, and add to it at each of their vertices.
        most = min(int(expected.sum()) * _MOST_EDGES, MAX_SAMPLES) * LARGEST
        sums = sums_of(arrays, "", (*expected.shape, channels), most)
        invalid, saturated, rays = tallies_of(content)
    partial = PartialFilm(
        x0=task.window.x0, y0=task.window.y0, sums=sums[:, :, None], counts=expected[:, :, None],
        invalid=invalid, saturated=saturated, ranges=task.cells(), aovs={},
        replicate=task.replicate,
    )  # fmt: skip
    return LightSums(partial, rays)


class LightQueue:
    """Light paths that no task has yet, and those of which some strips are not there yet.

    Parameters
    ----------
    blocks : sequence of Block
        Strips of the window.
    window : Tile
    replicates, seed : int
    """

    def __init__(self, blocks: Sequence[Block], window: Tile, replicates: int, seed: int) -> None:
        ranges = np.zeros((*_cells(window), 2), np.int64)
        for tile, of_tile in blocks:
            top = tile.y0 // CELL_SIZE - window.y0 // CELL_SIZE
            ranges[top : top + len(of_tile)] = of_tile
        if (ranges == ranges[:1, :1]).all():
            ranges = ranges[:1, :1].copy()
        self._like = LightTask(
            seed=seed, window=window, strip=window, ranges=ranges, replicates=replicates,
            replicate=0, first=0, count=0,
        )  # fmt: skip
        first, count = ranges[..., 0], ranges[..., 1]
        before = (np.arange(replicates)[:, None, None] - first) % replicates
        #: Of each replicate: samples that there are, and that have been cut off.
        self._most = (-((before - count) // replicates)).clip(0).max(axis=(1, 2))
        self._next = np.zeros(replicates, np.int64)
        self._pending: dict[tuple[int, int], list[LightSums]] = {}
        self._strips: list[LightTask] = []

    def cut(self, speed: float, threads: int) -> LightTask | None:
        """Take the samples of one task, None at the end; see `BlockQueue.cut`.

        Replicates take turns, so that all are equally far.
        """
        if self._strips:
            return self._strips.pop()
        left = self._most - self._next
        if not left.any():
            return None
        pixels = math.prod(_size(self._like.window))
        replicate = int(np.where(left > 0, self._next, np.iinfo(np.int64).max).argmin())
        seconds = min(left.sum() * pixels / (speed * max(threads, 1) * SHARES), LONGEST)
        count = min(int(left[replicate]), max(1, round(speed * seconds / pixels)))
        task = replace(
            self._like, replicate=replicate, first=int(self._next[replicate]), count=count
        )
        self._next[replicate] += count
        strips = math.ceil(pixels / (speed * LONGEST)) if threads else 1
        self._strips = list(_strips(task, strips)) if count == 1 else [task]
        if len(self._strips) > 1:
            self._pending[replicate, task.first] = []
        return self._strips.pop()

    def take(self, task: LightTask, value: LightSums, add: Add) -> None:
        """Add an answer, once all strips of its samples are there."""
        key = task.replicate, task.first
        if key not in self._pending:
            add(value.partial, value.rays)
            return
        there = self._pending[key]
        if there:
            there[:] = [_joined(there[0], value)]
        else:
            there.append(value)
        if (
            there[0].partial.counts.sum()
            == replace(task, strip=task.window).samples_of_pixels().sum()
        ):
            del self._pending[key]
            add(there[0].partial, there[0].rays)

    def rest(self, tasks: Sequence[LightTask]) -> list[Block]:
        """What has not been added, some samples of whole windows each; strips are rendered again.

        Parameters
        ----------
        tasks : sequence of LightTask
            That were cut off, and are not answered.
        """
        whole = {(task.replicate, task.first): task for task in (*tasks, *self._strips)}
        whole |= {key: replace(self._like, replicate=key[0], first=key[1], count=1)
                  for key in self._pending}  # fmt: skip
        self._pending, self._strips = {}, []
        found = [
            Block(tile, ranges)
            for task in whole.values()
            for tile, ranges in replace(task, strip=task.window).blocks()
        ]
        # From where no replicate has been, all follow one another.
        level, replicates = int(self._next.max()), self._like.replicates
        for replicate, at in enumerate(self._next.tolist()):
            count = min(level, int(self._most[replicate])) - at
            if count > 0:
                behind = replace(self._like, replicate=replicate, first=at, count=count)
                found += behind.blocks()
        first, count = self._like.ranges[..., 0], self._like.ranges[..., 1]
        for step in range(level, int(self._most.max())):
            of_step = np.clip(count - replicates * step, 0, replicates)
            pairs = np.stack([first + replicates * step, of_step], axis=-1)
            pairs = np.broadcast_to(pairs, (*_cells(self._like.window), 2))
            found.append(Block(self._like.window, np.ascontiguousarray(pairs)))
        self._next = self._most.copy()
        return found


def _strips(task: LightTask, count: int) -> Iterator[LightTask]:
    """Cut a task into strips of rows of cells."""
    x0, y0, x1, y1 = task.window
    edges = range(y0 // CELL_SIZE, -(-y1 // CELL_SIZE) + 1)
    rows = len(edges) - 1
    count = min(count, rows)
    cuts = [edges[0] + rows * i // count for i in range(count + 1)]
    for top, end in pairwise(cuts):
        strip = Tile(x0, max(y0, top * CELL_SIZE), x1, min(y1, end * CELL_SIZE))
        yield replace(task, strip=strip)


def _joined(one: LightSums, other: LightSums) -> LightSums:
    """The sums of two strips of the same samples."""
    a, b = one.partial, other.partial
    add_sums(a.sums, b.sums)
    joined = a._replace(
        counts=a.counts + b.counts, invalid=a.invalid + b.invalid,
        saturated=a.saturated + b.saturated,
    )  # fmt: skip
    return LightSums(joined, one.rays + other.rays)
