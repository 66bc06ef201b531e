"""What a cluster consists of, for people."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from http.client import HTTPException
from typing import Any, NamedTuple
from urllib.error import HTTPError
from urllib.request import ProxyHandler, build_opener

from alight.cluster.issues import Patience
from alight.cluster.worker import machine_here, state_here
from lanewise.machine import NATIVE, differing

#: Seconds to wait for one worker's answer, as renders do, and how many are queried at a time.
_WAIT, _AT_A_TIME = Patience.fetch, 16

#: Seconds to wait for a page of the scheduler.
_PAGE = 2.0


@dataclass(frozen=True, kw_only=True)
class WorkerStatus:
    """One worker.

    Attributes
    ----------
    address : str
    threads, tasks : int
        Tasks that it runs or that wait in it.
    memory : int
        Bytes that its process holds.
    kind : str
        Its processor.
    rate : float
        Samples per second in the last minute, for all clients.
    trouble : str
        Why this machine's renders get nothing from it; empty where they do.
    """

    address: str
    threads: int
    tasks: int
    memory: int
    kind: str
    rate: float
    trouble: str

    def __str__(self) -> str:
        """One line."""
        threads = "1 thread" if self.threads == 1 else f"{self.threads} threads"
        tasks = "1 task" if self.tasks == 1 else f"{self.tasks} tasks"
        line = (
            f"{self.address}  {threads}, {self.kind or 'unknown kind'}, {self.rate / 1e6:.2f} "
            f"Msamples/s, {self.memory / 2**20:.0f} MiB, {tasks}"
        )
        return f"{line}, refused: {self.trouble}" if self.trouble else line


class Losses(NamedTuple):
    """What a cluster has lost since its scheduler was started.

    Attributes
    ----------
    workers : int
        That left unasked.
    tasks : int
        That were theirs, and that others then ran.
    """

    workers: int
    tasks: int


def losses_of(client: Any) -> Losses:
    """Ask the scheduler, which remembers its last events."""
    gone = [
        event for _, event in client.get_events("all")
        if isinstance(event, dict) and event.get("action") == "remove-worker"
        and not event.get("expected")
    ]  # fmt: skip
    return Losses(len(gone), sum(len(event.get("processing-tasks", ())) for event in gone))


def dashboard_of(client: Any) -> str | None:
    """Address of Dask's pages about the cluster, if it has any.

    A scheduler without a dashboard has a web server all the same. One that cannot be reached from
    here may be reached through a tunnel.
    """
    if "dashboard" not in client.scheduler_info(n_workers=0).get("services", {}):
        return None
    link: str = client.dashboard_link
    # Not through a proxy.
    pages = build_opener(ProxyHandler({}))
    with suppress(OSError, HTTPException):
        try:
            pages.open(link, timeout=_PAGE).close()
        except HTTPError as error:
            error.close()
            return None if error.code == HTTPStatus.NOT_FOUND else link
    return link


def workers_of(client: Any, target: str = NATIVE) -> list[WorkerStatus]:
    """Ask the scheduler of a `distributed.Client`, and each worker what machine it is.

    Parameters
    ----------
    client : distributed.Client
    target : str
        Of the renders that a worker may be of no use for.
    """
    known = client.scheduler_info(n_workers=-1)["workers"]
    held = client.processing()

    def ask(address: str) -> WorkerStatus:
        about, kind, rate = known[address], "", 0.0
        try:
            machine, kind, rate = client.sync(
                client._run, state_here, target, workers=[address], callback_timeout=_WAIT
            )[address]
            trouble = "; ".join(differing(machine, machine_here(target)))
        except TimeoutError:
            trouble = "it does not answer"
        except Exception as error:
            trouble = f"{type(error).__name__}: {error}"
        memory = int(about.get("metrics", {}).get("memory", 0))
        tasks = len(held.get(address, ()))
        return WorkerStatus(
            address=address, threads=about["nthreads"], tasks=tasks, memory=memory, kind=kind,
            rate=rate, trouble=trouble,
        )  # fmt: skip

    with ThreadPoolExecutor(_AT_A_TIME) as pool:
        return list(pool.map(ask, sorted(known)))
