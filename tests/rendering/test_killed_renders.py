"""Renders that are killed at any moment go on to the same bits."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.portion import FIRST, portion


def many(kills):
    """This portion of them, by `make proofs`; each portion has a seed of its own."""
    return pytest.param(len(portion(range(kills))), id=str(kills), marks=pytest.mark.proofs)


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
@pytest.mark.parametrize("kills", [6, many(100)])
def test_killed_renders_go_on_to_the_same_bits(tmp_path, kills):
    inside = ("--inside", "3") if kills > 6 else ()
    seen = kill_renders(kills, tmp_path, FIRST * kills, *inside)
    assert seen["kills"] >= kills
    assert seen["results"] > 0
    assert seen["different"] == 0
    assert seen["leftovers"] == 0
    if kills > 6:
        # Without any that meet a write the proof would prove little.
        assert seen["inside a checkpoint's write"] >= 3
        assert seen["with samples in the checkpoint"] >= 0.3 * kills


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
@pytest.mark.parametrize("kills", [3, many(40)])
def test_killed_adaptive_renders_go_on_to_their_error_and_merge_to_the_same_bits(tmp_path, kills):
    seen = kill_renders(kills, tmp_path, FIRST * kills, "--steered")
    assert seen["kills"] >= kills
    assert seen["results"] > 0
    assert seen["different"] == 0
    assert seen["leftovers"] == 0
