"""Blocks of samples, and who renders them: the threads of this process, or a cluster.

The main loop cuts passes into blocks. An executor renders them in any order, anywhere, and adds
each to the film once; exact sums make the film the same.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np

from alight.films import PartialFilm
from alight.integrators.walk import Settings
from alight.rendering.schedules.passes import PASS_SECONDS
from alight.rendering.tiles.tile import Scratch, render_tile
from alight.rendering.tiles.tile_kernel import Tile

if TYPE_CHECKING:
    from alight.rendering.job import Job


class Block(NamedTuple):
    """Some samples of one tile.

    Attributes
    ----------
    tile : Tile
    ranges : ndarray of int64, shape (cells_y, cells_x, 2)
        (first, count) of the sample indices of each 8x8 cell that the tile touches.
    """

    tile: Tile
    ranges: np.ndarray


#: Takes the sums of a block, or of a share of its samples, and the rays that were traced for them.
Add = Callable[[PartialFilm, int], None]


class Executor(Protocol):
    """Renders the blocks of one job; a context, at whose end it lets go of what it holds."""

    @property
    def pass_seconds(self) -> float:
        """Length of a pass at which its overhead does not show."""
        ...

    @property
    def adds_whole_samples(self) -> bool:
        """Whether a picture of light paths is complete between any two calls of `add`."""
        ...

    @property
    def note(self) -> str:
        """What progress says of who renders; empty for this process."""
        ...

    def __enter__(self) -> Self: ...
    def __exit__(self, *raised: object) -> None: ...

    def begin(self, job: Job) -> None:
        """Take a job, whose kernels are compiled."""
        ...

    def render(
        self,
        settings: Settings,
        blocks: Sequence[Block],
        add: Add,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render blocks, and `report` often; return early when `cancel` is set.

        Raises
        ------
        BaseException
            Whatever `add` or `report` raised; no `add` is called afterwards.
        """
        ...

    def statistics(self) -> dict[str, Any]:
        """What ``--stats`` says of it, by name."""
        ...


class Threads:
    """The threads of this process; they keep their memory from pass to pass."""

    pass_seconds, adds_whole_samples, note = PASS_SECONDS, False, ""
    _pool: ThreadPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, *raised: object) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def begin(self, job: Job) -> None:
        """Start the threads."""
        self._job, self._local = job, threading.local()
        self._pool = ThreadPoolExecutor(job.threads)

    def render(
        self,
        settings: Settings,
        blocks: Sequence[Block],
        add: Add,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render each block on the next free thread; see `Executor`."""
        job, local = self._job, self._local

        def work(block: Block) -> None:
            if cancel.is_set():
                return
            if not hasattr(local, "scratch"):
                local.scratch = Scratch()
            add(*render_tile(job.kernels, job.scene, settings, *block, local.scratch))

        pool = self._pool
        assert pool is not None
        futures = [pool.submit(work, block) for block in blocks]
        try:
            for future in futures:
                future.result()
                report()
        except BaseException:
            # Tiles that run are finished and added; those that wait are dropped.
            cancel.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise

    def statistics(self) -> dict[str, Any]:
        """Nothing beyond what a job says."""
        return {}
