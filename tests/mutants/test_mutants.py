"""The tests have teeth: each of the planted bugs is found by the test that is named for it.

A bug is planted in a copy of the packages and of their tests; the working tree is never touched.
"""

from __future__ import annotations

import os
import re
import shutil
from contextlib import suppress
from pathlib import Path

import pytest

import alight
from lanewise.machine import cache_folder, functions_folder
from tests.mutants.forks import Forks, planted
from tests.mutants.mutants import MUTANTS
from tests.portion import portion

#: Of the packages whose compiled functions are used again.
ROOT = Path(alight.__file__).parents[1]

TRIED = portion(MUTANTS)

KILLERS = sorted({mutant.killer for mutant in TRIED})

#: Runs that they are split into: one run of them all takes longer than one test may. None is empty,
#: which would mean all tests.
PARTS = min(8, len(KILLERS))

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
    """Functions that a bug does not touch are compiled once for all bugs and processes.

    What the suite has compiled is there already: the copy has the same sources. A bug's functions
    are kept apart from it.
    """
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "compiled"
    for kept in (cache_folder(), functions_folder()):
        whole, part = folder / kept.name, tmp_path_factory.mktemp("part") / kept.name
        if kept.is_dir() and not whole.is_dir():
            shutil.copytree(kept, part)
            whole.parent.mkdir(exist_ok=True)
            # Another process may have been faster.
            with suppress(OSError):
                part.replace(whole)
    return folder


@pytest.fixture(scope="session")
def forks(project, cache, tmp_path_factory):
    """What runs tests of the copy."""
    environment = {
        **os.environ, "PYTHONPATH": str(project), "ALIGHT_CACHE": str(cache), "COLUMNS": "300",
        "PYTHONDONTWRITEBYTECODE": "",
        # Killers are named, and may be of any portion.
        "PORTION": "1/1",
        # For what bugs, and processes that are killed, leave behind.
        "TMPDIR": str(tmp_path_factory.mktemp("left")),
    }  # fmt: skip
    forks = Forks(project, environment)
    yield forks
    forks.close()


def run_tests(forks: Forks, *tests: str) -> tuple[int, str]:
    """Run tests of a copy until one fails: pytest's exit code, and what it wrote."""
    # Assertions are plain: pytest can take many minutes to tell how two large sets differ.
    options = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=line"]
    options += ["--assert=plain"]
    # A run that is stuck says where, before the time of the test around it is over.
    options += ["-o", "faulthandler_timeout=200", "-o", "timeout=0", *tests]
    if all("::" in test for test in tests):
        # Named, so meant, be they proofs or not.
        options += ["-m", "proofs or not proofs"]
    try:
        return forks.run(options)
    except TimeoutError as error:
        pytest.fail(f"stuck: {' '.join(tests)}\n{error}")


@pytest.mark.proofs
@pytest.mark.parametrize("part", range(PARTS))
def test_killers_pass_without_a_bug(part, forks):
    first, end = (len(KILLERS) * edge // PARTS for edge in (part, part + 1))
    code, said = run_tests(forks, *KILLERS[first:end])
    assert code == 0, said


@pytest.mark.proofs
@pytest.mark.parametrize("mutant", TRIED, ids=[mutant.name for mutant in TRIED])
def test_the_bug_is_found(mutant, project, forks):
    path = project / mutant.package / mutant.file
    text = path.read_text("utf-8")
    for old, new in mutant.edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    with planted(path, text):
        code, said = run_tests(forks, mutant.killer)
    assert code == 1, f"survived: {mutant.killer}\n{said}"
    assert FAILED.search(said), f"broke the program:\n{said}"


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
