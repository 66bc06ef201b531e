"""A running study that is killed, or that finds the disk full, goes on as if nothing had been."""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time

import numpy as np
import pytest

STUDY = """
scenes: [{scene: smooth-direct-light, set: {size: 48}}]
arms:
  independent: {sampler: independent}
  sobol: {sampler: sobol}
spp: [4, 64]
equal_time: false
replicates: 8
"""

pytestmark = pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL and no RLIMIT_FSIZE")


@pytest.fixture
def start(tmp_path):
    """Start the study in a process of its own, as a shell does; ``limit`` is in bytes a file."""
    (tmp_path / "small.yaml").write_text(STUDY)
    limiting = "import resource as r; r.setrlimit(r.RLIMIT_FSIZE, ({0}, r.RLIM_INFINITY)); "

    def run(folder, limit=None):
        code = "import runpy; runpy.run_module('alight', run_name='__main__')"
        code = (limiting.format(limit) if limit else "") + code
        words = ["study", "small.yaml", "--quiet", "--threads", "2", "-o", folder]
        return subprocess.Popen(
            [sys.executable, "-c", code, *words], cwd=tmp_path, stderr=subprocess.PIPE, text=True
        )

    return run


def done(folder):
    """Replicates in the results file."""
    try:
        base = sqlite3.connect(f"file:{folder / 'results.sqlite'}?mode=ro", uri=True)
        [(count,)] = base.execute("SELECT COUNT(*) FROM replicates")
        base.close()
    except sqlite3.Error:
        return 0
    return count


def numbers(folder):
    """Everything of the results that no clock decides."""
    [scene] = json.loads((folder / "results.json").read_text())["scenes"]
    timed = {"seconds", "efficiency", "speedup", "slope_time", "microseconds_per_sample"}
    timed |= {"compile_seconds", "load_seconds", "images"}

    def plain(value):
        if isinstance(value, dict):
            return {name: plain(item) for name, item in value.items() if name not in timed}
        return [plain(item) for item in value] if isinstance(value, list) else value

    with np.load(folder / "results.npz") as stored:
        pictures = {name: stored[name].tobytes() for name in stored.files}
    return plain(scene["arms"]), pictures


def finish(process):
    _, message = process.communicate(timeout=240)
    return process.returncode, message


@pytest.mark.proofs
def test_five_kills_change_nothing(start, tmp_path):
    assert finish(start("whole")) == (0, "")
    rng, before = random.Random(4), 0
    for _ in range(5):
        process = start("killed")
        wanted = before + rng.randint(0, 3)
        while process.poll() is None and done(tmp_path / "killed") < wanted:
            time.sleep(0.005)
        time.sleep(0.1 * rng.random())
        seen = done(tmp_path / "killed")
        process.send_signal(signal.SIGKILL)
        finish(process)
        before = done(tmp_path / "killed")
        # Nothing that was there is lost.
        assert before >= seen
    assert finish(start("killed")) == (0, "")
    assert numbers(tmp_path / "killed") == numbers(tmp_path / "whole")


@pytest.mark.proofs
def test_a_full_disk_is_one_message_and_the_study_goes_on(start, tmp_path):
    # Room for a few replicates; the kernels and the reference are kept elsewhere.
    code, message = finish(start("full", limit=400_000))
    assert code == 2
    assert message.count("\n") == 1
    assert message.startswith("error: cannot write full/results.sqlite: ")
    kept = done(tmp_path / "full")
    assert finish(start("full")) == (0, "")
    assert 0 < kept < done(tmp_path / "full") == 16
