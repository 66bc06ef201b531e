"""What renders in a terminal show and write: bars, signals, and the last lines after a stop."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np
import typer

from alight.cli import frames
from alight.cli.finishing import run_and_finish
from alight.cli.interrupts import cancelling
from alight.cli.progress import ProgressBar
from alight.cli.study import StudyBar
from alight.cli.warm import WarmBar
from alight.core.errors import FilmError
from alight.films import Film
from alight.lab.replicates.session import StudyProgress
from alight.lab.warm import WarmProgress
from alight.options.animation import AnimationOptions
from alight.outputs.display import Display
from alight.rendering import Progress
from alight.rendering.writing import Targets
from tests.recorded.making import described, film_of, in_folder, masked


class Line:
    """Keeps what a bar is told."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def keep(*values: Any, **words: Any) -> int:
            self.told.append([name, *map(str, values), described(words)])
            return len(self.told)

        return keep


def bars() -> dict[str, Any]:
    """What bars show of renders, studies and compiled scenes, on a terminal and in a file."""
    film, found = film_of(spp=8), {}
    dark = film_of(spp=0)
    steps = (
        Progress("compile", 0, 0, 0.0, dark), Progress("light", 0, 0, 0.0, dark),
        Progress("render", 0, 0, 0.0, dark), Progress("render", 2e6, 8e6, 0.5, film, "a note"),
        Progress("render", 3e6, 0, 1.5, film), Progress("render", 4e6, 8e6, 1.6, film),
        Progress("render", 5e6, 8e6, 9e9, dark),
    )  # fmt: skip
    for hidden in (False, True):
        for limit in (None, 2.0):
            bar = ProgressBar(False, limit)
            bar._hidden = hidden
            bar._bar = line = Line()
            bar.title = "frame 3: "
            for step in steps:
                bar(step)
                line.told.append([bar.phase, bar.film is step.film])
            bar._timer.cancel()
            found[f"hidden {hidden}, limit {limit}"] = line.told
    study, warm = StudyBar(True), WarmBar(True)
    study._bar = warm._bar = line = Line()
    with contextlib.redirect_stderr(io.StringIO()) as said:
        for one in (("a", 1.0, 4.0, ("x",)), ("b", 2.0, 4.0, ("x", "y")), ("c", 0.0, 0.0)):
            study(StudyProgress(*one))
        warm(WarmProgress("fog", 1, 2))
        speaks = ProgressBar()
        speaks._say("a text")
    found["others"] = [line.told, said.getvalue()]
    return found


def signals() -> list[Any]:
    """The first signal while rendering asks to stop, others interrupt; handlers are put back."""
    found: list[Any] = []
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]
    for phase, sent in (
        ("render", (signal.SIGTERM,)), ("render", (signal.SIGINT, signal.SIGTERM)),
        ("compile", (signal.SIGTERM,)), ("render", ()),
    ):  # fmt: skip
        cancel, raised = threading.Event(), 0
        with cancelling(cancel, SimpleNamespace(phase=phase)) as interruption:  # type: ignore[arg-type]
            for one in sent:
                try:
                    os.kill(os.getpid(), one)
                    signal.sigpending()
                except KeyboardInterrupt:
                    raised += 1
        found.append([phase, len(sent), cancel.is_set(), raised, interruption.exit_code])
    after = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)]
    return [*found, before == after]


def ends() -> dict[str, Any]:
    """Renders that end, are stopped, and break: what is said, and which files are left."""
    found: dict[str, Any] = {}

    def interrupted(progress: Any, cancel: Any) -> Film:
        raise KeyboardInterrupt

    def broken(progress: Any, cancel: Any) -> Film:
        raise ZeroDivisionError("a bug")

    def refused(progress: Any, cancel: Any) -> Film:
        raise FilmError("no such film")

    def shown_then(what: Callable[..., Film], film: Film) -> Callable[..., Film]:
        def render(progress: Any, cancel: Any) -> Film:
            progress(Progress("render", 1, 2, 1.0, film))
            return what(progress, cancel)

        return render

    def cancelled(progress: Any, cancel: Any) -> Film:
        cancel.set()
        return film_of((4, 3), spp=4)

    def whole(progress: Any, cancel: Any) -> Film:
        film = film_of((4, 3), spp=8)
        film.stats = {
            "seconds": {"load": 0.1, "compile": 0.2, "bvh": 0.0, "render": 1.5}, "spp": film.spp,
            "msamples_per_s": 1.25, "rays": 10, "peak_rss_mb": 99.0,
        }  # fmt: skip
        return film

    some, none = film_of((4, 3), spp=8), film_of((4, 3), spp=0)
    for name, render, checkpoint, folder in (
        ("whole", whole, False, "."), ("cancelled", cancelled, True, "."),
        ("interrupted", shown_then(interrupted, some), False, "."),
        ("before the first sample", shown_then(interrupted, none), True, "."),
        ("at once", interrupted, False, "."), ("broken", shown_then(broken, some), True, "."),
        ("refused", refused, True, "."), ("nowhere to write", cancelled, False, "none"),
    ):  # fmt: skip
        for quiet in (False, True):
            with in_folder({"a.checkpoint": "x"} if checkpoint else {}):
                targets = Targets(
                    [Path(folder) / "a b.exr", Path("c.png")], Display(),
                    checkpoint=Path("a.checkpoint"), plugins=[Path("p.py")],
                )  # fmt: skip
                out, err = io.StringIO(), io.StringIO()
                with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                    try:
                        run_and_finish(
                            render, targets, quiet=quiet, time_limit=None, warnings=("w", "w", "v")
                        )
                        ended: Any = "ended"
                    except typer.Exit as stop:
                        ended = stop.exit_code
                    except Exception as error:
                        ended = described(error)
                files = sorted(p.name for p in Path().iterdir())
                said = [masked(one.getvalue()) for one in (out, err)]
                found[f"{name}{', quiet' * quiet}"] = [ended, *said, files]
    return found


class Made:
    """Frames 3 to 8 of which two were there; a film that plays at another speed."""

    scene = SimpleNamespace(source=SimpleNamespace(remarks=SimpleNamespace(notes=("a", "b"))))
    prepared = SimpleNamespace(warnings=lambda spell: [f"of {spell('spp')}"])
    warnings = ("of a frame",)
    numbers, current, goes_on = range(3, 9), 4, True

    def __init__(self, scene: str, options: Any) -> None:
        self.options = options
        self.kept: list[int] = [3, 4] if scene == "kept" else []
        self.films = [Path("a.gif"), Path("b.apng")]

    def render(self) -> list[Path]:
        """Render and report."""
        self.options.progress(Progress("render", 1, 2, 1.0, film_of((4, 3), spp=8)))
        return [Path("1"), Path("2")] if self.kept else [Path("1")]


def animations() -> dict[str, Any]:
    """The last lines of animations."""
    found: dict[str, Any] = {}
    for name, quiet, fps in (("kept", False, 24), ("new", False, 25), ("new", True, 24)):
        out, err = io.StringIO(), io.StringIO()
        with (
            contextlib.redirect_stdout(out), contextlib.redirect_stderr(err),
            mock.patch("alight.rendering.animation.Animation", Made),
        ):  # fmt: skip
            options = AnimationOptions(fps=fps)
            frames.render_frames(name, options, lambda word: f"--{word}", quiet=quiet)
        found[f"{name} at {fps}{', quiet' * quiet}"] = [out.getvalue(), err.getvalue()]
    return found


def numbers() -> dict[str, Any]:
    """Errors that are told beside the bar, unknown and known."""
    unknown, known = film_of(spp=1, replicates=1), film_of(spp=8)
    bar = ProgressBar()
    bar._hidden, said = False, []
    for film, seconds in ((unknown, 0.5), (known, 0.5), (known, 2.0), (unknown, 1e9)):
        bar._bar = Line()
        said.append(bar._current_error(Progress("render", 1, 2, seconds, film)))
    return {"errors": said, "waits": bool(np.isfinite(bar._next_error))}


CASES = {
    "bars": bars,
    "signals": signals,
    "ends": ends,
    "animations": animations,
    "numbers": numbers,
}
