"""Ctrl-C in a terminal reaches every process there: a worker leaves it to the client."""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(_worker: Any) -> None:
    """Ignore the interrupt: Dask calls this in the process of a worker that preloads the module.

    The client stops at its next look, keeps what has been answered and closes its workers; one that
    stopped by itself would print a traceback, and be started again.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
