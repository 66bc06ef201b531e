"""The executor of a cluster: blocks go out as tasks of some seconds, exact sums come back."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager
from os import PathLike
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from alight.cluster.addresses import check_address, connected, processes_of
from alight.cluster.fork_server import RENDERS
from alight.films import PartialFilm
from alight.integrators.walk import Settings
from alight.rendering.executors.block_tasks import (
    SHARES,
    BlockTask,
    Layout,
    SharedScene,
    read_blocks,
    render_blocks,
    samples_in,
    sent,
)
from alight.rendering.executors.blocks import Add, Block, Threads
from alight.rendering.executors.light_tasks import (
    LightQueue,
    LightTask,
    read_light_sums,
    render_light_task,
)
from alight.rendering.tiles.tile_kernel import Tile
from lanewise.machine import describe_machine

if TYPE_CHECKING:
    from alight.cluster.issues import Patience
    from alight.options.cluster import ClusterOptions
    from alight.rendering.job import Job

T = TypeVar("T", bound="ClusterOptions")

#: Seconds of a task while there is much to do, and of the last ones at least. A task costs the
#: scheduler some milliseconds.
LONGEST, SHORTEST = 2.0, 0.1

#: Samples per second of a thread, until that is measured.
_SPEED = 1e5

#: What progress says of tasks, where there is any.
_TOLD = ("done here", "failed", "issued again")

#: A pass of a render with a time limit.
_TIMED_PASS = 20.0


class ClusterExecutor:
    """Renders the blocks of a job on the workers of a Dask cluster.

    Parameters
    ----------
    where : str or distributed.Client
    keys : path, optional
        See `alight.cluster.addresses.check_address`.
    patience : Patience, optional

    Raises
    ------
    OptionError
        If the address is none, or there is no Dask.
    """

    def __init__(
        self, where: Any, keys: str | PathLike[str] | None = None, patience: Patience | None = None
    ) -> None:
        check_address(where, keys)
        self._where, self._keys, self._patience = where, keys, patience
        self._stack, self._speed, self._bytes = ExitStack(), _SPEED, 0
        self._lock, self._client = threading.Lock(), Future[Any]()
        self._threads: Threads | None = None

    def __enter__(self) -> Self:
        """Connect; processes of this machine start while the client compiles."""
        found = connected(self._where, self._keys, (RENDERS,))
        if isinstance(self._where, str) and processes_of(self._where):
            thread = self._stack.enter_context(ThreadPoolExecutor(1))
            self._client = thread.submit(self._stack.enter_context, found)
        else:
            self._client.set_result(self._stack.enter_context(found))
        return self

    def __exit__(self, *raised: object) -> None:
        """Disconnect; processes that were started for this render end."""
        try:
            # A render that fails before it begins ends what is still starting, too.
            wait([self._client])
        finally:
            self._stack.close()

    @property
    def machine(self) -> Mapping[str, str]:
        """That of this process: workers whose samples would have other bits are refused."""
        return describe_machine()

    def check(self, job: Job) -> None:
        """Workers render all that threads do."""

    def begin(self, job: Job) -> None:
        """Send the scene and its kernels to the workers.

        Raises
        ------
        AlightError
            If there are no workers.
        """
        client = self._client.result()
        from alight.cluster.dispatch import Dispatcher

        self._job = job
        film = job.rounds[0]
        layers = {name: film.aov_channels[name] for name in film.aov_sums}
        surfaces = len(film.coverage.names) if film.coverage else None
        layout = Layout(film.replicates, len(film.channels), layers, surfaces)

        def read(task: Any, data: Any) -> Any:
            with self._lock:
                self._bytes += len(data)
            if job.splats:
                return read_light_sums(layout.channels, task, data)
            return read_blocks(layout, task, data)

        shared = SharedScene(sent(job.scene), job.settings, job.kernels)
        render = render_light_task if job.splats else render_blocks
        self._dispatcher = Dispatcher(client, render, shared, read, self._patience)
        self._stack.callback(self._dispatcher.close)
        self._dispatcher.open()

    @property
    def is_shared(self) -> bool:
        """Tasks, which hold several tiles, are what workers wait for."""
        return False

    @property
    def adds_whole_samples(self) -> bool:
        """Light paths are added window by window; see `alight.rendering.executors.light_tasks`."""
        return True

    @property
    def note(self) -> str:
        """Workers that have answered, and what had to be done again."""
        dispatcher = self._dispatcher
        if self._threads:
            return "cluster lost"
        parts = [f"{len(dispatcher.workers)} workers"]
        parts += [f"{n} {name}" for name, n in sorted(dispatcher.counts.items()) if name in _TOLD]
        return ", ".join(parts)

    @property
    def pass_seconds(self) -> float:
        """Without an end where no time limit is: answers come all the time."""
        return math.inf if self._job.time_limit is None else _TIMED_PASS

    def render(
        self,
        settings: Settings,
        blocks: Sequence[Block],
        add: Add,
        cancel: threading.Event,
        report: Callable[[], None],
    ) -> None:
        """Render blocks on the workers; if the cluster is lost, here. See `Executor`."""
        queue = self._queue(settings.seed, blocks)

        def draw() -> BlockTask | LightTask | None:
            threads = 0 if self._threads else self._dispatcher.threads
            return queue.cut(self._speed, threads)

        def take(task: Any, sums: Any, seconds: float) -> None:
            rate = task.samples / max(seconds, 1e-6)
            self._speed += 0.3 * (rate - self._speed)
            queue.take(task, sums, add)

        left: Sequence[Any] = ()
        if self._threads is None:
            left = self._dispatcher.run(draw, take, cancel, report)
            if cancel.is_set():
                return
        rest = queue.rest(left)
        if rest:
            self._here().render(settings, rest, add, cancel, report)

    def _queue(self, seed: int, blocks: Sequence[Block]) -> BlockQueue | LightQueue:
        job = self._job
        if not job.splats:
            return BlockQueue(blocks, seed)
        x, y, width, height = job.rounds[0].crop
        return LightQueue(blocks, Tile(x, y, x + width, y + height), job.replicates, seed)

    def _here(self) -> Threads:
        if self._threads is None:
            self._threads = self._stack.enter_context(Threads())
            self._threads.begin(self._job)
        return self._threads

    def statistics(self) -> dict[str, Any]:
        """Tasks, bytes and workers, as ``cluster``."""
        dispatcher = self._dispatcher
        counts = {name.replace(" ", "_"): n for name, n in sorted(dispatcher.counts.items())}
        workers = {name: dict(of) for name, of in sorted(dispatcher.workers.items())}
        return {"cluster": {**counts, "bytes": self._bytes, "workers": workers,
                            "refused": dispatcher.refused}}  # fmt: skip


class BlockQueue:
    """Blocks that no task has yet.

    Parameters
    ----------
    blocks : sequence of Block
    seed : int
        Of the film.
    """

    def __init__(self, blocks: Sequence[Block], seed: int) -> None:
        #: From the last one to the next one.
        self._blocks, self._seed = list(reversed(blocks)), seed
        self._left = sum(map(samples_in, blocks))

    def cut(self, speed: float, threads: int) -> BlockTask | None:
        """Take blocks, or a share of the samples of one, for one task; None at the end.

        Parameters
        ----------
        speed : float
            Samples per second of a thread.
        threads : int
            That share what is left.
        """
        seconds = self._left / (speed * max(threads, 1) * SHARES)
        room = speed * min(max(seconds, SHORTEST), LONGEST)
        found: list[Block] = []
        while self._blocks and (
            room > 0.0 if not found else room > 0.5 * samples_in(self._blocks[-1])
        ):
            block = self._blocks.pop()
            share = room / samples_in(block)
            if share < 0.67 and block.ranges[..., 1].max() > 1:
                block, rest = split(block, share)
                if samples_in(rest):
                    self._blocks.append(rest)
            found.append(block)
            room -= samples_in(block)
        self._left -= sum(map(samples_in, found))
        return BlockTask(self._seed, tuple(found)) if found else None

    def take(self, task: BlockTask, value: Sequence[tuple[PartialFilm, int]], add: Add) -> None:
        """Add an answer."""
        for partial, rays in value:
            add(partial, rays)

    def rest(self, tasks: Sequence[BlockTask]) -> list[Block]:
        """Blocks of tasks that are not answered, and those that no task has."""
        return [block for task in tasks for block in task.blocks] + self._blocks


def split(block: Block, share: float) -> tuple[Block, Block]:
    """Cut off a share of the samples of each cell, rounded up: the first of them."""
    first, count = block.ranges[..., 0], block.ranges[..., 1]
    taken = np.minimum(np.ceil(share * count).astype(np.int64), count)
    head = np.stack([first, taken], axis=-1)
    rest = np.stack([first + taken, count - taken], axis=-1)
    return Block(block.tile, head), Block(block.tile, rest)


@contextmanager
def joined(options: T) -> Iterator[T]:
    """Options of several renders, whose cluster stays from the first to the last.

    Raises
    ------
    OptionError, AlightError
        See `alight.cluster.addresses`.
    """
    if options.cluster is None:
        yield options
        return
    check_address(options.cluster, options.cluster_keys)
    with connected(options.cluster, options.cluster_keys, (RENDERS,)) as client:
        yield options.changed(cluster=client, cluster_keys=None)
