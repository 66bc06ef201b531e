"""Whether processes hang, however little of the machine they get: by what they do, not by a clock.

A process that hangs waits for something that does not come, or runs in circles. So the time in
which nothing comes of its work counts only where no thread of it wants a processor, and apart from
that the processor time that is spent meanwhile. Needs the ``/proc`` of Linux.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

#: Seconds in which nothing comes and nobody wants a processor, after which processes hang. Every
#: wait of a client ends sooner.
IDLE = 60.0

#: Seconds of processor time that nothing comes of. Caches may be empty.
SPENT = 300.0

#: Seconds between two looks.
_LOOK = 0.25

#: States of a thread that runs, or would if it could: it waits for a processor, or for a disk.
_BUSY = "RD"

_TICK = 1.0 / os.sysconf("SC_CLK_TCK")


class Hang(Exception):
    """Nothing comes of what processes do."""


class Watch:
    """What processes have done since something came of it last.

    Parameters
    ----------
    done : callable
        Gives a number that grows while something comes.
    pids : callable
        Gives the processes.
    idle, spent : float, optional
        See `IDLE` and `SPENT`.

    Attributes
    ----------
    longest : float
        Most seconds without a result in which nobody wanted a processor.
    """

    def __init__(
        self,
        done: Callable[[], float],
        pids: Callable[[], Iterable[int]],
        idle: float = IDLE,
        spent: float = SPENT,
    ) -> None:
        self._done, self._pids, self._limits = done, pids, (idle, spent)
        self._most, self._idle, self._spent, self.longest = done(), 0.0, 0.0, 0.0
        self._times: dict[int, float] = {}
        self._looked = time.monotonic()

    def look(self) -> None:
        """Look once.

        Raises
        ------
        Hang
            If nothing has come for too long.
        """
        now = time.monotonic()
        threads = [_threads(pid) for pid in self._pids()]
        times = {thread: seconds for found in threads for thread, (_, seconds) in found.items()}
        if (done := self._done()) > self._most:
            self._most, self._idle, self._spent = done, 0.0, 0.0
        else:
            self._spent += sum(times[one] - self._times[one] for one in times.keys() & self._times)
            if not any(state in _BUSY for found in threads for state, _ in found.values()):
                self._idle += now - self._looked
        self._times, self._looked = times, now
        self.longest = max(self.longest, self._idle)
        idle, spent = self._limits
        if self._idle > idle or self._spent > spent:
            raise Hang(f"nothing came: {self._idle:.0f} s idle, {self._spent:.0f} s of processors")

    def until(self, ended: Callable[[], bool]) -> None:
        """Look until something is so.

        Raises
        ------
        Hang
            See `look`.
        """
        while not ended():
            self.look()
            time.sleep(_LOOK)


def _threads(pid: int) -> dict[int, tuple[str, float]]:
    """State and processor time of each thread of a process that may be gone."""
    found = {}
    with suppress(OSError):
        for thread in Path(f"/proc/{pid}/task").iterdir():
            with suppress(OSError):
                # The name, in parentheses, may hold anything.
                words = (thread / "stat").read_text().rpartition(")")[2].split()
                found[int(thread.name)] = words[0], _TICK * (int(words[11]) + int(words[12]))
    return found
