"""Ctrl-C and SIGTERM end a render cleanly: everything rendered so far is kept."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from alight.cli.progress import ProgressBar

#: Ctrl-C, and what `kill`, batch systems and a system that shuts down send.
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interruption:
    """Which signal came, if any.

    Attributes
    ----------
    exit_code : int
        128 + the signal's number, as shells expect; 130 if there was none.
    """

    def __init__(self) -> None:
        self.exit_code = 128 + signal.SIGINT


@contextmanager
def cancelling(cancel: threading.Event, bar: ProgressBar) -> Iterator[Interruption]:
    """Let the first signal while rendering set `cancel`; others interrupt at once."""
    interruption = Interruption()

    def on_signal(number: int, frame: Any) -> None:
        interruption.exit_code = 128 + number
        if cancel.is_set() or bar.phase != "render":
            raise KeyboardInterrupt
        cancel.set()

    if threading.current_thread() is not threading.main_thread():
        # Only the main thread may set handlers.
        yield interruption
        return
    before = [signal.signal(number, on_signal) for number in SIGNALS]
    try:
        yield interruption
    finally:
        for number, handler in zip(SIGNALS, before, strict=True):
            signal.signal(number, handler)
