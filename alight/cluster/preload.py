"""What a worker of ``local:N`` leaves to its client, from its start on."""

from __future__ import annotations

import logging
import signal
from typing import Any

#: Dask's words, and a traceback, for a scheduler that has ended while a worker reported to it.
_HEARTBEAT_LOST = "Failed to communicate with scheduler during heartbeat"


def dask_setup(_worker: Any) -> None:
    """Dask calls this in the process of a worker that preloads the module.

    Ctrl-C in a terminal reaches every process there. The client stops at its next look, keeps what
    has been answered and closes its workers; one that stopped by itself would print a traceback,
    and be started again.

    Nor is it a worker's to complain of a scheduler that is gone: mostly the render has ended, and
    the client says so where it has not.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("distributed.worker").addFilter(_is_relevant)


def _is_relevant(record: logging.LogRecord) -> bool:
    return not record.getMessage().startswith(_HEARTBEAT_LOST)
