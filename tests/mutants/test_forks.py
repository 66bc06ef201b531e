"""Forks meet the files as they are, and leave nothing behind."""

import os
import time
from pathlib import Path

import pytest

from tests.mutants.forks import Forks, planted

SUBJECT = "VALUE = 1\n"
TESTS = """
import subprocess, sys, time
from subject import VALUE

def test_value():
    assert VALUE == 1

def test_that_leaves_a_process():
    left = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    print("left", left.pid)

def test_that_is_stuck():
    time.sleep(600)
"""
OPTIONS = ["-q", "-x", "-s", "-p", "no:cacheprovider", "--assert=plain", "test_subject.py"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    (folder / "subject.py").write_text(SUBJECT)
    (folder / "test_subject.py").write_text(TESTS)
    return folder


@pytest.fixture(scope="module")
def forks(folder):
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": ""}
    forks = Forks(folder, environment)
    yield forks
    forks.close()


@pytest.mark.proofs
def test_each_fork_has_the_text_of_its_moment(forks, folder):
    tests, codes, seconds = [*OPTIONS, "-k", "value"], [], []
    path = folder / "subject.py"
    for text in ("VALUE = 2\n", "VALUE = 1\n", "VALUE = 3\n"):
        codes.append(forks.run(tests)[0])
        seconds.append(int(path.stat().st_mtime))
        with planted(path, text):
            codes.append(forks.run(tests)[0])
            seconds.append(int(path.stat().st_mtime))
    assert codes == [0, 1, 0, 0, 0, 1]
    assert path.read_text() == SUBJECT
    # Texts of the same length are told apart by these, however fast they follow each other.
    assert seconds[0] == seconds[2] == seconds[4]
    assert len({*seconds}) == 4
    assert max(seconds[1::2]) < 1_000_000 < seconds[0]


@pytest.mark.proofs
def test_what_a_test_has_started_ends_with_it(forks):
    code, said = forks.run([*OPTIONS, "-k", "leaves"])
    assert code == 0
    left = int(said.partition("left ")[2].split()[0])
    until = time.monotonic() + 10.0
    while is_running(left) and time.monotonic() < until:
        time.sleep(0.05)
    assert not is_running(left)


@pytest.mark.proofs
def test_what_is_stuck_is_ended_and_the_next_one_runs(forks):
    with pytest.raises(TimeoutError):
        forks.run([*OPTIONS, "-k", "stuck"], limit=3.0)
    assert forks.run([*OPTIONS, "-k", "value"])[0] == 0


def is_running(process):
    """Whether a process is there, and not just waiting to be asked how it ended."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except FileNotFoundError:
        return False
    return words[0] != "Z"
