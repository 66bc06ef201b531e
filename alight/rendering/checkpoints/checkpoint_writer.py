"""When checkpoints are written: at the start, from time to time in the background, at the end.

Rendering waits only while the films are copied. If writing fails, rendering continues: the last
checkpoint that was written stays as it is, the failure is logged, and the next one is tried.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from pathlib import Path
from typing import Any

from alight.core.errors import OutputError
from alight.outputs.atomic import check_folder, remove_abandoned
from alight.rendering.checkpoints.checkpoint import Origin, write_checkpoint
from alight.rendering.job import Job, JobState

_LOG = logging.getLogger("alight")


class CheckpointWriter:
    """Writes the state of one job to one file.

    Parameters
    ----------
    path : path
    every : float, seconds
        Between two checkpoints; 0 writes without a pause.
    origin : Origin
        What goes into every checkpoint besides the state.

    Attributes
    ----------
    failure : OutputError or None
        Why the newest checkpoint could not be written.
    """

    def __init__(self, path: str | os.PathLike[str], every: float, origin: Origin) -> None:
        check_folder(path)
        # What a render that was killed while it wrote has left.
        remove_abandoned(Path(os.path.realpath(path)).parent)
        self.path, self.every, self.origin = path, every, origin
        self.failure: OutputError | None = None
        self._thread: threading.Thread | None = None
        self._last = time.perf_counter()
        self._count = self._bytes = 0
        self._seconds = self._stalled = 0.0

    def write(self, state: JobState) -> None:
        """Write now, in this thread.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        begin = time.perf_counter()
        self._bytes = write_checkpoint(self.path, state, self.origin)
        self._count += 1
        self._seconds += time.perf_counter() - begin
        self.failure = None

    def tick(self, job: Job) -> None:
        """Begin to write a checkpoint if it is time; never waits for the disk."""
        begin = time.perf_counter()
        busy = self._thread is not None and self._thread.is_alive()
        if busy or begin - self._last < self.every:
            return
        self._last = begin
        try:
            state = job.state()
        except MemoryError:
            self._failed(OutputError(f"cannot write {self.path}: no memory to copy the film"))
            return
        self._thread = threading.Thread(target=self._try, args=(state,), daemon=True)
        self._thread.start()
        self._stalled += time.perf_counter() - begin

    def finish(self, job: Job) -> None:
        """Write the last state, and wait for it."""
        if self._thread is not None:
            self._thread.join()
        begin = time.perf_counter()
        self._try(job.state(copy=False))
        self._stalled += time.perf_counter() - begin

    def _try(self, state: JobState) -> None:
        try:
            self.write(state)
        except OutputError as error:
            self._failed(error)
        except MemoryError:
            self._failed(OutputError(f"cannot write {self.path}: not enough memory"))

    def _failed(self, error: OutputError) -> None:
        # The same message every minute would bury all others.
        if str(error) != str(self.failure):
            _LOG.warning("%s; the checkpoint before is untouched, rendering continues", error)
        self.failure = error

    def statistics(self) -> dict[str, Any]:
        """Number, size and times of the checkpoints, and the last failure."""
        return {
            "file": os.fspath(self.path),
            "written": self._count,
            "bytes": self._bytes,
            "seconds_each": self._seconds / max(self._count, 1),
            "seconds_stalled": self._stalled,
            "failure": None if self.failure is None else str(self.failure),
        }
