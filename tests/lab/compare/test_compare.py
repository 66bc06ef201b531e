"""`alight compare`: figures, verdicts, exit codes, and what it writes."""

import importlib.util
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.lab.compare import Input, compare_inputs
from alight.lab.compare.figures import (
    DIFFERENT,
    DIFFERENT_IF_EXACT,
    EQUAL,
    SAME,
    UNSURE,
    UNTESTED,
)
from alight.lab.compare.views import figure_rows
from alight.metrics import relmse, smape
from alight.outputs import read_image
from tests.lab.compare.test_inputs import film, picture


def run(*arguments):
    return CliRunner().invoke(app, ["compare", *map(str, arguments)], env={"COLUMNS": "200"})


@pytest.fixture
def films(tmp_path):
    """Paths of two films of the same and one of 5 % more light."""
    paths = [tmp_path / f"{name}.exr" for name in "abc"]
    for i, (path, value) in enumerate(zip(paths, (0.5, 0.5, 0.525), strict=True)):
        film(i, spp=8, size=(48, 40), value=value).save(path)
    return paths


def as_json(*arguments):
    done = run(*arguments, "--json")
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_figures_are_those_of_the_metrics(films):
    a, b = (read_image(path).astype(np.float64) for path in films[:2])
    found = as_json(*films[:2])
    assert found["mse"] == pytest.approx(((a - b) ** 2).mean())
    assert found["rmse"] == pytest.approx(math.sqrt(found["mse"]))
    assert found["relmse"] == pytest.approx(relmse(a, b))
    assert found["relmse_literature"] == pytest.approx(relmse(a, b, epsilon=0.01))
    assert found["smape"] == pytest.approx(smape(a, b))
    assert found["epsilon"] == pytest.approx((0.1 * b.mean()) ** 2)
    assert found["mean_a"] == pytest.approx(list(a.mean(axis=(0, 1))))
    # Two independent pictures: the noise of both is the whole difference.
    assert found["noise_mse_a"] + found["noise_mse_b"] == pytest.approx(found["mse"], rel=0.1)
    assert (found["width"], found["height"]) == (48, 40)


def test_verdicts(films):
    assert as_json(*films[:2])["verdict"] == SAME
    assert as_json(films[0], films[2])["verdict"] == DIFFERENT
    assert as_json(films[0], films[0])["verdict"] == EQUAL


def test_pictures_that_differ_by_their_own_errors_alone_are_not_called_different():
    """One of 4 samples that met nothing bright, one of 1 024 that did, here and there."""
    rng = np.random.default_rng(1)
    shape = (64, 64, 3)
    error = np.full(shape, 0.01, np.float32)
    dark = Input("dark", 0.5 + error * rng.standard_normal(shape, np.float32), False, error, 4)
    lit = rng.random((64, 64, 1)) < 0.05
    bright = np.where(lit, 0.6, 0.5).astype(np.float32) + np.zeros(shape, np.float32)
    seen = np.where(lit, 0.1, 0.0001).astype(np.float32) + np.zeros(shape, np.float32)
    fine = Input("fine", bright, False, seen, 4)
    assert compare_inputs(dark, fine, slow=False).verdict == DIFFERENT
    samples = [np.full((64, 64), spp, np.uint32) for spp in (4, 1024)]
    told = [replace(one, samples=n) for one, n in zip((dark, fine), samples, strict=True)]
    found = compare_inputs(*told, slow=False)
    assert found.verdict == UNSURE
    assert any("bright samples were missed" in note for note in found.notes)
    assert found.to_dict()["test"]["doubts"]
    # With as many samples on both sides each says what the other's errors are.
    even = [replace(one, samples=samples[0]) for one in (dark, fine)]
    assert compare_inputs(*even, slow=False).verdict == DIFFERENT


def test_the_family_level_is_told(films):
    assert any("7 tests at a family level of 1 %" in note for note in as_json(*films[:2])["notes"])


def test_a_picture_of_unknown_noise_is_taken_as_exact_and_that_is_said(films, tmp_path):
    np.save(tmp_path / "b.npy", read_image(films[1]))
    found = as_json(films[0], tmp_path / "b.npy")
    assert found["verdict"] == DIFFERENT_IF_EXACT
    assert found["notes"][0].startswith(f"{tmp_path / 'b.npy'} is taken as exact")
    np.save(tmp_path / "a.npy", read_image(films[0]))
    assert as_json(tmp_path / "a.npy", tmp_path / "b.npy")["verdict"] == UNTESTED


def test_two_pictures_against_a_third(films):
    found = as_json(films[0], films[2], "--reference", films[1])["comparisons"]
    assert [one["a"] for one in found] == [str(films[0]), str(films[2])]
    assert {one["b"] for one in found} == {str(films[1])}
    done = run(films[0], films[2], "--reference", films[1])
    assert f"{films[0]} is nearer" in done.stdout


def test_limits_decide_the_exit_code(films):
    assert run(*films[:2], "--fail-above", "relmse=1").exit_code == 0
    done = run(*films[:2], "--fail-above", "relmse=1e-5", "--fail-above", "smape=1")
    assert done.exit_code == 1
    assert re.search(r"relmse is [\d.]+, above 1e-05", done.stderr)
    assert "smape is" not in done.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--fail-above", "relmes=1"], 'unknown figure "relmes"; did you mean "relmse"?'),
        (["--fail-above", "mse=x"], 'must be FIGURE=NUMBER such as relmse=0.01, got "mse=x"'),
        (["--fail-above", "mse=-1"], "must be FIGURE=NUMBER"),
        (
            ["--fail-above", "flip=1", "--no-flip"],
            "flip is unknown: slow metrics were not asked for",
        ),
        (["--output", "x.pgn"], 'unknown suffix ".pgn"; did you mean ".png"?'),
        (["--output", "nowhere/x.npy"], "does not exist"),
        (["--exposure", "1000"], "--exposure: must be a number in [-100, 100], got 1000"),
        (["--reference", "none.exr"], "there is no such file"),
    ],
)
def test_wrong_input_is_one_message_and_exit_code_2(films, options, message):
    done = run(*films[:2], *options)
    assert done.exit_code == 2
    assert done.stderr.startswith("error: ")
    assert message in done.stderr
    assert done.stdout == ""


def test_black_and_small_pictures_have_no_relative_figures():
    black = Input("black", np.zeros((4, 4, 3), np.float32), False)
    found = compare_inputs(Input("a", picture(4, 4), False), black, slow=False).to_dict()
    assert found["relmse"] is None
    assert found["dssim"] is None
    assert found["shown"]["dssim"] == {"label": "SSIM", "value": None}
    assert found["relmse_literature"] > 0


def test_without_flip_the_remedy_is_named(films, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec",
        lambda name, *more: None if name == "flip_evaluator" else found(name, *more),
    )  # fmt: skip
    assert '[lab]"' in run(*films[:2]).stdout
    assert as_json(*films[:2])["flip"] is None


@pytest.mark.parametrize("suffix", [".exr", ".npy", ".pfm"])
def test_the_difference_keeps_its_sign(films, tmp_path, suffix):
    target = tmp_path / f"d{suffix}"
    assert run(*films[:2], "-o", target, "--no-flip").exit_code == 0
    a, b = (read_image(path) for path in films[:2])
    assert np.array_equal(read_image(target), a - b)


def test_side_by_side_pictures_show_all_and_the_difference(films, tmp_path):
    pytest.importorskip("matplotlib")
    from PIL import Image

    target = tmp_path / "c.png"
    done = run(*films[:2], "-o", target, "--no-flip")
    assert done.exit_code == 0, done.output
    with Image.open(target) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    # Two pictures of 360 pixels in a row with three gaps, and two rows.
    assert pixels.shape[1] == 2 * 360 + 3 * 14
    assert pixels.shape[0] > 2 * 300
    grey = np.ptp(pixels[380:640, 20:360], axis=2)
    assert grey.max() > 50, "the difference is in colour"


def test_the_page_asks_nobody_for_anything(films, tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    target = tmp_path / "c.html"
    done = run(films[0], films[2], "--reference", films[1], "-o", target)
    assert done.exit_code == 0, done.output
    page = target.read_text("utf-8")
    assert not re.search(r"""(src|href)="(?!data:|#)|url\((?!"?(data:|#))|<script|@import""", page)
    assert page.count("data:image/png") >= 3
    assert DIFFERENT in page
    for path in films:
        assert path.name in page


def test_names_are_escaped(films, tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("jinja2")
    odd = tmp_path / "a<b>&c.exr"
    films[0].rename(odd)
    assert run(odd, films[1], "-o", tmp_path / "c.html", "--no-flip").exit_code == 0
    page = (tmp_path / "c.html").read_text("utf-8")
    assert "a<b>" not in page
    assert "a&lt;b&gt;&amp;c.exr" in page


def test_a_picture_without_known_noise_has_its_column_beside_one_that_has():
    known = np.full((24, 32, 3), 0.1, np.float32)
    truth = Input("truth", picture(24, 32), False)
    pair = [
        compare_inputs(Input(name, picture(24, 32) + 0.01, False, error, n), truth, slow=False)
        for name, error, n in (("noisy", known, 4), ("bare", None, 0))
    ]
    for found in (pair, pair[::-1]):
        rows = dict(figure_rows(found))
        assert all(len(values) == 2 for values in rows.values())
        for name in ("rms z (R, G, B)", "Largest |z|"):
            unknown = [one.agreement is None for one in found]
            assert [value == "–" for value in rows.get(name, ())] == unknown


def test_a_panel_says_which_picture_is_the_reference(films, tmp_path, monkeypatch):
    axes = pytest.importorskip("matplotlib.axes").Axes
    told, text = [], axes.text

    def kept(self, x, y, words, **style):
        told.append(words)
        return text(self, x, y, words, **style)

    monkeypatch.setattr(axes, "text", kept)
    words = films[0], films[2], "--reference", films[1], "-o", tmp_path / "a.png", "--no-flip"
    assert run(*words).exit_code == 0
    for name, role in (("a.exr", "picture A"), ("c.exr", "picture B"), ("b.exr", "reference")):
        assert told[told.index(name) + 1] == role
