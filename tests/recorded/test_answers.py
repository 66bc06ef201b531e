"""Every recorded answer is still the same; see `tests.recorded.answers`."""

import tempfile
from pathlib import Path

import numpy as np
import pytest

from tests.recorded.answers import FOLDER, all_cases, differences, path_of, plain, recorded, save

CASES = all_cases()


@pytest.mark.parametrize("name", CASES)
def test_an_answer_is_still_the_recorded_one(name):
    found = list(differences(plain(CASES[name]()), recorded(name)))
    remedy = f"if it is meant: python -m tests.recorded {name}, and read the difference"
    assert not found, "\n".join([f"{len(found)} places differ; {remedy}", *found[:20]])


def test_each_record_has_a_case():
    assert {*FOLDER.rglob("*.json")} == {path_of(name) for name in CASES}


def test_records_know_no_folder_of_this_machine():
    folders = {str(Path.cwd()), str(Path.home()), tempfile.gettempdir()} - {"/"}
    for path in FOLDER.rglob("*.json"):
        text = path.read_text("utf-8")
        assert not [folder for folder in folders if f"{folder}/" in text], path


def test_a_record_is_read_as_it_was_written(monkeypatch, tmp_path):
    monkeypatch.setattr("tests.recorded.answers.FOLDER", tmp_path)
    answer = {
        "picture": np.arange(12.0).reshape(2, 3, 2) / 7, "text": "two\nlines", "one": "line",
        "counts": [1, 2, 3], "none": None, "true": np.bool_(True), "nan": np.nan, "empty": [],
    }  # fmt: skip
    save("some/case", answer)
    assert recorded("some/case") == plain(answer)


@pytest.mark.parametrize(
    ("found", "right", "places"),
    [
        (1.00005, 1.0, 0),
        (1.0002, 1.0, 1),
        ([1e-7, 1.0], [0.0, 1.0], 0),
        ([1e-5, 1.0], [0.0, 1.0], 1),
        ({"small": 1e-5, "large": 1.0}, {"small": 1.1e-5, "large": 1.0}, 1),
        ({"a": 1, "b": 2}, {"b": 2, "a": 1}, 1),
        ([1, 2], [1, 2, 3], 1),
        (1, 1.0, 1),
        (True, 1, 1),
        (["a", "b"], ["a", "c"], 1),
        ([[1.0, 2.0], [3.0, 4.0]], [[1.0, 2.1], [3.1, 4.0]], 2),
    ],
)
def test_what_counts_as_a_difference(found, right, places):
    assert len(list(differences(found, right))) == places
