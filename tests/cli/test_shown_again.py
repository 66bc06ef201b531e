"""Pictures shown once more (`alight tonemap`), and lists that fit a terminal."""

import numpy as np
import pytest
from PIL import Image
from rich.console import Console
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.cli.progress import ProgressBar
from alight.cli.scenes import entry
from alight.films import Film
from alight.outputs.image import write_image
from alight.outputs.picture import Picture
from alight.rendering import Progress

RAMP = np.linspace(0.0, 2.0, 4 * 6 * 3, dtype=np.float32).reshape(4, 6, 3)
SHOWN = {"exposure": -1.5, "tone_map": "agx", "bits": 8, "white_balance": "3200K"}
WORDS = ["--exposure", "-1.5", "--tone-map", "agx", "--white-balance", "3200K"]


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def pixels(path):
    with Image.open(path) as picture:
        return np.asarray(picture)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("suffix", ["exr", "pfm", "npy"])
def test_a_linear_picture_is_shown_as_a_render_would_have_been(folder, suffix):
    write_image(f"a.{suffix}", RAMP)
    result = run("tonemap", f"a.{suffix}", *WORDS, "-o", "b.png", "-o", "c.jpg")
    assert result.output == "written: b.png\nwritten: c.jpg\n"
    write_image("expected.png", RAMP, **SHOWN)
    assert np.array_equal(pixels("b.png"), pixels("expected.png"))
    assert pixels("c.jpg").shape == (4, 6, 3)


def test_alpha_of_an_exr_stays(folder):
    alpha = np.linspace(0, 1, 24, dtype=np.float32).reshape(4, 6)
    picture = Picture(RAMP * alpha[..., None], alpha=alpha)
    write_image("a.exr", picture)
    assert run("tonemap", "a.exr", "-q").output == ""
    write_image("expected.png", picture)
    assert pixels("a.png").shape == (4, 6, 4)
    assert np.array_equal(pixels("a.png"), pixels("expected.png"))


def test_a_film_is_shown_again(folder):
    film = alight.render("cornell-box", size=16, spp=4, output="a.alight")
    assert run("tonemap", "a.alight", *WORDS).exit_code == 0
    film.save("expected.png", **SHOWN)
    assert np.array_equal(pixels("a.png"), pixels("expected.png"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["a.exr", "-o", "b.exr"], "cannot write b.exr: must end in .png, .jpg or .jpeg"),
        (["a.exr", "-o", "b.pgn"], 'unknown suffix ".pgn"; did you mean ".png"?'),
        (["b.png", "-o", "c.png"], "b.png is a picture for a display already"),
        (["none.exr"], "cannot read none.exr: there is no such file"),
        (["a.exr", "--denoise"], "--denoise: needs a film (.alight), which knows its noise"),
        (["a.exr", "--tone-map", "agy"], 'unknown tone map "agy"; did you mean "agx"?'),
    ],
)
def test_what_cannot_be_shown_is_said(folder, words, message):
    write_image("a.exr", RAMP)
    write_image("b.png", RAMP)
    before = sorted(folder.iterdir())
    result = run("tonemap", *words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert sorted(folder.iterdir()) == before


def test_all_scenes_come_on_a_sheet(folder, monkeypatch):
    monkeypatch.setattr("alight.formats.builtin_names", lambda: ("cornell-box",))
    result = run("scenes", "--sheet", "all.png")
    assert result.output.endswith("sheet: all.png\n")
    assert "[1/1] cornell-box" in result.output
    assert pixels("all.png").shape[2] == 3


@pytest.mark.parametrize("columns", [40, 60, 100])
def test_a_scene_fits_the_terminal(columns):
    text = "A row of balls that runs away from a thin lens; the red one is in focus."
    lines = entry("depth-of-field", text, 28, columns)
    assert all(len(line) <= columns for line in lines)
    assert len(lines) <= 4
    assert " ".join(" ".join(lines).split()) == f"depth-of-field {text}"
    # What follows is indented, below the first line of the text or of the name.
    assert len({len(line) - len(line.lstrip()) for line in lines[1:]}) == 1


@pytest.mark.parametrize("columns", [45, 60, 80])
def test_the_bar_is_never_squeezed_to_nothing(monkeypatch, columns):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    bar = ProgressBar()
    bar(Progress("render", 12_000_000, 12_000_000, 2.0, Film(2, 2)))
    console = Console(width=columns, force_terminal=True)
    with console.capture() as captured:
        console.print(bar._bar.get_renderable())
    assert captured.get().count("━") >= 10
