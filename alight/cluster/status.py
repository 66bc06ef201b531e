"""What a cluster consists of, for people."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

from alight.cluster.worker import machine_here
from lanewise.machine import NATIVE, differing

#: Seconds for which one worker's answer is waited for, and how many are asked at a time.
_WAIT, _AT_A_TIME = 5.0, 16


class WorkerStatus(NamedTuple):
    """One worker.

    Attributes
    ----------
    address : str
    threads, tasks : int
        Tasks that it runs or that wait in it.
    memory : int
        Bytes that its process holds.
    trouble : str
        Why this machine's renders get nothing from it; empty where they do.
    """

    address: str
    threads: int
    tasks: int
    memory: int
    trouble: str

    def __str__(self) -> str:
        """One line."""
        threads = "1 thread" if self.threads == 1 else f"{self.threads} threads"
        line = f"{self.address}  {threads}, {self.memory / 2**20:.0f} MiB, {self.tasks} tasks"
        return f"{line}, refused: {self.trouble}" if self.trouble else line


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
        about = known[address]
        try:
            machine = client.sync(
                client._run, machine_here, target, workers=[address], callback_timeout=_WAIT
            )[address]
            trouble = "; ".join(differing(machine, machine_here(target)))
        except TimeoutError:
            trouble = "it does not answer"
        except Exception as error:
            trouble = f"{type(error).__name__}: {error}"
        memory = int(about.get("metrics", {}).get("memory", 0))
        tasks = len(held.get(address, ()))
        return WorkerStatus(address, about["nthreads"], tasks, memory, trouble)

    with ThreadPoolExecutor(_AT_A_TIME) as pool:
        return list(pool.map(ask, sorted(known)))
