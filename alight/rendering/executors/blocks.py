"""Blocks of samples, and who renders them: the threads of this process, or a cluster.

The main loop cuts passes into blocks. An executor renders them in any order, anywhere, and adds
each to the film once; exact sums make the film the same.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np

from alight.films import PartialFilm
from alight.integrators.walk import Settings
from alight.rendering.schedules.passes import PASS_SECONDS
from alight.rendering.tiles.tile import Scratch, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from lanewise.machine import describe_machine

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
    def is_shared(self) -> bool:
        """Whether another job keeps its threads busy when this one runs out of blocks."""
        ...

    @property
    def note(self) -> str:
        """What progress says of who renders; empty for this process."""
        ...

    @property
    def machine(self) -> Mapping[str, str]:
        """What decides the bits of its samples; see `lanewise.machine.describe_machine`."""
        ...

    def __enter__(self) -> Self: ...
    def __exit__(self, *raised: object) -> None: ...

    def check(self, job: Job) -> None:
        """Refuse a job that it cannot render, before anything is compiled.

        Raises
        ------
        AlightError
        """
        ...

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


class Crew:
    """Threads that several jobs may share, with the memory that each has from tile to tile.

    Parameters
    ----------
    count : int
    """

    def __init__(self, count: int) -> None:
        self.pool, self._local = ThreadPoolExecutor(count), threading.local()

    @property
    def scratch(self) -> Scratch:
        """The memory of the thread that asks."""
        if not hasattr(self._local, "scratch"):
            self._local.scratch = Scratch()
        return self._local.scratch

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, *raised: object) -> None:
        """End the threads."""
        self.pool.shutdown()


class Threads:
    """The threads of this process; they keep their memory from pass to pass.

    Parameters
    ----------
    crew : Crew, optional
        Of somebody else, who ends it; by default each job has its own.
    """

    pass_seconds, adds_whole_samples, note = PASS_SECONDS, False, ""

    def __init__(self, crew: Crew | None = None) -> None:
        self._shared, self._own = crew, ExitStack()
        self.is_shared = crew is not None

    def __enter__(self) -> Self:
        """Nothing to open."""
        return self

    def __exit__(self, *raised: object) -> None:
        """End the threads."""
        self._own.close()

    @property
    def machine(self) -> Mapping[str, str]:
        """That of this process."""
        return describe_machine()

    def check(self, job: Job) -> None:
        """Threads render all that there is."""

    def begin(self, job: Job) -> None:
        """Start the threads."""
        self._job = job
        self._crew = self._shared or self._own.enter_context(Crew(job.threads))

    def render(
        self,
        settings: Settings,
        blocks: Sequence[Block],
        add: Add,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render each block on the next free thread; see `Executor`."""
        job, crew = self._job, self._crew
        # `cancel` is the caller's, who may use it again after an error.
        dropped = threading.Event()

        def work(block: Block) -> None:
            if not (cancel.is_set() or dropped.is_set()):
                add(*render_tile(job.kernels, job.scene, settings, *block, crew.scratch))

        futures = [crew.pool.submit(work, block) for block in blocks]
        try:
            for future in futures:
                future.result()
                report()
        except BaseException:
            # Tiles that run are finished and added; those that wait are dropped.
            dropped.set()
            for future in futures:
                future.cancel()
            wait(futures)
            raise

    def statistics(self) -> dict[str, Any]:
        """Nothing beyond what a job says."""
        return {}
