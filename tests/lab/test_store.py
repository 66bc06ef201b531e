"""The results file: what is in it stays in it, whatever happens to the writer."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from alight.core.errors import OutputError
from alight.lab.pictures import _notes
from alight.lab.store import Example, Replicate, Store

WRITER = """
import sys
import numpy as np
from pathlib import Path
from alight.lab.store import Replicate, Store

with Store(Path(sys.argv[1])) as store:
    for number in range(10000):
        picture = np.full((32, 32, 3), float(number), np.float32)
        row = Replicate(number, number, 0, {4: {"mse": 1.0}}, np.arange(7.0))
        store.add("arm", row, {4: picture}, None)
        print(number, flush=True)
"""


def _replicate(number):
    rungs = {4: {"seconds": 0.1, "mse": 2.0, "flip": None}}
    return Replicate(number, 100 + number, 3, rungs, np.arange(5.0))


def test_round_trip(tmp_path):
    rng = np.random.default_rng(1)
    pictures = rng.random((3, 4, 5, 3)).astype(np.float32)
    with Store(tmp_path / "a.sqlite") as store:
        for number, picture in enumerate(pictures):
            store.add("x", _replicate(number), {4: picture}, Example(4, 0.5, picture))
        store.keep("fact", [1, 2.5, "three"])
    with Store(tmp_path / "a.sqlite") as store:
        assert store.numbers("x") == {0, 1, 2}
        assert store.numbers("y") == store.numbers("w") == set()
        first = next(store.replicates("x"))
        assert (first.seed, first.invalid, first.rungs[4]["mse"]) == (100, 3, 2.0)
        assert first.blocks.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
        moments = store.moments("x", 4)
        assert moments.mean == pytest.approx(pictures.mean(axis=0), rel=1e-6)
        assert moments.variance == pytest.approx(pictures.var(axis=0, ddof=1), rel=1e-4)
        # The first picture is the one that stays.
        assert np.array_equal(store.example("x").picture, pictures[0])
        assert store.fact("fact") == [1, 2.5, "three"]
        assert store.fact("other") is None


def test_processors_are_those_of_an_arm(tmp_path):
    with Store(tmp_path / "a.sqlite") as store:
        picture = np.ones((2, 2, 3), np.float32)
        # Whoever wrote the first one did not say.
        for number, name in enumerate(("", "Fast 1", "Slow 2", "Slow 2")):
            row = replace(_replicate(number), processor=name)
            store.add("x", row, {4: picture}, None)
    with Store(tmp_path / "a.sqlite") as store:
        assert store.processors("x") == {"Fast 1", "Slow 2"}
        assert store.processors("y") == set()


def test_a_replicate_is_all_or_nothing(tmp_path):
    with Store(tmp_path / "a.sqlite") as store:
        picture = np.ones((2, 2, 3), np.float32)
        store.add("x", _replicate(0), {4: picture}, None)
        with pytest.raises(OutputError):
            # The number is taken: nothing of it may stay.
            store.add("x", _replicate(0), {4: picture}, None)
        assert store.moments("x", 4).count == 1


def test_a_full_disk_is_a_message_and_loses_nothing(tmp_path):
    with Store(tmp_path / "a.sqlite") as store:
        store.add("x", _replicate(0), {4: np.ones((2, 2, 3), np.float32)}, None)
        pages = store._base.execute("PRAGMA page_count").fetchone()[0]
        store._base.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(OutputError, match="full"):
            store.add("y", _replicate(1), {4: np.ones((64, 64, 3), np.float32)}, None)
    with Store(tmp_path / "a.sqlite") as store:
        assert store.numbers("x") == {0}
        assert store.numbers("y") == store.numbers("w") == set()
        assert store.moments("y", 4) is None


@pytest.mark.skipif(os.name == "nt", reason="there is no SIGKILL")
def test_kill_loses_at_most_the_replicate_in_flight(tmp_path):
    path = tmp_path / "a.sqlite"
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True
    )
    last = -1
    for line in writer.stdout:
        last = int(line)
        if last >= 20:
            writer.send_signal(signal.SIGKILL)
            break
    rest = writer.stdout.read().split()
    last = int(rest[-1]) if rest else last
    writer.wait()
    writer.stdout.close()
    with Store(path) as store:
        done = store.numbers("arm")
        # What was reported is there, and the sums hold exactly what the rows say.
        assert done in (set(range(last + 1)), set(range(last + 2)))
        assert store.moments("arm", 4).count == len(done)


def test_no_results_file_is_a_message(tmp_path):
    (tmp_path / "a.sqlite").write_text("this is no database, but long enough to look at " * 50)
    with pytest.raises(OutputError, match=r"cannot write .*a\.sqlite"):
        Store(tmp_path / "a.sqlite")
    with pytest.raises(OutputError, match="unable to open"):
        Store(tmp_path / "missing" / "a.sqlite")


def test_times_of_two_processors_are_no_longer_those_of_one():
    for count in (1, 2, 3):
        names = {f"processor {n}" for n in range(count)}
        said = [note for note in _notes([], names) if "processors" in note]
        listed = ", ".join(sorted(names))
        assert said == [f"times are those of different processors: {listed}"] * (count > 1)
