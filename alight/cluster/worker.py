"""What runs in a worker's process: it keeps what tasks share, and answers one task after another.

What tasks share reaches a worker once, by its digest; a worker that comes later, or is started
again, is given it by the scheduler before its first task.
"""

from __future__ import annotations

import hashlib
import pickle
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, NamedTuple

from distributed import WorkerPlugin, get_worker

from lanewise.machine import describe_machine, fingerprint

#: Objects that a process keeps unpickled; the one that was used last of all goes first.
KEPT = 2

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
    data : bytes
    """

    idempotent = True

    def __init__(self, thing: Any) -> None:
        self.data = pickle.dumps(thing, protocol=5)
        self.digest = hashlib.sha256(self.data).hexdigest()
        self.name = _name(self.digest)


def _name(digest: str) -> str:
    return f"alight-{digest}"


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


def perform(
    function: Callable[[Any, Any], Any], digest: str, asked: Asked, task: Any
) -> Answer | Refusal:
    """Run a task: `function` of the shared object and the task.

    Parameters
    ----------
    function : callable
        Of a module, so that it travels by its name.
    digest : str
        Of the `Shared` object.
    asked : Asked
    task : object
    """
    address = get_worker().address
    if fingerprint(asked.target) != asked.fingerprint:
        return Refusal(address, machine_here(asked.target))
    thing, begin = _shared(digest), time.perf_counter()
    value = function(thing, task)
    return Answer(address, time.perf_counter() - begin, value)


def _shared(digest: str) -> Any:
    with _lock:
        if digest not in _kept:
            shared: Any = get_worker().plugins[_name(digest)]
            if hashlib.sha256(shared.data).hexdigest() != digest:
                raise ValueError("what tasks share has arrived with other bytes than were sent")
            _kept[digest] = pickle.loads(shared.data)
        _kept.move_to_end(digest)
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
        return _kept[digest]
