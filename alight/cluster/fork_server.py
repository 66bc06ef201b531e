"""The process that workers of ``local:N`` are forked from, which imports what they need, once.

It takes as long for it as a render does for its own imports, so it is started as soon as it is
known to be needed: both import at the same time.
"""

from __future__ import annotations

import multiprocessing
import re
import signal
from collections.abc import Iterable
from importlib.util import find_spec
from typing import Any

#: What a command names, so that nothing heavy is imported to name it.
RENDERS, STUDIES = "alight.rendering.executors.cluster_executor", "alight.lab.replicates.spread"

#: What every worker imports, and Dask's own list for a server of forks leaves out.
_PRELOADED = ("distributed", "distributed.nanny", "distributed.worker", "alight.cluster.worker")


def can_fork() -> bool:
    """Whether this system has servers of forks."""
    return "forkserver" in multiprocessing.get_all_start_methods()


def preloaded(modules: Iterable[str]) -> list[str]:
    """All that the server imports before its first fork."""
    return [*_PRELOADED, *modules]


def start_fork_server(where: Any, module: str) -> None:
    """Start it if an address is ``local:N``, and go on at once.

    An address or an installation that is wrong is left to `alight.cluster.addresses`.

    Parameters
    ----------
    where : str or distributed.Client or None
        As an option gives it.
    module : str
        One of `RENDERS` and `STUDIES`.
    """
    is_local = isinstance(where, str) and re.fullmatch(r"local:[1-9][0-9]{0,3}", where)
    if not is_local or not can_fork() or find_spec("distributed") is None:
        return
    from multiprocessing import forkserver, resource_tracker

    multiprocessing.get_context("forkserver").set_forkserver_preload(preloaded([module]))
    # Starting the tracker unblocks interrupts, so it goes first.
    resource_tracker.ensure_running()
    # Ctrl-C reaches the server, too, which would print where in its imports it was.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
