"""What readers and writers answer in these tests is compared with notes; see `noting`."""

import functools
import json
import os
from pathlib import Path

import pytest

from alight.core.errors import OptionError, SceneError
from alight.formats import loading
from alight.formats.gltf import write
from alight.formats.scenes.parsed import Parsed
from tests.formats import noting

NOTE = os.environ.get("ALIGHT_NOTE", "")


def _noted(notes, function, answer):
    """A function whose answers are noted."""

    @functools.wraps(function)
    def noted(*values, **words):
        result = function(*values, **words)
        notes.add(function.__name__, answer(result, *values))
        return result

    return noted


def _read(parsed, *_):
    return parsed


def _built(scene, data, *_):
    return data, scene.source.places, scene.source.remarks, scene.warnings


def _refused(_, error, *values):
    return type(error).__name__, *values


def _written(lines, _, path):
    data = Path(path).read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    return lines, document


@pytest.fixture(scope="session")
def _noted_anew(request):
    """Notes of this run by module; they add to what is kept where only some tests run."""
    some = request.config.option.keyword or any("::" in one for one in request.config.args)
    return functools.cache(noting.kept if some else lambda module: {})


@pytest.fixture(autouse=True)
def _answers_are_as_noted(request, monkeypatch, _noted_anew):
    module, name = noting.name_of(request.node.nodeid)
    right = noting.kept(module)
    if not right and not NOTE:
        yield
        return
    notes = noting.Notes(str(request.config._tmp_path_factory.getbasetemp()))
    for place, function, answer in (
        (loading, "_built", _built),
        (write, "write", _written),
        (SceneError, "__init__", _refused),
        (OptionError, "__init__", _refused),
    ):
        monkeypatch.setattr(place, function, _noted(notes, getattr(place, function), answer))
    monkeypatch.setattr(Parsed, "of", staticmethod(_noted(notes, Parsed.of, _read)))
    yield
    line = notes.line() if notes.count else None
    if NOTE == "1":
        if line:
            _noted_anew(module)[name] = line
            noting.keep(module, _noted_anew(module))
    elif NOTE:
        path = Path(NOTE) / module / f"{name.replace('/', '-')[:150]}.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(notes.shown(), "utf-8")
    elif line or name in right:
        remedy = f"ALIGHT_NOTE=1 pytest tests/formats/{module}, if it is meant"
        assert line and name in right and noting.same(line, right[name]), (
            f"answers are {line}, and were {right.get(name)}: {remedy}; see tests/formats/noting.py"
        )
