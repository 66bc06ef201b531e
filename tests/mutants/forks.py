"""Runs of tests in forks of one process, which has imported what no planted bug changes.

Python, pytest, NumPy, SciPy and Numba take longer to start than most tests that find a bug take to
run. A server imports them once, outside of any copy of the project; each of its forks imports
alight and the tests anew, as they are in the files at that moment.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

#: What a fork finds imported: packages of others that alight and its tests use.
THEIRS = (
    "PIL.Image", "hypothesis", "numba", "numpy.testing", "pydantic", "pytest", "pytest_timeout",
    "rich.console", "scipy.integrate", "scipy.stats", "typer.testing", "yaml",
)  # fmt: skip
OURS = ("alight", "lanewise", "tests")

#: Seconds after which a run is stuck: the test around it may take 600.
LIMIT = 570.0


class Forks:
    """A server for the tests of one folder.

    Parameters
    ----------
    folder : Path
        A copy of the project, in which the tests run.
    environment : dict of str to str
        Of the tests.
    """

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self.said = folder / "said.txt"
        # Without the folder of this file in front, in which modules have names of other packages.
        command = [sys.executable, "-P", "-X", "faulthandler", __file__]
        # Without buffers: what is in one cannot be waited for.
        self.server = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            bufsize=0,
        )  # fmt: skip

    def run(self, arguments: list[str], limit: float = LIMIT) -> tuple[int, str]:
        """Run pytest in a fork, and what it starts, to the end.

        Parameters
        ----------
        arguments : list of str
            As on pytest's command line.
        limit : float, optional
            Seconds.

        Returns
        -------
        code : int
            Exit code, or minus the signal that ended it.
        said : str
            What it wrote.

        Raises
        ------
        TimeoutError
            With what it wrote, if it is stuck.
        """
        assert self.server.stdin is not None
        self.server.stdin.write(json.dumps([str(self.said), *arguments]).encode() + b"\n")
        child = int(self._answer(LIMIT))
        try:
            code = int(self._answer(limit))
        except TimeoutError:
            _end_session(child)
            self._answer(LIMIT)
            raise TimeoutError(self.said.read_text("utf-8", "replace")) from None
        return code, self.said.read_text("utf-8", "replace")

    def _answer(self, seconds: float) -> bytes:
        assert self.server.stdout is not None
        if not select.select([self.server.stdout], [], [], seconds)[0]:
            raise TimeoutError
        return self.server.stdout.readline()

    def close(self) -> None:
        """End the server."""
        assert self.server.stdin is not None
        assert self.server.stdout is not None
        self.server.stdin.close()
        self.server.wait(60)
        self.server.stdout.close()


#: Seconds since 1970 at which the files with bugs were written, as they say: each another one, and
#: all long ago. Python compiles a source again if it is of another second than its byte code.
LONG_AGO = count(1)


@contextmanager
def planted(path: Path, text: str) -> Iterator[None]:
    """Have another text in a file."""
    right, times = path.read_text("utf-8"), path.stat()
    try:
        path.write_text(text, "utf-8")
        os.utime(path, (moment := next(LONG_AGO), moment))
        yield
    finally:
        path.write_text(right, "utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def serve() -> None:
    """Answer each line of arguments with a fork's number, and with its exit code at its end."""
    for name in THEIRS:
        importlib.import_module(name)
    _warm_up_numba()
    # What is here stays: no fork is to look through it, which would copy its pages.
    gc.collect()
    gc.freeze()
    assert not any(name.partition(".")[0] in OURS for name in sys.modules)
    assert threading.active_count() == 1
    for line in sys.stdin:
        said, *arguments = json.loads(line)
        child = os.fork()
        if child == 0:
            _run_tests(said, arguments)
        print(child, flush=True)
        status = os.waitpid(child, 0)[1]
        # What a test has started and left ends with it.
        _end_session(child)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _warm_up_numba() -> None:
    """Numba learns what it knows of NumPy when it compiles for the first time."""
    import numba

    numba.njit("float32(float32)")(lambda x: x + x)


def _run_tests(said: str, arguments: list[str]) -> None:
    """Be a process that pytest was started in, in a session of its own."""
    code = 70
    try:
        # A bug that signals its group reaches nobody else.
        os.setsid()
        nothing, log = os.open(os.devnull, os.O_RDONLY), os.open(said, os.O_CREAT | os.O_WRONLY)
        os.truncate(log, 0)
        for own, given in ((0, nothing), (1, log), (2, log)):
            os.dup2(given, own)
        import pytest

        sys.argv = ["pytest", *arguments]
        code = int(pytest.main(arguments))
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _end_session(leader: int) -> None:
    try:
        os.killpg(leader, signal.SIGKILL)
    except ProcessLookupError:
        return


if __name__ == "__main__":
    serve()
