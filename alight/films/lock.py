"""The lock of a film, which copies of the film do not share."""

from __future__ import annotations

import threading


class FilmLock:
    """A lock that one thread may take several times; pickled and copied as a new one."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        """Wait until no other thread has it."""
        self._lock.acquire()

    def __exit__(self, *raised: object) -> None:
        """Let the next one have it."""
        self._lock.release()

    def __reduce__(self) -> tuple[type[FilmLock], tuple[()]]:
        """Make a new one: the copy of a film belongs to nobody yet."""
        return FilmLock, ()
