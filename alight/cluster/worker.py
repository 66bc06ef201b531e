"""What runs in a worker's process: it keeps what tasks share, and answers one task after another.

What tasks share reaches a worker once; a worker that comes later, or is started again, is given it
by the scheduler before its first task. Renders that share the same, of one client or of several,
each send it under a name of their own: the first that ends takes nothing from the others.
"""

from __future__ import annotations

import hashlib
import threading
import time
import uuid
from collections import OrderedDict, deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from distributed import WorkerPlugin, get_worker

from alight.cluster.shared_file import forget, mapped, packed, unpacked
from lanewise.machine import describe_machine, fingerprint, processor

#: Objects that a process keeps unpickled; the one that was used last of all goes first.
KEPT = 2

#: Seconds of which a worker knows how fast it was.
_LATELY = 60.0

#: When a task was finished, and its samples.
_finished: deque[tuple[float, float]] = deque(maxlen=4096)

_kept: OrderedDict[str, Any] = OrderedDict()
_lock = threading.Lock()


class Answer(NamedTuple):
    """What a worker gives back.

    Attributes
    ----------
    worker : str
        Its address.
    seconds : float
        That the task took.
    value : object
    """

    worker: str
    seconds: float
    value: Any


class Refusal(NamedTuple):
    """A worker would give other bits.

    Attributes
    ----------
    worker : str
        Its address.
    machine : dict of str to str
        See `lanewise.machine.describe_machine`.
    """

    worker: str
    machine: dict[str, str]


class Lack(NamedTuple):
    """A worker has not been given what the task shares with others.

    Attributes
    ----------
    worker : str
        Its address.
    """

    worker: str


class SharedName(NamedTuple):
    """How a task calls what it shares with others; see `Shared`."""

    name: str
    digest: str


class Shared(WorkerPlugin):
    """An object that all tasks use, as each worker keeps it.

    Parameters
    ----------
    thing : object
        Picklable.

    Attributes
    ----------
    digest : str
        SHA-256 of `data`.
    name : str
        Of no other object, however equal.
    called : SharedName
    data : bytes or mmap
        The latter in a worker, see `alight.cluster.shared_file`.
    """

    idempotent = True

    def __init__(self, thing: Any) -> None:
        self.data: Any = packed(thing)
        self.digest = hashlib.sha256(self.data).hexdigest()
        self.name = f"alight-{self.digest[:16]}-{uuid.uuid4().hex}"
        self.called = SharedName(self.name, self.digest)

    def setup(self, worker: Any) -> None:
        """Share the memory of the machine's other workers."""
        self._folder = Path(worker.local_directory).parent
        self.data = mapped(self._folder, self.digest, self.data)

    def teardown(self, worker: Any) -> None:
        """Leave no file behind."""
        forget(self._folder, self.digest)


async def receive(shared: Shared, dask_worker: Any) -> None:
    """Take what did not reach this worker when the others were given it."""
    if shared.name not in dask_worker.plugins:
        await dask_worker.plugin_add(plugin=shared, name=shared.name)


class Asked(NamedTuple):
    """What the bits of answers are promised for.

    Attributes
    ----------
    target : str
        Of the code, see `lanewise.machine.TARGETS`.
    fingerprint : str
        Of the client, for this target.
    """

    target: str
    fingerprint: str


def machine_here(target: str) -> dict[str, str]:
    """Describe this process for a target; of alight, so that its sources are in what counts."""
    return describe_machine(target)


def state_here(target: str) -> tuple[dict[str, str], str, float]:
    """`machine_here`, the kind of processor, and `samples_per_second`."""
    return machine_here(target), processor(), samples_per_second()


def perform(
    function: Callable[[Any, Any], Any], shared: SharedName, asked: Asked, task: Any
) -> Answer | Refusal | Lack:
    """Run a task: `function` of the shared object and the task.

    Parameters
    ----------
    function : callable
        Of a module, so that it travels by its name.
    shared : SharedName
    asked : Asked
    task : object
    """
    address = get_worker().address
    if fingerprint(asked.target) != asked.fingerprint:
        return Refusal(address, machine_here(asked.target))
    if shared.name not in get_worker().plugins:
        return Lack(address)
    thing, begin = _thing(shared), time.perf_counter()
    value = function(thing, task)
    _finished.append((time.monotonic(), getattr(task, "samples", 0.0)))
    return Answer(address, time.perf_counter() - begin, value)


def samples_per_second() -> float:
    """Of this process, in the last minute."""
    since = time.monotonic() - _LATELY
    return sum(samples for when, samples in list(_finished) if when > since) / _LATELY


def _thing(shared: SharedName) -> Any:
    name, digest = shared
    with _lock:
        if digest not in _kept:
            plugin: Any = get_worker().plugins[name]
            if hashlib.sha256(plugin.data).hexdigest() != digest:
                raise ValueError("what tasks share has arrived with other bytes than were sent")
            _kept[digest] = unpacked(plugin.data)
        _kept.move_to_end(digest)
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
        return _kept[digest]
