"""The other commands, help, and what a fresh process imports."""

import os
import subprocess
import sys

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import alight
from alight import __version__
from alight.cli import doctor, progress
from alight.cli.main import app
from alight.cli.progress import ProgressBar
from alight.core.extras import install_command
from alight.formats import builtin_names
from alight.lab.info import tree_lines
from alight.rendering import Progress


def run(*arguments):
    result = CliRunner().invoke(app, list(arguments))
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def in_new_process(*arguments):
    """Exit code and output of ``python -m alight``, and which heavy modules it imported."""
    probe = (
        "import sys, atexit\n"
        "atexit.register(lambda: print('loaded:', *sorted(set(sys.modules) & {'numba', 'llvmlite',"
        " 'OpenEXR', 'PIL', 'trimesh'})))\n"
        "from alight.cli.main import app\n"
        f"app({list(arguments)!r})\n"
    )
    return subprocess.run(
        [sys.executable, "-c", probe], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    "arguments", [["--help"], ["render", "--help"], ["scenes"], ["info", "cornell-box"]]
)
def test_light_commands_import_no_compiler(arguments):
    done = in_new_process(*arguments)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "loaded:"


def test_help_answers_within_half_a_second():
    # Processor time: what others do on this machine must not count. A core that is shared is slower
    # all the same, so the quickest of some counts.
    times = []
    while not times or (min(times) > 0.5 and len(times) < 12):
        before = os.times()
        subprocess.run([sys.executable, "-m", "alight", "--help"], capture_output=True, check=True)
        after = os.times()
        user, system = after.children_user, after.children_system
        times.append(user - before.children_user + system - before.children_system)
    assert min(times) <= 0.5


def test_help_lists_the_commands():
    output = run("--help").output
    for command in ("render", "info", "scenes", "doctor"):
        assert command in output


def test_version():
    assert run("--version").output == f"alight {__version__}\n"


def test_a_misspelt_command_names_the_nearest():
    result = run("rendr")
    assert result.exit_code == 2
    assert "render" in result.stderr


def test_scenes_have_a_line_each():
    lines = run("scenes").output.splitlines()
    assert [line.split()[0] for line in lines] == list(builtin_names())
    assert all(len(line.split(maxsplit=1)[1]) > 20 for line in lines)


def test_info_counts_what_a_scene_holds():
    lines = dict(line.split(maxsplit=1) for line in run("info", "cornell-box").output.splitlines())
    assert lines["film"] == "512x512 pixels, box filter"
    assert lines["camera"] == "pinhole"
    assert lines["shapes"].startswith("8 (") or "rectangle" in lines["shapes"]
    assert lines["lights"] == "1 (1 area)"
    assert lines["bsdfs"] == "3 (3 diffuse)"


def test_info_takes_changes_and_refuses_wrong_ones():
    changed = run("info", "cornell-box", "--set", "film.size=[64, 32]")
    assert "64x32 pixels" in changed.output
    wrong = run("info", "cornell-bix")
    assert wrong.exit_code == 2
    assert 'did you mean "cornell-box"?' in wrong.stderr


def test_info_shows_the_tree_and_the_accelerator():
    output = run("info", "cornell-box", "--tree").output
    assert "\nscene\n" in output
    assert "\naccelerator  " in output
    assert "── " in output
    assert "rectangle, bsdf white" in output


def test_the_tree_shows_what_instances_are_of():
    scene = alight.load({
        "alight": 1, "camera": {"type": "pinhole"},
        "prototypes": {
            "leaf": {"children": {"blade": {"shape": "disk"}}}, "bud": {"shape": "cube"},
        },
        "nodes": {"oak": {"instance": "leaf"}, "rose": {"children": {"top": {"instance": "bud"}}}},
    })  # fmt: skip
    assert list(tree_lines(scene)) == [
        "scene", "├── oak  instance of leaf", "└── rose", "    └── top  instance of bud",
        "prototypes", "├── leaf", "│   └── blade  disk", "└── bud  cube",
    ]  # fmt: skip


def test_deep_trees_are_shown(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "alight.lab.info.accelerator_facts", lambda flat: [("accelerator", "nodes 7")]
    )
    text = "{shape: {type: sphere}}"
    for _ in range(20):
        text = f"{{children: {{n: {text}}}}}"
    path = tmp_path / "deep.yaml"
    path.write_text(f"alight: 1\ncamera: {{type: pinhole}}\nnodes: {{top: {text}}}\n")
    output = run("info", str(path), "--tree").output
    assert output.count("── n") == 20
    assert "warning: the scene has no light" in run("info", str(path)).stderr


def test_doctor_says_what_the_machine_offers():
    result = run("doctor")
    for name in ("python", "processor", "lanes", "threads", "kernel cache"):
        assert name in result.output


def test_doctor_names_the_command_that_mends_a_missing_extra(monkeypatch):
    monkeypatch.setattr(
        doctor.metadata, "requires",
        lambda name: ["numpy>=2", "nosuchcore>=1", 'nosuchextra>=1; extra == "lab"'],
    )  # fmt: skip
    result = run("doctor")
    assert result.exit_code == 1
    assert "BAD nosuchcore        missing; pip install nosuchcore" in result.output
    assert f"extra lab         missing nosuchextra; {install_command('lab')}" in result.output


#: They read neither scenes nor tone curves.
WITHOUT_MODELS = {"cluster keys", "cluster status", "doctor", "scene random", "scenes"}


def test_every_command_that_needs_models_takes_those_of_scripts():
    found = {}
    for name, command in get_command(app).commands.items():
        for below, inner in getattr(command, "commands", {"": command}).items():
            words = {option for parameter in inner.params for option in parameter.opts}
            found[f"{name} {below}".strip()] = "--plugin" in words
    assert {name for name, takes in found.items() if not takes} == WITHOUT_MODELS


def test_doctor_works_without_installation(monkeypatch):
    def unknown(name):
        raise doctor.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.metadata, "requires", unknown)
    assert "alight runs from its source folder" in run("doctor").output


def test_an_unwritable_cache_is_said(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("ALIGHT_CACHE", str(tmp_path / "file"))
    result = run("doctor")
    assert result.exit_code == 1
    assert "cannot be written: every run compiles again; set ALIGHT_CACHE" in result.output


# ---------------------------------------------------------------------------- progress


class FilmOfKnownError:
    warnings = ()

    def relmse_estimate(self, literature=True):
        class Estimate:
            class relrmse:
                value = 0.125

        return Estimate


def shown(bar):
    task = bar._bar.tasks[0]
    return task.description, task.completed, task.total, task.fields["rate"], task.fields["error"]


def test_progress_shows_rate_and_error(monkeypatch):
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    bar = ProgressBar()
    bar(Progress("compile", 0, 0, 0.0, FilmOfKnownError()))
    assert shown(bar)[0] == "compiling kernels (first run only)"
    bar(Progress("render", 3_000_000, 12_000_000, 2.0, FilmOfKnownError()))
    assert shown(bar) == ("rendering", 3e6, 12e6, "1.50 Msamples/s", "error 12.5%")


def test_a_pipe_is_told_in_one_line_that_compiling_takes_long(monkeypatch, capfd):
    monkeypatch.setattr(progress, "_LONG", 0.0)
    for quiet in (False, True):
        with ProgressBar(quiet) as bar:
            for _ in range(2):
                bar(Progress("compile", 0, 0, 0.0, FilmOfKnownError()))
                if not quiet:
                    bar._timer.join()
                bar(Progress("render", 1, 2, 0.1, FilmOfKnownError()))
        assert capfd.readouterr().err == ("" if quiet else "compiling kernels (first run only)\n")


def test_a_pipe_is_not_told_of_kernels_that_are_there(capfd):
    with ProgressBar() as bar:
        bar(Progress("compile", 0, 0, 0.0, FilmOfKnownError()))
        timer = bar._timer
        bar(Progress("render", 1, 2, 0.1, FilmOfKnownError()))
        timer.join()
    assert capfd.readouterr().err == ""


def test_progress_towards_a_time_limit():
    bar = ProgressBar(quiet=True, time_limit=10.0)
    bar(Progress("render", 3_000_000, 0, 2.5, FilmOfKnownError()))
    assert shown(bar)[1:3] == (2.5, 10.0)
    # Samples asked for as well: what ends first counts.
    bar(Progress("render", 9_000_000, 10_000_000, 5.0, FilmOfKnownError()))
    assert shown(bar)[1:3] == (9e6, 10e6)
    bar(Progress("render", 9_000_000, 90_000_000, 5.0, FilmOfKnownError()))
    assert shown(bar)[1:3] == (5.0, 10.0)


def test_progress_keeps_the_film_for_an_interruption():
    bar, film = ProgressBar(quiet=True), FilmOfKnownError()
    assert bar.phase == "load"
    bar(Progress("render", 1, 2, 0.1, film))
    assert bar.film is film
    assert bar.phase == "render"
