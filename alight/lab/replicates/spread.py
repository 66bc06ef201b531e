"""Replicates of a study on the workers of a cluster: whole ladders, each on one thread.

Pictures have the bits of those that this machine renders. Their times are CPU time of the worker's
thread, and can be compared only among processors of one kind: a study of equal times is refused on
others, any other one is marked.
"""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from alight.cluster.addresses import check_address, connected
from alight.cluster.fork_server import STUDIES
from alight.compiled.scene import CompiledScene
from alight.core.errors import FilmError, OptionError
from alight.films.archive import pack_archive, unpack_archive
from alight.lab.replicates.measure import Rung, render_ladder
from alight.lab.replicates.steering import is_steered, steered_ladder
from alight.rendering.executors.block_tasks import sent
from alight.rendering.tiles.tile import Kernels
from alight.rendering.training.guide_training import is_to_be_guided
from lanewise.machine import processor

if TYPE_CHECKING:
    from alight.lab.arms import Arm
    from alight.options.cluster import ClusterOptions

#: Seconds after which a replicate counts as late, at least, and as a multiple of its expected ones.
_LATE, _TIMES = 60.0, 10.0

#: Bytes of an answer besides its pictures, at most.
_HEADER = 2**16


class Ladder(NamedTuple):
    """One replicate of one arm, along its steps.

    Attributes
    ----------
    arm : int
    seed : int
    ladder : tuple of int
    """

    arm: int
    seed: int
    ladder: tuple[int, ...]

    @property
    def digest(self) -> str:
        """Names arm, seed and ladder."""
        return hashlib.sha256(repr(tuple(self)).encode()).hexdigest()


class SharedArm(NamedTuple):
    """What the replicates of one arm need.

    Attributes
    ----------
    scene : CompiledScene
    kernels : Kernels
        They have run, and travel as object code.
    replicates : int
        Of the film.
    schedule : Any
        The option, or None.
    """

    scene: CompiledScene
    kernels: Kernels
    replicates: int
    schedule: Any


def render_replicate(shared: Sequence[SharedArm], task: Ladder) -> bytes:
    """Render a ladder on the thread that asks, and pack its pictures."""
    arm = shared[task.arm]
    words = arm.scene, arm.kernels, arm.replicates, task.seed, task.ladder, 0
    rungs = list(
        steered_ladder(*words, arm.schedule) if is_steered(arm.schedule) else render_ladder(*words)
    )
    told = [{"spp": r.spp, "seconds": r.seconds, "invalid": r.invalid} for r in rungs]
    content = {"task": task.digest, "rungs": told, "processor": processor()}
    arrays = {str(number): rung.picture for number, rung in enumerate(rungs)}
    return b"".join(pack_archive(content, arrays))


def read_replicate(task: Ladder, size: tuple[int, int], data: Any) -> tuple[list[Rung], str]:
    """Read an answer, and refuse what cannot be one.

    Parameters
    ----------
    task : Ladder
    size : (int, int)
        Width and height of the pictures.
    data : bytes

    Returns
    -------
    list of Rung
    str
        The processor that it was timed on.

    Raises
    ------
    FilmError
    """
    width, height = size
    most = 12 * width * height * len(task.ladder) + _HEADER
    if not isinstance(data, bytes) or len(data) > most:
        raise FilmError("a worker's answer is no bytes, or too long for its pictures")
    try:
        content, arrays = unpack_archive("a worker's answer", memoryview(data))
        if content["task"] != task.digest:
            raise FilmError("a worker's answer is that of another replicate")
        rungs = [
            _rung(told, arrays[str(number)], size) for number, told in enumerate(content["rungs"])
        ]
        if tuple(rung.spp for rung in rungs) != task.ladder:
            raise FilmError("a worker's answer has other steps than its task")
        return rungs, str(content["processor"])
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, FilmError):
            raise
        raise FilmError(f"a worker's answer cannot be read: {error!r}") from error


def _rung(told: Any, picture: np.ndarray, size: tuple[int, int]) -> Rung:
    width, height = size
    if picture.shape != (height, width, 3) or picture.dtype != np.float32:
        raise FilmError(f"a worker's answer has a picture of shape {picture.shape}")
    spp, seconds, invalid = told["spp"], told["seconds"], told["invalid"]
    if not (np.isfinite(picture).all() and seconds >= 0.0 and invalid >= 0):
        raise FilmError("a worker's answer has numbers that no replicate has")
    return Rung(int(spp), float(seconds), picture, int(invalid))


class Spread:
    """The workers that render a study's replicates.

    Parameters
    ----------
    client : distributed.Client
    equal_time : bool
        Whether the study compares arms at equal times.

    Raises
    ------
    OptionError
        If times would be compared among processors of different kinds.
    """

    def __init__(self, client: Any, equal_time: bool) -> None:
        self._client, self._equal_time = client, equal_time
        own = processor()
        found: dict[str, str] = {}
        # A worker that does not answer now, or lacks alight, shows in its answers later.
        with suppress(TimeoutError):
            found = client.sync(client._run, processor, on_error="ignore", callback_timeout=_LATE)
        others = sorted(set(found.values()) - {own})
        if equal_time and others:
            raise OptionError(
                f"equal times are compared among processors of one kind, and this one is {own}, "
                f"others are {', '.join(others)}: take those away, or say equal_time: false",
                "cluster",
            )

    def render(
        self,
        arms: Sequence[Arm],
        tasks: Sequence[Ladder],
        seconds: float,
        take: Callable[[Ladder, list[Rung], str], None],
    ) -> None:
        """Render replicates in any order.

        Parameters
        ----------
        arms : sequence of Arm
            Of one scene.
        tasks : sequence of Ladder
        seconds : float
            That the longest of them should take.
        take : callable
            Takes a task, its pictures and the processor that they were timed on: each task once,
            in this thread.

        Raises
        ------
        OptionError
            If workers would have to compile models that they do not know.
        """
        from alight.cluster.dispatch import Dispatcher, Patience

        for arm in arms:
            if arm.compiled.program.registered and is_to_be_guided(arm.compiled):
                text = "trains guides on its workers, which do not know the models of scripts"
                raise OptionError(f'{text}: render the arm "{arm.spec.name}" here', "cluster")
        shared = [
            SharedArm(
                sent(arm.compiled), arm.kernels, arm.replicates, arm.spec.options.get("schedule")
            )
            for arm in arms
        ]

        def read(task: Ladder, data: Any) -> tuple[list[Rung], str]:
            rungs, name = read_replicate(task, arms[task.arm].size, data)
            if self._equal_time and name != processor():
                raise FilmError(f"a replicate was timed on {name}, others on {processor()}")
            return rungs, name

        def took(task: Ladder, answer: tuple[list[Rung], str], seconds: float) -> None:
            take(task, *answer)

        patience = Patience(task=max(_LATE, _TIMES * seconds), times=_TIMES)
        dispatcher = Dispatcher(self._client, render_replicate, shared, read, patience)
        dispatcher.open()
        waiting = iter(tasks)
        try:
            left = dispatcher.run(
                lambda: next(waiting, None), took, threading.Event(), lambda: None
            )
        finally:
            dispatcher.close()
        # A cluster that is lost leaves the rest to this process.
        for task in (*left, *waiting):
            took(task, read(task, render_replicate(shared, task)), 0.0)


@contextmanager
def spread_over(options: ClusterOptions | None, equal_time: bool) -> Iterator[Spread | None]:
    """The cluster that the options name, or None for the threads of this process.

    Raises
    ------
    OptionError, AlightError
        See `alight.cluster.addresses`.
    """
    if options is None or options.cluster is None:
        yield None
        return
    check_address(options.cluster, options.cluster_keys)
    with connected(options.cluster, options.cluster_keys, (STUDIES,)) as client:
        with suppress(TimeoutError):
            client.wait_for_workers(1, timeout=_LATE)
        yield Spread(client, equal_time)
