"""Answers hold what was computed, and nothing of the run or the machine."""

import numpy as np
import pytest

from tests.recorded.making import FEW, briefly, command, described, in_folder, masked, summed_up


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("picture: /tmp/alight-recordx1_z/a.png", "picture: a.png"),
        ("cannot read /private/var/tmp/alight-recordq/none", "cannot read none"),
        ("folder /tmp/alight-recordab12 is full", "folder FOLDER is full"),
        (
            "8 spp in 1.25 s, 0.31 Msamples/s (2 s in all)",
            "8 spp in # s, # Msamples/s (# s in all)",
        ),
        ("meshes of 1.5 MB, 64 kB", "meshes of # MB, # kB"),
        ("listed 3, seconds 0.00012", "listed 3, seconds #"),
        ("seen 2026-11-27T18:01:02", "seen DATE"),
        ("hash 0123456789abcdef01", "hash DIGEST"),
        (
            "4 samples, 8x8 pixels, 50 %, 3.5 m, a/b.png",
            "4 samples, 8x8 pixels, 50 %, 3.5 m, a/b.png",
        ),
        ("scenes 12", "scenes 12"),
    ],
)
def test_what_differs_from_run_to_run_is_masked_and_nothing_else(text, kept):
    assert masked(text) == kept


def test_folders_of_a_run_are_masked_wherever_they_are():
    with in_folder({"a/b.txt": "x"}) as folder:
        assert masked(f"error: {folder / 'a' / 'b.txt'} is wrong") == "error: a/b.txt is wrong"
        assert masked(f"in {folder}: nothing") == "in FOLDER: nothing"


@pytest.mark.parametrize("at", [0, 1, 777, 2998])
def test_a_sum_of_an_array_tells_when_one_of_its_numbers_changes(at):
    array = np.random.default_rng(127).random(3000)
    before = summed_up(array)
    array[at] += 0.5
    after = summed_up(array)
    assert before != after
    changed = np.roll(array, 1)
    assert summed_up(changed)["numbers"][4] != pytest.approx(after["numbers"][4], rel=1e-3)


def test_long_tables_are_summed_up_and_short_ones_are_not():
    assert briefly({"a": [[1.0, 2.0], [3.0, 4.0]], "b": ["x", 1]}) == {
        "a": [[1.0, 2.0], [3.0, 4.0]], "b": ["x", 1],
    }  # fmt: skip
    assert set(briefly([1.0] * (FEW + 1))) == {"shape", "type", "not finite", "numbers"}
    assert described({"path": np.float32(2.5), "none": None, "set": {3, 1}}) == {
        "path": np.float32(2.5), "none": None, "set": [1, 3],
    }  # fmt: skip


@pytest.mark.parametrize("columns", [40, 100, 300])
def test_transcripts_do_not_depend_on_the_terminal(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("LANG", "de_DE.UTF-8")
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    found = command("info", "cornell-box")
    assert found["exit"] == 0
    assert found == command("info", "cornell-box", columns=100)
