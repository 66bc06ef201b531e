"""A network namespace of Linux with one cable to this machine, which can be pulled out.

Needs the rights of root and the program ``ip``; nothing outside the namespace is changed but a
link that goes with it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from contextlib import suppress


class Namespace:
    """Where a worker can be cut off from everybody else.

    Attributes
    ----------
    here, there : str
        Addresses of the two ends of the cable.
    """

    def __init__(self) -> None:
        number = os.getpid()
        self.name, self._link = f"alight-{number}", f"al{number % 10**8}"
        net = f"10.213.{number % 256}"
        self.here, self.there = f"{net}.1", f"{net}.2"
        _ip("netns", "add", self.name)
        try:
            _ip(
                "link", "add", self._link, "type", "veth", "peer", "name", "end", "netns", self.name
            )
            _ip("address", "add", f"{self.here}/30", "dev", self._link)
            _ip("-n", self.name, "address", "add", f"{self.there}/30", "dev", "end")
            for words in (("link", "set", "lo", "up"), ("link", "set", "end", "up")):
                _ip("-n", self.name, *words)
            self.mend()
        except BaseException:
            self.end()
            raise

    @property
    def words(self) -> list[str]:
        """What a command line in there begins with."""
        return ["ip", "netns", "exec", self.name]

    def cut(self) -> None:
        """Lose all that is sent from now on, without a word to anybody."""
        _ip("link", "set", self._link, "down")

    def mend(self) -> None:
        """Let it through again."""
        _ip("link", "set", self._link, "up")

    def end(self) -> None:
        """Remove it, and the cable."""
        with suppress(subprocess.CalledProcessError):
            _ip("netns", "delete", self.name)


def namespace_here() -> Namespace | None:
    """One where that is possible, or None."""
    if shutil.which("ip") is None or os.geteuid() != 0:
        return None
    try:
        return Namespace()
    except (OSError, subprocess.CalledProcessError):
        return None


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True)
