"""Transcripts of commands whose work is a stand-in: what they ask for and say."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest import mock

import numpy as np
import typer

from alight import __version__
from alight.cli import doctor
from alight.cluster.status import Losses, WorkerStatus, dashboard_of, losses_of, workers_of
from alight.core.errors import OutputError
from alight.lab.make_reference import MadeReference
from alight.lab.replicates.session import StudyProgress
from alight.lab.sheet import Tile
from alight.lab.warm import Warmed, WarmProgress
from tests.recorded.cases.commands import SCENE
from tests.recorded.making import command, described, film_of, in_folder, masked

#: A scene whose only lamp is off: that is warned of.
DARK = SCENE.replace("intensity: [3, 2, 1]", "intensity: [0, 0, 0]")


class Stub:
    """Takes any call, keeps it, and gives the next of its answers, or raises it."""

    def __init__(self, *answers: Any, reports: Any = None) -> None:
        self.answers, self.reports, self.calls = list(answers), reports, []

    def __call__(self, *values: Any, **words: Any) -> Any:
        self.calls.append(described([_plain(one) for one in values]))
        named = {name: _plain(one) for name, one in words.items()}
        self.calls.append(described(named))
        progress = words.get("progress") or getattr((values or (None,))[-1], "progress", None)
        if self.reports is not None and progress is not None:
            progress(self.reports)
        answer = self.answers[min(len(self.calls) // 2, len(self.answers)) - 1]
        if isinstance(answer, BaseException):
            raise answer
        return answer(*values, **words) if callable(answer) else answer


def _plain(value: Any) -> Any:
    """What was given: options by what was said, scenes by their name."""
    if hasattr(value, "given"):
        return {name: str(getattr(value, name)) for name in value.given() if name != "progress"}
    name = type(value).__name__
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if name in ("Display", "Tile"):
        return f"{name} {list(vars(value).values())[:2]}"
    return name if name in ("Scene", "ProgressBar", "StudyBar", "WarmBar") else value


class Verdict:
    """What `alight.check` found."""

    warnings = ("twice", "once", "twice")

    def __init__(self, ok: bool) -> None:
        self.ok = ok

    def lines(self, failures_only: bool) -> list[str]:
        """Texts of findings."""
        return ["a failure"] if failures_only else ["a law holds", "a failure"]


class Found:
    """An answer with numbers and a text."""

    def to_dict(self) -> dict[str, Any]:
        """All numbers."""
        return {"numbers": [1, 2.5, None], "text": "x"}

    def __str__(self) -> str:
        return "found: 1\n  and 2"


def names_in(folder: Path) -> list[str]:
    """What a folder holds."""
    return sorted(path.name for path in folder.iterdir())


@contextlib.contextmanager
def instead(**answers: Any) -> Iterator[None]:
    """Stand-ins for what dotted names name, with two underlines for a point."""
    with contextlib.ExitStack() as stack:
        for name, answer in answers.items():
            stack.enter_context(mock.patch(name.replace("___", "._").replace("__", "."), answer))
        yield


def laboratory() -> dict[str, Any]:
    """Check, why, guide, reference, study, warm: loud, quiet, in JSON, failing and stopped."""
    found: dict[str, Any] = {}

    def tell(line: str, stubs: dict[str, Stub]) -> None:
        with instead(**stubs):
            said = command(*line.split())
        found[line] = [said, *[one.calls for one in stubs.values()]]

    with in_folder({"s.yaml": SCENE, "dark.yaml": DARK}):
        for line, ok in (
            ("check s.yaml", True), ("check dark.yaml --quiet", False),
            ("check s.yaml -o out/here --only lights", False),
        ):  # fmt: skip
            pictures = [] if ok else [Path("one.png"), Path("two.png")]
            tell(line, {
                "alight__check": Stub(Verdict(ok), reports="a material"),
                "alight__laws__scene__dump__write_failures": Stub(pictures),
            })  # fmt: skip
        for line, code in (("check s.yaml --mutant missing-cosine --quiet --seed 3", 0),
                           ("check --mutant missing-cosine", 1)):  # fmt: skip
            names = Stub(SimpleNamespace(words="a cosine", shows="in a law"))
            tell(line, {"alight__laws__mutants__find_mutant": names,
                        "alight__laws__mutants__run_with": Stub(code)})  # fmt: skip
        for verb in ("why dark.yaml", "guide dark.yaml --pixel 2,3"):
            for words in ("", " --json", " --quiet -o maps/a.png"):
                asked = "alight__" + verb.split()[0]
                tell(verb + words, {asked: Stub(Found(), reports="a pass")})
        made = MadeReference(film_of(spp=16), 64)
        for words in ("", " --quiet --seed 5 --threads 2 --error 1%"):
            asked = "alight__lab__make_reference__make_reference"
            tell(f"reference s.yaml -o r.exr{words}", {asked: Stub(made)})
        found["references"] = names_in(Path())
        report = StudyProgress("an arm", 1.0, 3.0, ("an arm is dark",))
        for words, answer in (
            ("", Found()), (" --quiet", Found()), (" --seed 4", KeyboardInterrupt()),
        ):  # fmt: skip
            tell(f"study samplers{words}", {"alight__study": Stub(answer, reports=report)})
        tell("study --list", {})
        for words, answer in (
            ("", Warmed(7, 12.4, {})), (" --quiet s.yaml", Warmed(1, 2.0, {"s.yaml": "broken"})),
            (" s.yaml fog --processes 3", Warmed(2, 70.0, {"a": "one", "b": "two"})),
            (" fog", KeyboardInterrupt()),
        ):  # fmt: skip
            tell(f"warm{words}", {
                "alight__lab__warm__warm": Stub(answer, reports=WarmProgress("fog", 1, 2)),
                "lanewise__machine__cache_folder": Stub("KERNELS"),
                "alight__rendering__resources__usable_processors": Stub(9),
            })  # fmt: skip
        out_of_memory = Stub(MemoryError("3 GB"))
        tell("info s.yaml", {"alight__info": out_of_memory})
        tell("info s.yaml --tree", {"alight__info": Stub(KeyboardInterrupt())})
    return found


def random_scenes() -> dict[str, Any]:
    """Random scenes are printed or written."""
    with in_folder({"file": "x"}):
        lines = ("--kind list", "--seed 3 --size 5x4", "--seed 3 -o a.yaml", "-o file/b.yaml",
                 "--seed 2 --kind matt-room -o c.json", "--seed -1", "-o d.txt")  # fmt: skip
        told = {}
        for line in lines:
            said = command("scene", "random", *line.split())
            if len(said["says"]) > 2000:
                said["says"] = [len(said["says"].splitlines()), said["says"][:300]]
            told[line] = said
        return {"said": told, "written": names_in(Path())}


def sheets() -> dict[str, Any]:
    """A sheet of scenes that work, fail, are too many, and stop."""
    picture = (film_of((16, 16)).image * 99).clip(0, 255).astype(np.uint8)
    tile = Tile("good", "YAML", picture, "", 16.0, 1.0, 2.0, 0.05, ("one",), ("two", "three"))
    bad = Tile("bad", "built in", None, "no such light")
    found: dict[str, Any] = {}
    with in_folder({"a/s.yaml": SCENE, "a/t.yaml": SCENE, "a/b/u.yaml": SCENE}):
        for line, answers in (
            ("a --tile 16x16", (tile, bad)), ("a --tile 16x16 --quiet", (tile, bad)),
            ("a/s.yaml -o x.png -o y.html --tile 16x16 --columns 1 --note N --spp 3", (tile,)),
            ("a fog --tile 20x16 --exposure 1 --lenient --time 3 --threads 1",
             (tile, KeyboardInterrupt())),
            ("a --tile 9x99", ()), ("a --tile x", ()), ("a -o z.txt", ()), ("none", (bad,)),
            ("cornell-bx", (bad,)),
        ):  # fmt: skip
            stub, written = Stub(*answers), Stub(None)
            with instead(
                alight__lab__sheet__render_tile=stub, alight__lab__sheet__write_sheet=written
            ):
                said = command("sheet", *line.split())
            found[line] = [said, stub.calls, written.calls]
        made = Stub(None)
        with instead(alight__cli__sheet__sheet=made):
            found["scenes --sheet"] = [command("scenes", "--sheet", "all.png"), made.calls]
        found["narrow"] = command("scenes", columns=30)
    return found


def clusters() -> dict[str, Any]:
    """What is told of a cluster's workers, keys and losses."""
    names = [*WorkerStatus.__annotations__]
    workers = [
        WorkerStatus(**dict(zip(names, one, strict=True)))
        for one in (
            ("tls://a:1", 1, 1, 2**20, "", 0.0, ""),
            ("tls://b:2", 8, 0, 5 * 2**30, "one kind", 2.34e6, ""),
            ("tls://c:3", 4, 3, 0, "another", 1e4, "lanes is 8, here 16"),
        )
    ]
    found: dict[str, Any] = {"workers": [str(one) for one in workers]}
    for dashboard in (None, "http://a/status"):
        with instead(
            alight__cluster__status__workers_of=Stub(workers),
            alight__cluster__status__losses_of=Stub(Losses(1, 0)),
            alight__cluster__status__dashboard_of=Stub(dashboard),
            alight__cluster__addresses__connected=lambda *of: contextlib.nullcontext(of),
        ):
            found[f"status, dashboard {dashboard}"] = command("cluster", "status", "local:2")
    with in_folder() as folder:
        made = command("cluster", "keys", "k")
        again = command("cluster", "keys", "k")
        modes = [oct((folder / "k" / name).stat().st_mode & 0o777) for name in names_in(Path("k"))]
        found["keys"] = [made, again, modes, names_in(Path("k"))]
    client = Client()
    found["asked"] = described(workers_of(client, "portable"))
    found["losses"] = [described(losses_of(client)), dashboard_of(client)]
    client.services = {"dashboard": 8787}
    found["dashboard"] = dashboard_of(client)
    return found


class Client:
    """A client of a cluster with workers that answer, differ, are silent and fail."""

    services: dict[str, int] = {}
    dashboard_link = "http://pages"
    _run = "run"

    def scheduler_info(self, n_workers: int) -> dict[str, Any]:
        """About the workers."""
        about = {"nthreads": 3, "metrics": {"memory": 2**21}}
        workers = {f"tcp://{name}:1": dict(about) for name in ("d", "b", "a", "c")}
        workers["tcp://c:1"] = {"nthreads": 1}
        return {"workers": workers if n_workers else {}, "services": self.services}

    def processing(self) -> dict[str, tuple[str, ...]]:
        """Tasks of workers."""
        return {"tcp://a:1": ("x", "y"), "tcp://c:1": ()}

    def sync(self, run: Any, state: Any, target: str, *, workers: list[str], **of: Any) -> Any:
        """What a worker says of its machine."""
        from alight.cluster.status import machine_here

        (one,) = workers
        machine = machine_here(target)
        if one == "tcp://b:1":
            raise TimeoutError
        if one == "tcp://c:1":
            raise ValueError("no alight here")
        if one == "tcp://d:1":
            machine = {**machine, next(iter(machine)): "another"}
        return {one: (machine, f"kind of {target}", 1.5e6)}

    def get_events(self, topic: str) -> list[tuple[float, Any]]:
        """What has happened."""
        return [
            (1.0, {"action": "remove-worker", "processing-tasks": {"a": 1, "b": 2}}),
            (2.0, {"action": "remove-worker", "expected": True, "processing-tasks": {"c": 1}}),
            (3.0, {"action": "add-worker", "processing-tasks": {"c": 1}}),
            (4.0, "text"),
            (5.0, {"action": "remove-worker"}),
        ]


def machines() -> dict[str, Any]:
    """What the doctor says of healthy machines, and of those that lack something."""
    wanted = [("numpy", ""), ("numba", ""), ("dask", "cluster"), ("rich", ""), ("bokeh", "cluster"),
              ("pyoidn", "denoise"), ("usd-core", "usd")]  # fmt: skip
    found: dict[str, Any] = {}
    with in_folder({"cache/a.o": b"x" * 250000, "cache/b/c.o": b"y" * 300000}) as folder:
        for name, installed, required, cache, writes in (
            ("healthy", {n for n, _ in wanted}, wanted, folder / "cache", True),
            ("empty", {"numpy", "numba", "rich"}, wanted, folder / "no" / "folder", True),
            ("lacking", {"numpy", "dask", "bokeh"}, wanted, folder / "cache", False),
            ("source", {"numpy"}, [], folder / "cache", True),
        ):  # fmt: skip

            def of(name: str, installed: set[str] = installed) -> str | None:
                return f"1.{len(name)}" if name in installed else None

            features = {"avx2": True, "fma": True, "sse4.2": False}
            version = (3, 12, 1) if required else (3, 14, 0)
            machine = SimpleNamespace(
                python_version=lambda: "3.x", system=lambda: "System", release=lambda: "6",
                machine=lambda: "machine",
            )  # fmt: skip
            said = io.StringIO()
            with (
                contextlib.redirect_stdout(said),
                instead(
                    alight__cli__doctor___installed=of,
                    alight__cli__doctor__requirements=Stub(required),
                    alight__cli__doctor__install_command=lambda *words: " ".join(words),
                    alight__cli__doctor__platform=machine,
                    alight__cli__doctor__sys=SimpleNamespace(
                        version_info=version, executable="python"
                    ),
                    alight__cli__doctor___gpu=Stub("none" if name == "empty" else "a model"),
                    alight__rendering__resources__usable_processors=Stub(6),
                    lanewise__machine__cache_folder=Stub(cache),
                    lanewise__machine__lanes_of_machine=Stub(8),
                    llvmlite__binding__get_host_cpu_name=Stub("a-name"),
                    llvmlite__binding__get_host_cpu_features=Stub(features if required else {}),
                    alight__outputs__atomic__check_folder=Stub(
                        None if writes else OutputError("cannot write")
                    ),
                ),
            ):
                try:
                    doctor.doctor()
                    code = 0
                except typer.Exit as ended:
                    code = ended.exit_code
            found[name] = [code, masked(said.getvalue()).replace(__version__, "VERSION")]
        with (
            contextlib.redirect_stdout(io.StringIO()) as said,
            mock.patch.dict("sys.modules", {"llvmlite.binding": None}),
        ):
            found["no compiler"] = described(doctor._compiler())
    missing, there = doctor._installed("no-such-package-here"), doctor._installed("numpy")
    found["installed"] = [missing is None, there is not None]
    return found


CASES = {
    "laboratory": laboratory,
    "random_scenes": random_scenes,
    "sheets": sheets,
    "clusters": clusters,
    "machines": machines,
}
