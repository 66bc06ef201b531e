"""``--checkpoint``, ``alight resume`` and ``alight merge``: what is there, and how to go on."""

import errno
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.films import Film
from alight.outputs import read_image
from alight.outputs.exr import read_layers

SMALL = ["--size", "24x16"]


@pytest.fixture
def alight(monkeypatch, tmp_path):
    """Run the command line in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        result = CliRunner().invoke(app, [str(a) for a in arguments])
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return run


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def send_when(monkeypatch, samples, number):
    """Send ourselves a signal when so many samples are in the film."""
    add_tile = Film.add_tile

    def add_and_send(film, *tile):
        add_tile(film, *tile)
        if film.counts.sum() == samples * film.counts[..., 0].size:
            os.kill(os.getpid(), number)

    monkeypatch.setattr(Film, "add_tile", add_and_send)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_says_what_there_is_and_the_command_to_go_on(
    alight, monkeypatch, tmp_path, number, code
):
    whole = alight("render", *SMALL, "--spp", 12, "-o", "whole.alight", "-o", "whole.exr")
    assert whole.exit_code == 0, whole.output
    render = ["render", *SMALL, "--spp", 12, "-o", "out.exr", "--spp-per-pass", 3]
    with monkeypatch.context() as patch:
        send_when(patch, 6, number)
        stopped = alight(*render, "--checkpoint", "a b.alight")
    assert stopped.exit_code == code
    assert stopped.stderr == (
        "stopped at 6 spp; the samples so far are in out.partial.exr\n"
        "to continue: alight resume 'a b.alight'\n"
    )
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    resumed = alight("resume", "../a b.alight")
    assert resumed.exit_code == 0, resumed.output
    # Into the file that was asked for first, wherever the render is resumed.
    assert f"picture: {tmp_path / 'out.exr'}" in resumed.stdout
    assert "checkpoint: ../a b.alight" in resumed.stdout
    film, reference = Film.load("../a b.alight"), Film.load("../whole.alight")
    np.testing.assert_array_equal(film.sums, reference.sums)
    assert (tmp_path / "out.exr").read_bytes() == (tmp_path / "whole.exr").read_bytes()


def test_a_signal_to_a_render_without_checkpoint_promises_nothing(alight, monkeypatch):
    send_when(monkeypatch, 6, signal.SIGTERM)
    stopped = alight("render", *SMALL, "--spp", 12, "--spp-per-pass", 3)
    assert stopped.exit_code == 143
    assert stopped.stderr == "stopped at 6 spp; the samples so far are in cornell-box.partial.exr\n"


def test_handlers_are_put_back(alight):
    before = signal.getsignal(signal.SIGTERM)
    alight("render", *SMALL, "--spp", 1)
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_render_is_extended_and_written_elsewhere(alight, tmp_path):
    alight("render", *SMALL, "--spp", 4, "--checkpoint", "a.alight")
    result = alight("resume", "a.alight", "--spp", 8, "-o", "b.npy", "--checkpoint", "c.alight")
    assert result.exit_code == 0, result.output
    assert (Film.load("a.alight").spp, Film.load("c.alight").spp) == (4, 8)
    assert names_in(tmp_path) == ["a.alight", "b.npy", "c.alight", "cornell-box.png"]
    fewer = alight("resume", "c.alight", "--spp", 6, "-o", "b.npy")
    assert "warning: there are 8 samples per pixel already; --spp 6 adds none" in fewer.stderr
    assert fewer.exit_code == 0


def test_a_picture_that_cannot_be_written_is_not_lost(alight, monkeypatch, tmp_path):
    from alight.outputs import exr

    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(exr, "write", full)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    kept = alight("render", *SMALL, "--spp", 4, "-o", "a.exr", "--checkpoint", "a.alight")
    assert kept.exit_code == 2
    assert kept.stderr == (
        "error: cannot write a.exr: the disk is full\n"
        "nothing is lost, all samples are in a.alight; to write them: "
        "alight resume a.alight -o ELSEWHERE.exr\n"
    )
    rescued = alight("render", *SMALL, "--spp", 4, "-o", "a.exr")
    path = tmp_path / f"alight-{os.getpid()}.alight"
    assert rescued.exit_code == 2
    assert f"all samples are in {path}; to write them: alight merge {path} -o" in rescued.stderr
    monkeypatch.undo()
    np.testing.assert_array_equal(Film.load(path).sums, Film.load(tmp_path / "a.alight").sums)


def test_parts_merge_to_the_same_files(alight):
    alight("render", *SMALL, "--spp", 8, "-o", "whole.exr", "-o", "whole.alight")
    alight("render", *SMALL, "--spp", 5, "-o", "a.alight")
    alight("render", *SMALL, "--spp", 3, "--first-sample", 5, "--checkpoint", "b.alight")
    result = alight("merge", "b.alight", "a.alight", "-o", "m.exr", "-o", "m.alight", "-o", "m.png")
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert lines[0] == "2 films, 24x16 pixels, 8 spp"
    assert lines[1].startswith("estimated error: ")
    assert lines[2].startswith("bias: paths end at depth 8: −")
    assert lines[3:] == ["written: m.exr", "written: m.alight", "written: m.png"]
    assert Path("m.exr").read_bytes() == Path("whole.exr").read_bytes()
    assert read_image("m.png").shape == (16, 24, 3)
    one = alight("merge", "whole.alight", "-o", "one.exr")
    assert one.stdout.startswith("1 film, 24x16 pixels, 8 spp")
    assert read_layers("one.exr")[1] == read_layers("m.exr")[1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["merge", "a.alight", "a.alight", "-o", "m.exr"], "samples 0 to 3 are in a.alight too"),
        (["merge", "a.alight", "-o", "m.xyz"], 'unknown suffix ".xyz"'),
        (["merge", "a.alight", "s1.alight", "-o", "m.exr"],
         "cannot merge s1.alight with a.alight: the seed differs (1, not 0)"),
        (["merge", "a.alight", "d3.alight", "-o", "m.exr"],
         ("cannot merge d3.alight with a.alight: their scenes differ\n"
          "  integrator.max_depth: was 8, is 3")),
        (["merge", "no.alight", "-o", "m.exr"], "cannot read no.alight: there is no such file"),
        (["merge", "out.png", "-o", "m.exr"], "out.png is not a film or checkpoint of alight"),
        (["resume", "film.alight"], "film.alight is a film, not a checkpoint"),
        (["resume", "no.alight"], "cannot read no.alight: there is no such file"),
        (["resume", "cut.alight"], "cut.alight is damaged or truncated: its checksum is wrong"),
        (["resume", "a.alight", "--every", "soon"], "--every: must be a time such as 60s"),
        (["resume", "a.alight", "--scene", "instances"], "the scene has changed since"),
        (["render", "--checkpoint", "no/a.alight"], "cannot write no/a.alight: the folder"),
        (["render", "--checkpoint", "a.alight", "--every", "-5s"], 'got "-5s"'),
    ],
)  # fmt: skip
def test_every_refusal_is_one_message(tmp_path, monkeypatch, files, arguments, message):
    monkeypatch.chdir(files)
    before = names_in(files)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith("error: ")
    assert message in result.stderr
    assert names_in(files) == before


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Films and checkpoints of a few renders."""
    folder, here = tmp_path_factory.mktemp("films"), Path.cwd()
    os.chdir(folder)
    try:
        for options in (
            ["-o", "out.png", "--checkpoint", "a.alight"],
            ["-o", "film.alight"],
            ["-o", "s1.alight", "--seed", "1", "--first-sample", "4"],
            ["-o", "out.png", "--checkpoint", "d3.alight", "--max-depth", "3",
             "--first-sample", "4"],
        ):  # fmt: skip
            result = CliRunner().invoke(app, ["render", *SMALL, "--spp", "4", *options])
            assert result.exit_code == 0, result.output
    finally:
        os.chdir(here)
    (folder / "cut.alight").write_bytes((folder / "a.alight").read_bytes()[:-9])
    return folder
