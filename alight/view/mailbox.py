"""Messages on their way to one browser: of each kind only the newest waits.

A state is never ahead of the pictures that were there when it was written: a page that is told that
all is done has seen it.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

#: Answers that wait at most; a browser that asks faster than it listens misses the oldest.
MOST_ANSWERS = 64

#: What is sent after all else that waits.
STATE = "state"


class Mailbox:
    """What a browser has not been sent yet; any thread may post, the loop that made it sends."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._newest: dict[str, str | bytes] = {}
        self._answers: deque[str] = deque(maxlen=MOST_ANSWERS)
        self._due: deque[str | bytes] = deque()
        self._news = asyncio.Event()

    def post(self, kind: str, message: str | bytes) -> None:
        """Send a message, in place of an older one of its kind that has not been sent yet."""
        self._soon(lambda: self._newest.update({kind: message}))

    def answer(self, message: str) -> None:
        """Send a message of which each counts."""
        self._soon(lambda: self._answers.append(message))

    def _soon(self, put: Callable[[], object]) -> None:
        def do() -> None:
            put()
            self._news.set()

        # A loop that has ended has no browser to tell.
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(do)

    async def next(self) -> str | bytes:
        """Wait for what is to be sent next."""
        while not (self._answers or self._due or self._newest):
            self._news.clear()
            await self._news.wait()
        if self._answers:
            return self._answers.popleft()
        if not self._due:
            # All at once: one by one, a slow browser would be sent pictures and never a state.
            self._due += [self._newest[kind] for kind in sorted(self._newest, key=STATE.__eq__)]
            self._newest.clear()
        return self._due.popleft()
