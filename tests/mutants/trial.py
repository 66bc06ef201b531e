"""Trying slips on the suite without starting Python, collecting tests or compiling for each.

The tests of a copy of the project are imported and collected once. For each slip this process
forks; the child gives the functions of the slip's file their new code and runs the tests that it is
told until one fails. Machine code is kept under a digest of the kernel's own text, so those that a
slip does not touch are compiled once in a campaign.
"""

from __future__ import annotations

import gc
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

#: Added to `lanewise.jit` in the copy.
BY_TEXT = '''

def _by_text(root, program=None, *, compiled=True, plain=instantiate, **words):
    """Machine code is named by the text that it is made of."""
    made = plain(root, program, compiled=compiled, **words)
    if compiled and hasattr(made, "identity"):
        from lanewise.source_digest import _Reader

        text = _PythonBuild(program, lambda node, made: made).get(root)
        reader = _Reader({"alight", "lanewise", text.__module__.split(".")[0]}, set())
        reader.feed({"root": text})
        made.identity += reader.hash.hexdigest()
    return made


instantiate = _by_text
'''

#: Added to `lanewise.machine_code`.
ONE_FOLDER = '''

def cache_folder():
    """One for all slips."""
    import os

    return Path(os.environ["KERNELS_OF_THE_CAMPAIGN"])
'''

#: Tests that looked at the working tree instead would prove nothing.
CONFTEST = """
from pathlib import Path

import alight

assert Path(alight.__file__).is_relative_to(Path(__file__).parent)
"""


#: What is imported from the copy.
PACKAGES = ("alight", "lanewise", "tests")


class Result(NamedTuple):
    """What came of some tests.

    Attributes
    ----------
    verdict : {"passed", "failed", "died", "unfinished"}
    test : str
        The one that failed or in which the process died.
    says : str
        The beginning of the failure.
    durations : dict
        Processor seconds of each test that ended.
    seconds : float
        Processor seconds of the whole, up to that end.
    """

    verdict: str
    test: str
    says: str
    durations: dict[str, float]
    seconds: float


def copy_project(root: Path, folder: Path) -> Path:
    """A copy of the package, its tests and what they read, for `serve`."""
    shutil.rmtree(folder, ignore_errors=True)
    ignored = shutil.ignore_patterns("__pycache__", "mutants")
    for name in ("alight", "lanewise", "tests", "docs", "benchmarks", "examples"):
        if (root / name).is_dir():
            shutil.copytree(root / name, folder / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(root / name, folder)
    (folder / "conftest.py").write_text(CONFTEST)
    for file, text in (("jit", BY_TEXT), ("machine_code", ONE_FOLDER)):
        path = folder / "lanewise" / f"{file}.py"
        path.write_text(path.read_text("utf-8") + text, "utf-8")
    return folder


def serve(
    folder: Path, kernels: Path, left_out: list[str], campaign: Callable[[Trial], None]
) -> None:
    """Collect the tests of a copy and hand a `Trial` to `campaign`."""
    kernels.mkdir(parents=True, exist_ok=True)
    # For what slips, and processes that are killed, leave behind.
    left = folder / "left"
    left.mkdir()
    tempfile.tempdir = None
    os.chdir(folder)
    for name in [name for name in sys.modules if name.split(".")[0] in PACKAGES]:
        del sys.modules[name]
    sys.path[:] = [str(folder), *(p for p in sys.path if not (Path(p) / "alight").is_dir())]
    sys.dont_write_bytecode = True
    os.environ.update(
        PYTHONPATH=str(folder), PYTHONDONTWRITEBYTECODE="1",
        ALIGHT_CACHE=str(folder / "cache"), KERNELS_OF_THE_CAMPAIGN=str(kernels),
        TMPDIR=str(left),
    )  # fmt: skip
    import pytest

    class Server:
        def pytest_runtestloop(self, session: Any) -> bool:
            if session.testsfailed:
                raise session.Failed("not all tests could be collected")
            # What compiles is imported once too.
            import lanewise.compiler  # noqa: F401

            gc.collect()
            gc.freeze()
            campaign(Trial(folder, session))
            return True

    options = ["-qq", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:faulthandler"]
    options += ["--capture=no", "--tb=short", "-o", "timeout=0", "-W", "ignore:.*fork"]
    options += [f"--ignore=tests/{name}" for name in left_out]
    pytest.main([*options, "tests"], plugins=[Server()])


class Trial:
    """The collected tests, and forks in which they run."""

    def __init__(self, folder: Path, session: Any):
        self.folder, self.session = folder, session
        self.items = {item.nodeid: item for item in session.items}
        self.functions: dict[tuple[str, str, int], list[FunctionType]] = {}
        for value in _all_functions():
            self.functions.setdefault(_key(value.__code__), []).append(value)

    def run(self, tests: list[str], seconds: float, plant: tuple[str, bytes] | None) -> Result:
        """Run tests by name until one fails, with a file of the package changed.

        Parameters
        ----------
        tests : list of str
            As pytest names them, in the order in which they run.
        seconds : float
            Processor time after which it is enough.
        plant : (str, bytes), optional
            The file, inside the package, and its new text.
        """
        notes = self.folder / "notes.jsonl"
        notes.unlink(missing_ok=True)
        self._forget()
        if plant is None:
            return self._run(tests, seconds, notes, None)
        path = self.folder / "alight" / plant[0]
        source = path.read_bytes()
        for cached in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            cached.unlink()
        # Tests that start processes of their own meet the slip in the file.
        path.write_bytes(plant[1])
        try:
            return self._run(tests, seconds, notes, (path, source, plant[1]))
        finally:
            path.write_bytes(source)

    def _forget(self) -> None:
        """Remove what an earlier slip may have left in the cache; functions are kept by text."""
        for kept in (self.folder / "cache").glob("*"):
            if not kept.name.startswith("functions-"):
                shutil.rmtree(kept, ignore_errors=True)

    def _run(self, tests: list[str], seconds: float, notes: Path, change: Any) -> Result:
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            try:
                self._child(tests, notes, change)
            finally:
                os._exit(70)
        started, stopped, used = time.perf_counter(), False, 0.0
        while not os.waitpid(child, os.WNOHANG)[0]:
            waited = time.perf_counter() - started
            used = max(used, _processor_time(child))
            if used > seconds or waited > 15.0 * seconds:
                os.killpg(child, signal.SIGKILL)
                os.waitpid(child, 0)
                stopped = True
                break
            time.sleep(0.02)
        lines = notes.read_text().splitlines() if notes.is_file() else []
        records = [json.loads(line) for line in lines]
        durations = {r["test"]: r["seconds"] for r in records if "seconds" in r}
        for record in records:
            if "says" in record:
                return Result("failed", record["test"], record["says"], durations, used)
        if records and records[-1].get("done"):
            return Result("passed", "", "", durations, used)
        last = records[-1]["test"] if records else ""
        return Result("unfinished" if stopped else "died", last, "", durations, used)

    def _child(self, tests: list[str], notes: Path, change: Any) -> None:
        os.setsid()
        log = os.open(self.folder / "log.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(log, stream)
        with notes.open("w", encoding="utf-8", buffering=1) as file:

            def note(**what: Any) -> None:
                file.write(json.dumps(what) + "\n")

            if change is not None:
                self._give_new_code(*change)
            session = self.session
            session.items[:] = [self.items[name] for name in tests]
            session.config.pluginmanager.register(_Watch(note))
            for item, following in _with_next(session.items):
                note(test=item.nodeid, begins=True)
                started = time.process_time()
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
                note(test=item.nodeid, seconds=round(time.process_time() - started, 3))
                if session.testsfailed:
                    break
            note(test="", done=True)
        os._exit(0)

    def _give_new_code(self, path: Path, old: bytes, new: bytes) -> None:
        """Change the functions of a module in place: whoever imported them has them."""
        pairs = zip(_codes(old, path), _codes(new, path), strict=True)
        for before, after in pairs:
            assert before.co_qualname == after.co_qualname
            for function in self.functions.get(_key(before), []):
                function.__code__ = after


class _Watch:
    """A plugin that notes what failed."""

    def __init__(self, note: Callable[..., None]) -> None:
        self.note = note

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            self.note(test=report.nodeid, says=str(crash and crash.message)[:300])


def _with_next(items: list[Any]) -> Iterator[tuple[Any, Any]]:
    yield from zip(items, [*items[1:], None], strict=True)


def _all_functions() -> Iterator[FunctionType]:
    gc.unfreeze()
    for value in gc.get_objects():
        if type(value) is FunctionType and value.__module__ is not None:
            yield value
    gc.freeze()


def _key(code: CodeType) -> tuple[str, str, int]:
    return code.co_filename, code.co_qualname, code.co_firstlineno


def _codes(source: bytes, path: Path) -> list[CodeType]:
    """All code objects of a file, in the order of its text."""

    def walk(code: CodeType) -> Iterator[CodeType]:
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                yield constant
                yield from walk(constant)

    return list(walk(compile(source, str(path), "exec", dont_inherit=True)))


def _processor_time(process: int) -> float:
    """Seconds of a process and of those that it has waited for."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, words[11:15])) / os.sysconf("SC_CLK_TCK")
