"""The executor of a GPU: each thread renders samples of one pixel, exact sums come back."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from alight.core.errors import OptionError
from alight.films import CELL_SIZE, PartialFilm
from alight.gpu.driver import Gpu
from alight.integrators.walk import Settings
from alight.rendering.executors.blocks import Add, Block
from alight.rendering.schedules.passes import PASS_SECONDS
from alight.rendering.tiles import pixel_kernel
from alight.rendering.tiles.pixel_kernel import COUNTS, DIRECT, ITEM, SUMS, TALLY, PixelFilms
from alight.rendering.tiles.tile_kernel import INVALID, RAYS, SATURATED, Tile
from lanewise.machine import PTX, describe_machine
from lanewise.machine_code import leaves
from lanewise.ptx import THREADS, LoweringError, ptx_of
from lanewise.view import View

if TYPE_CHECKING:
    from alight.rendering.job import Job

#: Threads for each multiprocessor that keep it busy to the end of a launch, if there are so many
#: samples.
THREADS_EACH = 2048

#: Bytes of the sums of one launch, at most, if they are not those of a single block.
MOST_BYTES = 2**28

#: Layers that come with the picture.
SPLIT = {"direct", "indirect"}


class GpuExecutor:
    """Renders the blocks of a job on the first GPU.

    Raises
    ------
    DeviceError
        If there is none that can.
    """

    pass_seconds, adds_whole_samples, is_shared = PASS_SECONDS, False, False

    def __init__(self) -> None:
        self._gpu = Gpu()
        self._seconds = self._launches = 0.0
        self._film: tuple[int, ...] = ()
        self._sizes: Sequence[int] = (0, 0, 0, 0)
        self._items = 0

    @property
    def note(self) -> str:
        """The GPU's name."""
        return self._gpu.name

    @property
    def machine(self) -> Mapping[str, str]:
        """What decides the bits of its samples."""
        return {**describe_machine(PTX), **self._gpu.description}

    def __enter__(self) -> Self:
        """Take hold of the GPU."""
        self._gpu.__enter__()
        return self

    def __exit__(self, *raised: object) -> None:
        """Let go of it."""
        self._gpu.__exit__(*raised)

    def check(self, job: Job) -> None:
        """Refuse what only the processor renders.

        Raises
        ------
        OptionError
        """
        program = job.scene.program
        found = [
            (job.splats, f"the integrator {program.integrator}, whose paths start at lights"),
            (bool(program.registered), "models of plugins"),
            (bool(set(program.aovs) - SPLIT), "layers other than direct and indirect"),
            (job.scene.ground is not None, "shadows on the ground"),
        ]
        missing = [text for there, text in found if there]
        if missing:
            raise OptionError(f"not rendered by a GPU yet: {'; '.join(missing)}", "device")

    def begin(self, job: Job) -> None:
        """Send the scene and its kernel.

        Raises
        ------
        AlightError
            If the scene has no kernel for GPUs, or no room on this one.
        """
        self._split = "direct" in job.scene.program.aovs
        program = job.scene.program._replace(aovs=("direct",) if self._split else ())
        nothing = View(np.zeros(1, np.int64))
        films = PixelFilms(nothing, nothing, nothing, nothing)
        arguments = (job.scene.tables, job.settings, nothing, films, 0)
        try:
            code = ptx_of(pixel_kernel.__name__, "render_pixel", program, arguments)
        except LoweringError as error:
            text = f"this scene's kernel cannot be compiled for a GPU: {error}"
            raise OptionError(text, "device") from None
        self._kernel = self._gpu.load(code.code, code.symbol)
        self._kinds = code.arguments
        self._sent: dict[tuple[int, int], int] = {}
        self._scene = list(leaves(job.scene.tables, self._send))

    def _send(self, table: View) -> int:
        """The address of a table's copy on the GPU, made once."""
        key = (table.address, table.array.nbytes)
        if key not in self._sent:
            self._sent[key] = self._gpu.allocate(table.array.nbytes)
            self._gpu.write(self._sent[key], table.array)
        return self._sent[key]

    def render(
        self,
        settings: Settings,
        blocks: Sequence[Block],
        add: Add,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render blocks, as many in one launch as there is room for; see `Executor`."""
        most = MOST_BYTES // (8 * sum(_numbers(settings.replicates)))
        for group in groups(blocks, most):
            if cancel.is_set():
                return
            for partial, rays in self._render(settings, group):
                add(partial, rays)
                report()

    def _render(
        self, settings: Settings, group: Sequence[Block]
    ) -> Iterator[tuple[PartialFilm, int]]:
        replicates = settings.replicates
        pixels = sum(map(pixels_in, group))
        shares = max(1, THREADS_EACH * self._gpu.multiprocessors // pixels)
        work, shares = work_of(group, shares)
        places = shares * pixels
        sizes = [8 * n * places for n in _numbers(replicates)]
        self._make_room(len(work), sizes)
        for address, size in zip(self._film, sizes, strict=True):
            self._gpu.clear(address, size)
        self._gpu.write(self._work, work)
        begin = time.perf_counter()
        tables = [number for address, size in zip(self._film, sizes, strict=True)
                  for number in (address, size // 8)]  # fmt: skip
        self._gpu.launch(self._kernel, THREADS, self._kinds, [
            *self._scene, *leaves(settings, self._send), self._work, work.size, *tables, len(work),
        ])  # fmt: skip
        self._seconds += time.perf_counter() - begin
        self._launches += 1
        found = []
        for address, n in zip(self._film, _numbers(replicates), strict=True):
            array = np.zeros((shares, pixels, n), np.int64)
            self._gpu.read(address, array)
            found.append(array.sum(axis=0) if shares > 1 else array[0])
        yield from self._partials(settings, group, found)

    def _partials(
        self, settings: Settings, group: Sequence[Block], found: Sequence[np.ndarray]
    ) -> Iterator[tuple[PartialFilm, int]]:
        first = 0
        for tile, ranges in group:
            height, width = tile.y1 - tile.y0, tile.x1 - tile.x0
            part = slice(first, first + height * width)
            first = part.stop
            shape = (height, width, settings.replicates)
            sums = np.ascontiguousarray(found[0][part]).reshape(*shape, 3, 2)
            direct = found[2][part].reshape(height, width, 3, 2)
            tally = found[3][part].sum(axis=0)
            aovs = {"direct": direct, "indirect": sums.sum(axis=2) - direct}
            yield PartialFilm(
                x0=tile.x0, y0=tile.y0, sums=sums, counts=found[1][part].reshape(shape),
                invalid=int(tally[INVALID]), saturated=int(tally[SATURATED]), ranges=ranges,
                aovs=aovs if self._split else {},
            ), int(tally[RAYS])  # fmt: skip

    def _make_room(self, items: int, sizes: Sequence[int]) -> None:
        """Have memory for so much work and so many bytes of sums; what is there is used again."""
        if any(size > there for size, there in zip(sizes, self._sizes, strict=True)):
            for address in self._film:
                self._gpu.free(address)
            self._film, self._sizes = (), (0, 0, 0, 0)
            self._film = tuple(map(self._gpu.allocate, sizes))
            self._sizes = sizes
        if items > self._items:
            if self._items:
                self._gpu.free(self._work)
            self._items = 0
            self._work = self._gpu.allocate(8 * ITEM * items)
            self._items = items

    def statistics(self) -> dict[str, Any]:
        """The GPU, and how long it was busy, as ``gpu``."""
        return {"gpu": {**self._gpu.description, "launches": int(self._launches),
                        "seconds": round(self._seconds, 6)}}  # fmt: skip


def _numbers(replicates: int) -> tuple[int, int, int, int]:
    """Numbers of each table of `PixelFilms` for one place."""
    return SUMS * replicates, COUNTS * replicates, DIRECT, TALLY


def pixels_in(block: Block) -> int:
    """How many pixels a block's tile has."""
    tile = block.tile
    return (tile.x1 - tile.x0) * (tile.y1 - tile.y0)


def groups(blocks: Sequence[Block], most: int) -> Iterator[list[Block]]:
    """Neighbouring blocks of at most so many pixels together, one at least."""
    found: list[Block] = []
    pixels = 0
    for block in blocks:
        if found and pixels + pixels_in(block) > most:
            yield found
            found, pixels = [], 0
        found.append(block)
        pixels += pixels_in(block)
    if found:
        yield found


def work_of(blocks: Sequence[Block], shares: int) -> tuple[np.ndarray, int]:
    """Items of work for all samples of some blocks.

    Threads that run together get neighbouring pixels, since their paths are alike.

    Parameters
    ----------
    blocks : sequence of Block
    shares : int
        Into so many items a pixel's samples are cut; fewer if it has fewer.

    Returns
    -------
    work : ndarray of int64, shape (items, `ITEM`)
    shares : int
        As they are: sums have so many places for each pixel, share by share.
    """
    pixels = sum(map(pixels_in, blocks))
    shares = max(1, min(shares, max(int(block.ranges[..., 1].max(initial=0)) for block in blocks)))
    found, before = [], 0
    for block in blocks:
        x, y, first, count, place = _pixels_of(block)
        for share in range(shares):
            begin, end = count * share // shares, count * (share + 1) // shares
            at = share * pixels + before + place
            items = np.stack([x, y, first + begin, end - begin, at], axis=-1)
            found.append(items[end > begin])
        before += pixels_in(block)
    return np.ascontiguousarray(np.concatenate(found), np.int64), shares


def _pixels_of(block: Block) -> list[np.ndarray]:
    """x, y, first sample, count and number in the tile of each pixel, cell by cell."""
    tile: Tile = block.tile
    y, x = (
        axis.ravel() for axis in np.mgrid[int(tile.y0) : int(tile.y1), int(tile.x0) : int(tile.x1)]
    )
    row, column = y // CELL_SIZE - tile.y0 // CELL_SIZE, x // CELL_SIZE - tile.x0 // CELL_SIZE
    first, count = block.ranges[row, column, 0], block.ranges[row, column, 1]
    order = np.lexsort((x, y, column, row))
    return [part[order] for part in (x, y, first, count, np.arange(len(x)))]
