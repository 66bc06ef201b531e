"""The lock of a film, which copies of the film do not share."""

from __future__ import annotations

import threading


class FilmLock:
    """A lock that one thread may take several times; pickled and copied as a new one.

    Attributes
    ----------
    acquire, release : callable
        Those of `threading.RLock`.
    """

    def __init__(self) -> None:
        lock = threading.RLock()
        self.acquire, self.release = lock.acquire, lock.release

    def __enter__(self) -> None:
        """Wait until no other thread has it."""
        self.acquire()

    def __exit__(self, *raised: object) -> None:
        """Let the next one have it."""
        self.release()

    def __reduce__(self) -> tuple[type[FilmLock], tuple[()]]:
        """Make a new one: the copy of a film belongs to nobody yet."""
        return FilmLock, ()
