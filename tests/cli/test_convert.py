"""``alight convert``: what it writes, what it says, and what it refuses before it reads."""

import json

import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.formats import load
from tests.formats.gltf.maker import everything


def run(*arguments):
    return CliRunner().invoke(app, ["convert", *map(str, arguments)])


@pytest.mark.parametrize("suffix", [".yaml", ".json", ".glb"])
def test_what_is_written_can_be_read(suffix, tmp_path):
    path = tmp_path / f"out{suffix}"
    done = run("cornell-box", path, "--set", "film.size=[20, 10]")
    assert done.exit_code == 0, done.output
    assert f"scene: {path}" in done.output.splitlines()
    scene = load(path)
    if suffix == ".json":
        assert json.loads(path.read_text("utf-8"))["film"]["size"] == [20, 10]
    # A film of glTF has a shape only: its pictures are 600 pixels high.
    assert scene.film.size == ((1200, 600) if suffix == ".glb" else (20, 10))
    assert any(node.light is not None for _, _, node in scene.walk())


def test_what_was_approximated_and_dropped_is_said(tmp_path):
    (tmp_path / "a.glb").write_bytes(everything().glb())
    done = run(tmp_path / "a.glb", tmp_path / "b.yaml")
    assert "dropped: occlusionTexture" in done.output
    assert "approximated: ACME_hats" in done.output
    done = run("clear-day", tmp_path / "c.glb")
    assert "glTF cannot hold: " in done.output


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("out.gltf", 'unknown suffix ".gltf"; did you mean ".glb"?'),
        ("out.obj", 'unknown suffix ".obj"  (valid: .glb, .json, .yaml, .yml)'),
        ("none/out.glb", "none/out.glb: the folder"),
        ("none/out.yaml", "none/out.yaml: "),
    ],
)
def test_what_cannot_be_written_is_refused_once(name, message, tmp_path):
    done = run("cornell-box", tmp_path / name)
    assert done.exit_code == 2
    output = "".join(done.output.splitlines())
    assert message in output and output.count("cannot write") == 1
    assert not list(tmp_path.iterdir())


def test_a_wrong_suffix_is_noticed_before_the_scene_is_read(tmp_path):
    done = run(tmp_path / "none.glb", tmp_path / "out.obj")
    assert "unknown suffix" in done.output and "no such scene" not in done.output
