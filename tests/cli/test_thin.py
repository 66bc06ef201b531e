"""Commands only pass on what was typed: each calls one function, and prints what that returns."""

import json
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
from typer.main import get_command
from typer.testing import CliRunner

import alight
from alight.cli.frames import render_frames
from alight.cli.main import app
from alight.cli.reporting import reporting_errors
from alight.cluster import addresses
from alight.cluster.status import Losses, WorkerStatus
from alight.options.animation import AnimationOptions
from lanewise.machine import NATIVE


def run(*words):
    return CliRunner().invoke(app, list(words))


def commands():
    """(words, command of click) of all commands."""
    for name, command in get_command(app).commands.items():
        inside = getattr(command, "commands", None)
        yield from ((f"{name} {n}", c) for n, c in inside.items()) if inside else [(name, command)]


class Answer:
    """What a function of the package returns to a command."""

    exceeded = ()

    def to_dict(self):
        return {"answer": 42}

    def remarks(self):
        return ["a remark"]

    def __str__(self):
        return "the answer"


#: Words of a command, the function that they call, and its arguments before the options.
CALLS = {
    "compare one.exr two.exr": ("compare", "one.exr", "two.exr"),
    "info fog.yaml": ("info", "fog.yaml"),
    "plan fog.yaml": ("plan", "fog.yaml"),
    "trace cornell-box --pixel 3,5": ("trace", "cornell-box", (3, 5)),
    "guide cornell-box --pixel 3,5": ("guide", "cornell-box", (3, 5)),
    "why cornell-box": ("why", "cornell-box"),
}


@pytest.fixture
def called(monkeypatch):
    """Let functions of the package keep their arguments, and do nothing else."""
    kept = []

    def keeper(name):
        def keep(*arguments, **named):
            assert not named
            kept.append((name, *arguments))
            return Answer()

        return keep

    for name in {one[0] for one in CALLS.values()}:
        monkeypatch.setattr(alight, name, keeper(name))
    monkeypatch.setattr("alight.options.loading.scene_of", lambda name, options: Loaded(name))
    monkeypatch.setattr(
        "alight.compiled.warnings.scenes.warnings_of_scene", lambda scene: scene.warnings
    )
    return kept


class Loaded(str):
    """A scene that was read already: its name, here."""

    warnings = ("it is dark",)


@pytest.mark.parametrize("words", CALLS)
def test_a_command_passes_on_what_was_typed(called, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    done = run(*words.split())
    assert done.exit_code == 0, done.output
    name, *arguments = CALLS[words]
    ((asked, *given, options),) = called
    paths = [str(one) if isinstance(one, Path) else one for one in given]
    assert (asked, paths) == (name, arguments)
    assert set(options.given()) <= {"output", "progress"}
    assert "the answer" in done.stdout
    told = {"info": "a remark\n", "compare": "", "plan": ""}
    assert done.stderr == told.get(name, "warning: it is dark\n")


@pytest.mark.parametrize("words", [one for one in CALLS if one.split()[0] not in ("info", "plan")])
def test_numbers_as_json_are_all_that_is_printed(called, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    done = run(*words.split(), "--json")
    assert json.loads(done.stdout) == {"answer": 42}


def test_what_compare_finds_too_different_is_told_by_the_exit_code(called, monkeypatch):
    monkeypatch.setattr(Answer, "exceeded", ("rmse is above 1",))
    done = run("compare", "one.exr", "two.exr", "--json")
    assert (done.exit_code, done.stderr) == (1, "rmse is above 1\n")
    assert json.loads(done.stdout) == {"answer": 42}


@pytest.mark.parametrize(("words", "command"), list(commands()), ids=str)
def test_every_command_reports_what_its_user_can_mend(words, command):
    """Else the mistake would end in a traceback."""
    layers, one = [], command.callback
    while one is not None:
        layers.append(one.__code__)
        one = getattr(one, "__wrapped__", None)
    assert reporting_errors(lambda: None).__code__ in layers


def test_the_status_of_a_cluster_is_that_of_what_renders_use(monkeypatch):
    """Unless another is asked for, of the native target; sums are over what may be used."""
    asked = []

    def workers_of(client, target):
        asked.append(target)
        about = {"tasks": 0, "memory": 2**20, "kind": "test", "rate": 0.0}
        return [
            WorkerStatus(address=f"tls://{n}", threads=n, trouble=trouble, **about)
            for n, trouble in ((1, ""), (2, "lanes is another"), (4, ""))
        ]

    monkeypatch.setattr("alight.cluster.status.workers_of", workers_of)
    monkeypatch.setattr("alight.cluster.status.losses_of", lambda client: Losses(2, 7))
    monkeypatch.setattr("alight.cluster.status.dashboard_of", lambda client: None)
    monkeypatch.setattr(addresses, "connected", lambda where, keys: nullcontext())
    done = run("cluster", "status", "local:3")
    assert run("cluster", "status", "local:3", "--target", "portable").exit_code == 0
    assert asked == [NATIVE, "portable"]
    *workers, sums, lost = done.stdout.splitlines()
    assert [line.split()[0] for line in workers] == ["tls://1", "tls://2", "tls://4"]
    assert sums == "3 workers; threads that give this machine's bits: 5"
    assert lost == "lost since the scheduler was started: 2 workers, 7 tasks"


@pytest.mark.parametrize(
    ("goes_on", "again"), [(True, "goes on there"), (False, "starts at frame 3 again: only EXR")]
)
def test_frames_that_were_stopped_say_where_the_same_command_begins(
    monkeypatch, capsys, goes_on, again
):
    class Stopped:
        """An animation of frames 3 to 8 that is stopped at frame 5."""

        numbers, current, kept, films, scene = range(3, 9), 5, [], [], None
        warnings = ["of a frame"]
        prepared = SimpleNamespace(warnings=lambda spell: ["of the scene"])

        def __init__(self, scene, options):
            self.goes_on, self.cancel = goes_on, options.cancel

        def render(self):
            self.cancel.set()
            return []

    monkeypatch.setattr("alight.rendering.animation.Animation", Stopped)
    with pytest.raises(typer.Exit) as ended:
        render_frames("a", AnimationOptions(), str, quiet=True)
    assert ended.value.exit_code == 130
    *warnings, last = capsys.readouterr().err.splitlines()
    assert warnings == ["warning: of the scene", "warning: of a frame"]
    assert last.startswith(f"stopped at frame 5; the same command {again}")
