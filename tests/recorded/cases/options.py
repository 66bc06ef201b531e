"""Options: their tables, what each kind makes of awkward texts and values, what contradicts."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from typing import Any

from alight.options import animation, laboratory, render, resume, scene, view
from alight.options.kinds import Kind
from alight.options.table import Options
from tests.options.examples import example
from tests.recorded.making import described, outcome, rows

MODULES = (animation, laboratory, render, resume, scene, view)
TABLES = {
    name: one
    for module in MODULES
    for name, one in sorted(vars(module).items())
    if isinstance(one, type) and issubclass(one, Options) and one.__module__ == module.__name__
}

#: What somebody may type.
TEXTS = (
    "",
    " ",
    "0",
    "1",
    "-1",
    "+3",
    "7 ",
    "007",
    "2.5",
    ".5",
    "1e3",
    "1e12",
    "nan",
    "inf",
    "abc",
    "0%",
    "2%",
    "50 %",
    "100%",
    "1100%",
    "90s",
    "1.5h",
    "5 m",
    "0s",
    "-2s",
    "2d",
    "3/40",
    "41/40",
    "0/3",
    "0:5",
    "5:5",
    "3:120",
    "640x480",
    "640*480",
    "64,32",
    "3.5x2.5in",
    "9x6cm",
    "90X60mm",
    "0x0",
    "1,2,3,4",
    "1, 2, 3, 4",
    "1,2,3",
    "-1,2,3,4",
    "albedo",
    "albedo, normal",
    "albedo,,x",
    "relrmse",
    "pixel",
    "relmse",
    "auto",
    "spp=4",
    "a=b=c",
    "=4",
    "path/to file.png",
    "1" * 20,
)

#: What somebody may pass in Python.
VALUES = (
    None,
    True,
    0,
    1,
    -3,
    2.5,
    float("nan"),
    float("inf"),
    2**40,
    (3, 4),
    [4, 3],
    (1, 2, 3),
    (5, 6, 7, 8),
    ("a", "b"),
    {"a": 1},
    b"x",
    3j,
)


def _told(value: Any) -> str:
    return str(described(value))


def kinds() -> dict[str, Any]:
    """What each kind of option makes of texts and values, by what it answers."""
    found: dict[str, Kind] = {}
    for table in TABLES.values():
        for one in table.options().values():
            found.setdefault(_name_of(one.kind), one.kind)
    answers: dict[str, Any] = {}
    seen: set[type] = set()
    for name, kind in sorted(found.items()):
        if type(kind) in seen:
            # Only its ends differ.
            ends = [v for f in ("least", "most") if (v := getattr(kind, f, None)) is not None]
            of_ends = [_told(outcome(kind.check, v + d)) for v in ends for d in (-1, 0, 1)]
            answers[name] = [kind.range, kind.metavar, *of_ends]
            continue
        seen.add(type(kind))
        by_answer = defaultdict(list)
        for text in TEXTS:
            said = [text] if kind.is_repeated else text
            answer = _told(outcome(kind.parse, said))
            by_answer[answer.replace(repr(text), "IT").replace(f'"{text}"', "IT")].append(text)
        of_values = {repr(value): _told(outcome(kind.check, value)) for value in VALUES}
        answers[name] = {
            "range": kind.range,
            "metavar": kind.metavar,
            "texts": {a: " | ".join(t) for a, t in by_answer.items()},
            "values": of_values,
        }
    return answers


def _name_of(kind: Kind) -> str:
    fields = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    words = [f"{f.name}={described(getattr(kind, f.name))}" for f in fields]
    return f"{type(kind).__name__}({', '.join(words)})"


def tables() -> dict[str, Any]:
    """Every option of every table: what help says of it."""
    found = {}
    for name, table in TABLES.items():
        found[name] = {
            one.name: " · ".join(
                map(
                    str,
                    [
                        " ".join(one.flags),
                        type(one.kind).__name__,
                        one.default,
                        one.shown,
                        one.metavar or one.kind.metavar,
                        one.panel,
                        one.key,
                        one.help,
                    ],
                )
            )
            for one in table.options().values()
        }
    return found


def words() -> dict[str, Any]:
    """The words of a command line that give an option, the changes that it makes to a scene."""
    found: dict[str, Any] = {}
    for name, table in TABLES.items():
        found[name] = {}
        for one in table.options().values():
            if one.flags:
                made = outcome(lambda one=one, table=table: _said(table, one))
                found[name][one.name] = made
    return found


def _said(table: Any, one: Any) -> list[Any]:
    options = table.of({one.name: example(one)})
    changes = options.assignments() if hasattr(options, "assignments") else []
    return [*options.words(), *changes]


CONTRADICTIONS: dict[str, dict[str, Any]] = {
    "spp and schedule": {"spp": 4, "schedule": type("S", (), {"next": None})()},
    "part and time": {"part": "1/2", "time_limit": "3s"},
    "part and error": {"part": "1/2", "error": "3%"},
    "part and adaptive": {"part": "2/2", "adaptive": True, "spp": 4},
    "part and more parts": {"part": "2/9", "spp": 4},
    "error and spp": {"error": "3%", "spp": 4},
    "error and time": {"error": "3%", "time_limit": 3},
    "error of 200 %": {"error": 2},
    "confidence alone": {"confidence": 0.9},
    "share alone": {"share": "90%", "error": "1%"},
    "metric alone": {"metric": "pixel"},
    "pixel and share": {"metric": "pixel", "share": "90%", "error": "1%"},
    "max spp alone": {"max_spp": 8},
    "max time alone": {"max_time": "1m"},
    "cycles": {"criterion": "cycles", "error": 0.01},
    "cycles with confidence": {"criterion": "cycles", "error": 0.01, "confidence": 0.9},
    "cycles adaptive": {"criterion": "cycles", "adaptive": True},
    "adaptive": {"adaptive": True},
    "every alone": {"every": "5s"},
    "checkpoint": {"checkpoint": "a.checkpoint", "every": "5s"},
    "transparent and layers": {"background": "transparent", "aovs": "alpha"},
    "shadow": {"background": "shadow"},
    "dpi and size": {"dpi": 72, "size": "2x1in"},
    "paper": {"size": "2x1in"},
    "paper and crop": {"size": "2x1in", "crop": "0,0,9,9"},
    "bits": {"bits": 9},
    "exposure": {"exposure": "bright"},
    "tone map": {"tone_map": "filmic"},
    "white balance": {"white_balance": "3200"},
    "keys without cluster": {"cluster_keys": "folder"},
    "unknown": {"sppp": 4},
    "notes": {"notes": {"a": {1}}},
    "cancel": {"cancel": 3},
}


def contradictions() -> dict[str, Any]:
    """What is refused together, what does nothing alone, and what remains."""

    def made(words: dict[str, Any]) -> list[Any]:
        options = render.RenderOptions.of(words)
        given = {k: v for k, v in options.given().items() if k not in ("schedule", "cancel")}
        return [given, options.useless(), options.assignments(), options.words()]

    found = rows(made, {name: (words,) for name, words in CONTRADICTIONS.items()})
    frames = {
        "one": {"frames": "0:3"},
        "turntable": {"turntable": True, "frames": "0:4"},
        "fps": {"fps": 0},
        "shutter": {"shutter": 3},
        "nothing": {},
        "turn": {"turntable": 4},
    }
    of_frames = rows(
        lambda words: animation.AnimationOptions.of(words).given(),
        {name: (words,) for name, words in frames.items()},
    )
    return {"render": found, "animation": of_frames}


CASES = {"kinds": kinds, "tables": tables, "words": words, "contradictions": contradictions}
