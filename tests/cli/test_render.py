"""``alight render``: options reach the renderer, files are written, mistakes cost no time."""

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.outputs import read_image
from alight.outputs.display import Display
from alight.outputs.exr import read_layers
from alight.rendering.writing import Targets
from tests.cli.stub import StubRender

SMALL = ["--size", "24x16", "--spp", "16"]


@pytest.fixture
def alight(monkeypatch, tmp_path):
    """Run the command line in an empty folder with a stub for the renderer."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments, stub=None):
        run.stub = stub or StubRender()
        monkeypatch.setattr("alight.rendering.main_loop.render_film", run.stub)
        result = CliRunner().invoke(app, [str(a) for a in arguments])
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return run


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


# ---------------------------------------------------------------------------- what it does


def test_the_default_is_the_cornell_box_named_after_the_scene(alight, tmp_path):
    result = alight("render", *SMALL)
    assert result.exit_code == 0, result.output
    assert names_in(tmp_path) == ["cornell-box.png"]
    assert alight.stub.scene.film.size == (24, 16)
    assert read_image("cornell-box.png").shape == (16, 24, 3)


def test_the_last_lines_say_time_rate_error_and_file(alight):
    lines = alight("render", *SMALL, "-o", "a.exr").stdout.splitlines()
    assert len(lines) == 3
    assert lines[0].startswith("24x16 pixels, 16 spp in 1.50 s, 1.25 Msamples/s (")
    assert lines[1].startswith("estimated error: ")
    assert "% relRMSE (95 %: " in lines[1]
    assert lines[2] == "picture: a.exr"


def test_options_reach_the_renderer(alight):
    result = alight(
        "render", *SMALL, "--seed", 5, "--time", 9, "--threads", 3, "--replicates", 8,
        "--spp-per-pass", 2, "--first-sample", 64, "--aov", "direct,indirect", "-o", "a.exr",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    words = ("spp", "time_limit", "seed", "threads", "replicates", "spp_per_pass", "first_sample",
             "aovs")  # fmt: skip
    assert alight.stub.options.given(*words) == {
        "spp": 16, "time_limit": 9.0, "seed": 5, "threads": 3, "replicates": 8,
        "spp_per_pass": 2, "first_sample": 64, "aovs": ("direct", "indirect"),
    }  # fmt: skip


def test_options_change_the_scene(alight):
    result = alight(
        "render", *SMALL, "--crop", "4,2,8,8", "--integrator", "path", "--max-depth", 3,
        "--rr-depth", 2, "--sampler", "independent", "--filter", "tent",
        "--set", "bsdfs.white.reflectance=[0.5, 0.5, 0.5]", "--set", "integrator.max_depth=4",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    scene = alight.stub.scene
    assert scene.film.crop == (4, 2, 8, 8)
    assert scene.film.filter.type_name() == "tent"
    assert scene.sampler.type_name() == "independent"
    # --set comes last.
    assert (scene.integrator.max_depth, scene.integrator.rr_depth) == (4, 2)
    assert scene.bsdfs["white"].reflectance == (0.5, 0.5, 0.5)
    assert alight.stub.options.replicates is None


def test_several_files_of_one_render(alight, tmp_path):
    result = alight(
        "render", *SMALL, "-o", "a.exr", "-o", "a.png", "--exposure", 1, "--aov", "direct"
    )
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert names_in(tmp_path) == ["a.exr", "a.png"]
    channels, attributes = read_layers("a.exr")
    assert {"R", "standard_error.R", "samples", "direct.R"} <= channels.keys()
    assert attributes["spp"] == "16.0"


def test_statistics_are_json_with_both_errors(alight):
    result = alight("render", *SMALL, "--stats", "stats.json", "--quiet")
    assert result.exit_code == 0, result.output
    assert result.output == ""
    stats = json.loads(Path("stats.json").read_text())
    assert stats["seconds"].keys() == {"load", "compile", "bvh", "render"}
    assert {"spp", "msamples_per_s", "rays", "peak_rss_mb"} <= stats.keys()
    assert stats["relmse"]["low"] < stats["relmse"]["value"] < stats["relmse"]["high"]
    assert stats["relmse_literature"]["epsilon"] == 0.01
    assert stats["provenance"]["seed"] == 0
    assert stats["outputs"] == ["cornell-box.png"]


def test_unknown_errors_are_null_and_said_to_be_unknown(alight):
    result = alight(
        "render", "--size", "8x8", "--spp", "4", "--replicates", "1", "--stats", "s.json"
    )
    assert "estimated error: unknown" in result.stdout
    assert json.loads(Path("s.json").read_text())["relmse"]["value"] is None


def test_invalid_and_saturated_samples_are_reported(alight):
    nan = alight("render", *SMALL, stub=StubRender(value=float("nan")))
    assert f"warning: {24 * 16 * 16} samples were NaN or infinite" in nan.stderr
    huge = alight("render", *SMALL, stub=StubRender(value=1e20))
    assert f"warning: {24 * 16 * 16 * 3} sample values were cut to 2^36" in huge.stderr


def test_a_scene_without_light_says_so(alight, tmp_path):
    scene = tmp_path / "dark.yaml"
    scene.write_text(
        "alight: 1\n"
        "camera: {type: pinhole}\n"
        "film: {size: [8, 8]}\n"
        "nodes: {ball: {shape: {type: sphere}, transform: {translate: [0, 0, -3]}}}\n"
    )
    result = alight("render", scene, "--spp", 4)
    assert result.exit_code == 0, result.output
    assert "warning: the scene has no light: the picture will be black" in result.stderr
    assert (tmp_path / "dark.png").exists()


def test_the_automatic_exposure_is_said(alight):
    lines = alight("render", *SMALL, "-o", "a.png", "-o", "a.npy", "--exposure", "auto").stdout
    middle = np.log2(read_image("a.npy") @ np.array([0.2126, 0.7152, 0.0722])).mean()
    assert f"exposure: {np.log2(0.18) - middle:+.2f} stops" in lines.splitlines()
    assert "exposure" not in alight("render", *SMALL, "-o", "a.exr", "--exposure", "auto").stdout


def test_denoising_asks_for_the_layers_that_help(alight, monkeypatch):
    monkeypatch.setattr("alight.films.denoising.check_denoiser", lambda: None)
    alight("render", *SMALL, "-o", "a.alight", "--denoise", "--aov", "albedo,albedo_through")
    assert alight.stub.options.aovs == ("albedo", "albedo_through", "normal_through")


def test_options_without_effect_are_warned_of(alight):
    result = alight("render", *SMALL, "-o", "a.npy", "--tone-map", "aces", "--aov", "direct")
    assert "--exposure, --white-balance, --tone-map and --bits change" in result.stderr
    assert "--aov: only EXR keeps layers" in result.stderr
    quiet = alight(
        "render", "material-ball", "--size", "8x8", "--background", "transparent", "-o", "a.png"
    )
    assert "--aov" not in quiet.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--confidence 99%", "--confidence does nothing without --error"),
        ("--share 50%", "--share does nothing without --error"),
        ("--share 50% --error 90%", "--share does nothing without --metric pixel"),
        ("--every 10m", "--every does nothing without --checkpoint"),
        ("--dpi 300 -o a.hdr", "--dpi: only PNG, JPEG and EXR keep it"),
        ("--background transparent -o a.jpg", "--background: only EXR and PNG keep alpha"),
        ("--bits 16 -o a.jpg", "--bits: only PNG has 16"),
        ("--error 5", "--error: asks for 500 %; did you mean 5%?"),
    ],
)
def test_words_that_need_others_are_warned_of(alight, words, said):
    spp = () if "--error" in words else ("--spp", "1")
    assert said in alight("render", "material-ball", "--size", "8x8", *spp, *words.split()).stderr
    more = "--error 90% --metric pixel --checkpoint a.checkpoint -o b.png"
    quiet = alight("render", "material-ball", "--size", "8x8", *words.split(), *more.split())
    for text in ("does nothing", "keep", "only PNG", "asks for"):
        assert text not in quiet.stderr


@pytest.mark.parametrize(("names", "told"), [(["a.alight"], 1), (["a.alight", "a.exr"], 0)])
def test_a_film_alone_is_never_denoised_and_that_is_told(names, told):
    targets = Targets([Path(name) for name in names], Display(), denoise=True)
    assert len(targets.useless([], False)) == told


# ---------------------------------------------------------------------------- Ctrl-C


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_writes_what_there_is_beside_the_target(alight, tmp_path):
    (tmp_path / "out.png").write_bytes(b"the good picture")
    stub = StubRender(during={"render": interrupt})
    result = alight("render", *SMALL, "-o", "out.png", stub=stub)
    assert result.exit_code == 130
    assert result.stderr == "stopped at 4 spp; the samples so far are in out.partial.exr\n"
    assert (tmp_path / "out.png").read_bytes() == b"the good picture"
    channels, _ = read_layers("out.partial.exr")
    assert (channels["samples"] == 4).all()
    assert np.isfinite(channels["standard_error.G"]).all()


def test_a_renderer_that_raises_keyboard_interrupt_loses_nothing(alight, tmp_path):
    def raise_it():
        raise KeyboardInterrupt

    result = alight("render", *SMALL, stub=StubRender(during={"render": raise_it}))
    assert result.exit_code == 130
    assert names_in(tmp_path) == ["cornell-box.partial.exr"]


def test_ctrl_c_before_the_first_sample_writes_nothing(alight, tmp_path):
    result = alight("render", *SMALL, stub=StubRender(during={"compile": interrupt}))
    assert result.exit_code == 130
    assert result.stderr == "stopped before the first samples; nothing was written\n"
    # At once: compiling is not waited for.
    assert not alight.stub.compiled
    assert names_in(tmp_path) == []


def test_the_handler_of_ctrl_c_is_put_back(alight):
    before = signal.getsignal(signal.SIGINT)
    alight("render", *SMALL)
    assert signal.getsignal(signal.SIGINT) is before


# ---------------------------------------------------------------------------- bad input

MISTAKES = {
    "suffix": (["-o", "a.pgn"], 'cannot write a.pgn: unknown suffix ".pgn"; did you mean ".png"?'),
    "no suffix": (["-o", "picture"], "cannot write picture: the name has no suffix"),
    "folder": (["-o", "none/a.png"], "none does not exist"),
    "stats folder": (["--stats", "none/s.json"], "none does not exist"),
    "scene": (["cornel-box"], 'did you mean "cornell-box"?'),
    "integrator": (["--integrator", "pth"], 'unknown integrator "pth"; did you mean "path"?'),
    "sampler": (["--sampler", "sobl"], 'unknown sampler "sobl"; did you mean "sobol"?'),
    "filter": (["--filter", "gausian"], 'unknown filter "gausian"; did you mean "gaussian"?'),
    "tone map": (["--tone-map", "acess"], 'unknown tone map "acess"; did you mean "aces"?'),
    "exposure": (["--exposure", "1000"], 'lie in [-100, 100] stops, got "1000"'),
    "bits": (["--bits", "9"], "bits per channel must be 8 or 16, got 9"),
    "size": (
        ["--size", "big"],
        '--size: must be WIDTHxHEIGHT in pixels or on paper, as 512x512 or 9x6cm, got "big"',
    ),
    "no pixels": (["--size", "0x4"], "film.size"),
    "too many pixels": (["--size", "99999x99999"], "film"),
    "crop": (["--crop", "1,2,3"], '--crop: must be X,Y,WIDTH,HEIGHT in pixels, got "1,2,3"'),
    "crop outside": (["--crop", "500,0,100,100"], "must lie inside"),
    "depth": (["--max-depth", "0"], "integrator.max_depth"),
    "replicates": (
        ["--replicates", "0"],
        "--replicates: must be a whole number in [1, 1024], got 0",
    ),
    "set": (["--set", "bsdfs.withe.reflectance=1"], 'did you mean "white"?'),
    "set without value": (["--set", "film"], "must be path.to.key=value"),
    "layer": (["--aov", "wrong"], '--aov: unknown layer "wrong"'),
    "spp": (["--spp", "0"], "--spp: must be a whole number in [1, 2147483647], got 0"),
    "no number": (
        ["--spp", "many"],
        '--spp: must be a whole number in [1, 2147483647], got "many"',
    ),
    "option": (["--sead", "1"], "--seed"),
}


@pytest.mark.parametrize(("arguments", "message"), MISTAKES.values(), ids=MISTAKES.keys())
def test_mistakes_give_one_message_and_exit_code_2(alight, tmp_path, arguments, message):
    result = alight("render", *arguments)
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert "Traceback" not in result.output
    assert result.stdout == ""
    assert names_in(tmp_path) == []


def test_a_broken_scene_file_gives_all_its_errors_with_their_places(alight, tmp_path):
    (tmp_path / "bad.yaml").write_text("alight: 1\nfilm: {size: [0, 4]}\ncamra: {}\n")
    result = alight("render", "bad.yaml")
    assert result.exit_code == 2
    assert "bad.yaml:2:" in result.stderr
    assert "bad.yaml:3:" in result.stderr
    assert 'did you mean "camera"?' in result.stderr


def test_mistakes_are_found_before_rendering(alight):
    alight("render", "-o", "none/a.png")
    assert alight.stub.scene is None


def test_a_disk_that_fills_while_rendering_gives_one_message(alight, tmp_path, monkeypatch):
    # Where the samples are kept instead.
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    stub = StubRender(during={"render": lambda: (tmp_path / "gone").rename(tmp_path / "away")})
    (tmp_path / "gone").mkdir()
    result = alight("render", "--size", "8x8", "--spp", "4", "-o", "gone/a.png", stub=stub)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: cannot write gone/a.png: the folder ")
