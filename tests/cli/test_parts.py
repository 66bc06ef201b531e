"""``alight render --part`` on many machines, then ``alight merge``: the film of one machine."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import OptionError
from alight.films import Film
from alight.rendering.schedules.schedule import Uniform
from alight.rendering.schedules.selection import part_of
from tests.rendering.interrupted import assert_same

SMALL = ["cornell-box", "--size", "24x16", "--threads", "1", "-q"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The film of one machine, and those of three."""
    folder = tmp_path_factory.mktemp("parts")
    words = [*SMALL, "--spp", "8", "--aov", "depth,id", "--seed", "3"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert alight("render", *words, "-o", "whole.alight").exit_code == 0
        for number in (1, 2, 3):
            # The file has a name of its own.
            done = alight("render", *words, "--part", f"{number}/3")
            assert done.exit_code == 0, done.output
    return folder


def alight(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def part(number):
    return f"cornell-box.part-{number}-of-3.alight"


def test_parts_add_up_to_the_whole_film(folder, monkeypatch):
    monkeypatch.chdir(folder)
    done = alight("merge", part(2), part(3), part(1), "--spp", 8, "-o", "all.alight")
    assert done.exit_code == 0, done.output
    assert_same(Film.load("all.alight"), Film.load("whole.alight"))
    assert Path("all.alight").read_bytes() == Path("whole.alight").read_bytes()


def test_a_missing_part_is_told_by_the_exit_code(folder, monkeypatch):
    monkeypatch.chdir(folder)
    done = alight("merge", part(1), part(3), "--spp", 8, "-o", "some.alight")
    assert done.exit_code == 2
    held = "each pixel has 5 samples, not 8; a cell holds those numbered 0 to 1, 5 to 7"
    assert held in done.stderr
    assert not Path("some.alight").exists()
    twice = alight("merge", part(1), part(1), "-o", "some.alight")
    assert twice.exit_code == 2
    assert "would be counted twice" in twice.stderr


@pytest.mark.parametrize("first", [0, 5])
@pytest.mark.parametrize(("spp", "parts"), [(8, 3), (7, 7), (1000, 41), (5, 1)])
def test_parts_hold_each_sample_once_and_are_equal_but_for_one(first, spp, parts):
    ranges = [part_of(Uniform(first, spp), n + 1, parts) for n in range(parts)]
    held = [i for one in ranges for i in range(one.first, one.first + (one.spp or 0))]
    assert held == list(range(first, first + spp))
    sizes = {one.spp for one in ranges}
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--part", "0/3"], "--part: must be I/N with 1 <= I <= N, as 3/40, got \"0/3\""),
        (["--part", "4/3"], "--part: must be I/N"),
        (["--part", "half"], "--part: must be I/N"),
        (["--part", "1/3", "--error", "2%"], "--part is a share of a fixed number of samples"),
        (["--part", "1/3", "--adaptive", "--spp", "8"], "leave out --adaptive and give --spp"),
        (["--part", "1/3", "--time", "9"], "leave out --time and give --spp"),
        (["--part", "1/9", "--spp", "8"], "only 8 samples per pixel for 9 parts"),
        (["--part", "1/3", "-o", "a.png"], "--part makes a film to be merged: give --output"),
    ],
)  # fmt: skip
def test_parts_that_cannot_be_are_refused(tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    done = alight("render", *SMALL, *words)
    assert done.exit_code == 2
    assert message in done.stderr
    assert not any(tmp_path.iterdir())


def test_more_parts_than_samples_are_none():
    with pytest.raises(OptionError, match="only 3 samples per pixel for 4 parts"):
        part_of(Uniform(0, 3), 4, 4)
