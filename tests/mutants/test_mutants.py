"""The tests have teeth: each of the planted bugs is found by the test that is named for it.

A bug is planted in a copy of the packages and of their tests; the working tree is never touched.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.mutants.mutants import MUTANTS

ROOT = Path(__file__).parents[2]

#: "2/3": every third bug, from the second on. `make proofs` tries all of them.
SHARE, OF = (int(part) for part in os.environ.get("PLANTED", "1/1").split("/"))
TRIED = MUTANTS[SHARE - 1 :: OF]

#: Runs that all killers are split into: one run of them all takes longer than one test may.
PARTS = 8

#: In the root of a copy: tests that looked at the working tree instead would prove nothing.
CONFTEST = """
from pathlib import Path

import alight

assert Path(alight.__file__).is_relative_to(Path(__file__).parent)
"""

#: How pytest's summary shows that an assertion failed, and not that the patch broke the program.
FAILED = re.compile(r"^FAILED \S+.* - (AssertionError|assert |\S+BrokenLawError)", re.MULTILINE)


def copy_of_the_project(folder: Path) -> Path:
    """A copy of the packages, their tests and settings."""
    ignored = shutil.ignore_patterns("__pycache__", "mutants", "references")
    for name in ("alight", "lanewise", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", folder)
    (folder / "conftest.py").write_text(CONFTEST)
    return folder


@pytest.fixture(scope="session")
def project(tmp_path_factory):
    """The copy that this process plants its bugs in, one after the other."""
    return copy_of_the_project(tmp_path_factory.mktemp("project"))


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """Functions that a bug does not touch are compiled once for all bugs and processes."""
    base = tmp_path_factory.getbasetemp()
    return (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "compiled"


def run_tests(folder: Path, cache: Path, *tests: str) -> subprocess.CompletedProcess:
    """Run tests of a copy until one fails."""
    environment = {
        **os.environ, "PYTHONPATH": str(folder), "ALIGHT_CACHE": str(cache),
        "COLUMNS": "300", "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    # Assertions are plain: pytest can take many minutes to tell how two large sets differ.
    options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=line"]
    options += ["--assert=plain"]
    # A run that is stuck says where, before the time of the test around it is over.
    command = [sys.executable, "-X", "faulthandler", "-m", "pytest", *options]
    command += ["-o", "faulthandler_timeout=200", "-o", "timeout=0", *tests]
    if all("::" in test for test in tests):
        # Named, so meant, be they proofs or not.
        command += ["-m", "proofs or not proofs"]
    # In a session of its own: a bug that signals its group, and what a stuck test has started, end
    # with it and reach nobody else.
    with subprocess.Popen(
        command, cwd=folder, env=environment, start_new_session=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        try:
            out, err = process.communicate(timeout=570)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, err = process.communicate()
            pytest.fail(f"stuck: {' '.join(tests)}\n{out}{err}")
    return subprocess.CompletedProcess(command, process.returncode, out, err)


@pytest.mark.proofs
@pytest.mark.parametrize("part", range(PARTS))
def test_killers_pass_without_a_bug(part, project, cache):
    killers = sorted({mutant.killer for mutant in TRIED})
    first, end = (len(killers) * edge // PARTS for edge in (part, part + 1))
    result = run_tests(project, cache, *killers[first:end])
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.proofs
@pytest.mark.parametrize("mutant", TRIED, ids=[mutant.name for mutant in TRIED])
def test_the_bug_is_found(mutant, project, cache):
    path = project / mutant.package / mutant.file
    right = path.read_text("utf-8")
    text = right
    for old, new in mutant.edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    try:
        path.write_text(text, "utf-8")
        result = run_tests(project, cache, mutant.killer)
    finally:
        path.write_text(right, "utf-8")
    assert result.returncode == 1, f"survived: {mutant.killer}\n{result.stdout}{result.stderr}"
    assert FAILED.search(result.stdout), f"broke the program:\n{result.stdout}{result.stderr}"


@pytest.mark.parametrize("mutant", MUTANTS, ids=[mutant.name for mutant in MUTANTS])
def test_the_patch_fits(mutant):
    text = (ROOT / mutant.package / mutant.file).read_text("utf-8")
    for old, new in mutant.edits:
        assert text.count(old) == 1, f"{old!r} must occur once in {mutant.file}"
        assert new != old


def test_names_of_bugs_and_killers():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 20
    for mutant in MUTANTS:
        assert (ROOT / mutant.killer.partition("::")[0]).is_file(), mutant.killer
