"""Compiling beforehand: every model has a scene that uses it, and kernels are kept afterwards."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.compiled.scene import compile_scene
from alight.core.registry import FAMILIES_OF_SCENES, modules, type_name_of
from alight.core.spec import Spec
from alight.formats import builtin_names
from alight.lab import warm
from alight.lab.replicates.measure import compiled_kernels
from alight.options.scene import SceneOptions
from alight.scene import flatten
from lanewise.application import variable

MODELS = [
    (family, type_name_of(module)) for family in FAMILIES_OF_SCENES for module in modules(family)
]


def holds(value, spec):
    """Whether a description is part of another one."""
    if isinstance(value, dict):
        return any(holds(item, spec) for item in value.values())
    if isinstance(value, tuple | list):
        return any(holds(item, spec) for item in value)
    if type(value) is type(spec):
        return True
    return isinstance(value, Spec) and any(holds(item, spec) for _, item in value)


@pytest.mark.parametrize(("family", "name"), MODELS, ids=["-".join(model) for model in MODELS])
def test_every_model_has_a_scene_that_uses_it(family, name):
    module = next(one for one in modules(family) if type_name_of(one) == name)
    scene = warm.scene_with(family, name)
    assert holds(scene, module.EXAMPLES[0])
    compile_scene(flatten(scene))


def test_all_scenes_and_all_models_are_compiled_by_default(monkeypatch):
    compiled = []
    monkeypatch.setattr(warm, "compile_job", lambda job, _: compiled.append(job) or "")
    seen = []
    done = warm.warm(progress=seen.append)
    assert compiled == [*builtin_names(), *(f"{family}: {name}" for family, name in MODELS)]
    assert done.scenes == len(compiled) == seen[-1].total
    assert [one.done for one in seen] == list(range(1, len(compiled) + 1))
    assert not done.failures


def test_what_was_compiled_is_not_compiled_again(tmp_path, monkeypatch):
    monkeypatch.setenv(variable("CACHE"), str(tmp_path))
    assert warm.compile_job("cornell-box", SceneOptions()) == ""
    kept = {path: path.stat().st_mtime_ns for path in Path(tmp_path).rglob("*") if path.is_file()}
    assert kept
    compiled_kernels(compile_scene(flatten(alight.load("cornell-box"))))
    again = {path: path.stat().st_mtime_ns for path in Path(tmp_path).rglob("*") if path.is_file()}
    assert again == kept


def test_a_scene_that_does_not_exist_is_refused_before_anything_is_compiled(monkeypatch):
    monkeypatch.setattr(warm, "compile_job", lambda *_: pytest.fail("it was compiled"))
    done = CliRunner().invoke(app, ["warm", "cornell-box", "cornel-box"])
    assert done.exit_code == 2
    assert 'did you mean "cornell-box"' in done.stderr


def test_a_scene_that_cannot_be_compiled_is_told_and_the_others_are(monkeypatch):
    told = {"cornell-box": "no room on the disk", "fog": ""}
    monkeypatch.setattr(warm, "compile_job", lambda job, _: told[job])
    done = CliRunner().invoke(app, ["warm", *told, "--processes", "1"])
    assert done.exit_code == 1
    assert done.stderr == "warning: cornell-box: no room on the disk\n"
    assert done.stdout.startswith("compiled: 1 scenes in")
