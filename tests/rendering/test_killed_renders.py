"""Renders that are killed at any moment go on to the same bits."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest


def kill_renders(kills, folder, seed, *options):
    result = subprocess.run(
        [sys.executable, "-m", "tests.rendering.kills", "--kills", str(kills),
         "--folder", str(folder), "--seed", str(seed), *options],
        capture_output=True, text=True, check=False, cwd=Path(__file__).parents[2],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout.splitlines()[-1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
@pytest.mark.parametrize("kills", [6, pytest.param(100, marks=pytest.mark.proofs)])
def test_killed_renders_go_on_to_the_same_bits(tmp_path, kills):
    inside = ("--inside", "3") if kills >= 100 else ()
    seen = kill_renders(kills, tmp_path, kills, *inside)
    assert seen["kills"] >= kills
    assert seen["results"] > 0
    assert seen["different"] == 0
    assert seen["leftovers"] == 0
    if kills >= 100:
        # Without any that meet a write the proof would prove little.
        assert seen["inside a checkpoint's write"] >= 3
        assert seen["with samples in the checkpoint"] >= 30


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
@pytest.mark.parametrize("kills", [3, pytest.param(40, marks=pytest.mark.proofs)])
def test_killed_adaptive_renders_go_on_to_their_error_and_merge_to_the_same_bits(tmp_path, kills):
    seen = kill_renders(kills, tmp_path, kills, "--steered")
    assert seen["kills"] >= kills
    assert seen["results"] > 0
    assert seen["different"] == 0
    assert seen["leftovers"] == 0
