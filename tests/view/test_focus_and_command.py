"""The plane of focus by a click, and the command line whose film is that of the view."""

import json
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.films import Film
from alight.scene.transform import translate
from alight.view import editing, protocol
from alight.view.opening import session_of
from alight.view.tree import items_of
from tests.view.looking import OPTIONS, settled, wait_for

#: A wall at z = -5 that is lit from everywhere, and a thin lens before it.
WALL = """
alight: 1
camera: {type: thin_lens, fov: 40, aperture_radius: 0.5, focus_distance: 3, transform: %s}
nodes: {wall: {shape: rectangle, transform: [{scale: 50}, {translate: [0, 0, -5]}]}}
environment: {type: constant, radiance: 1}
"""
MIDDLE = 12, 8


@pytest.fixture
def viewed():
    """Opens scenes, as `alight view` does, and closes them."""
    sessions = []

    def opened(subject, *changes, **words):
        sessions.append(session_of(subject, OPTIONS.changed(changes=changes, **words)))
        return sessions[-1]

    yield opened
    for session in sessions:
        session.close()


def wall(tmp_path, transform):
    path = tmp_path / "wall.yaml"
    path.write_text(WALL % transform)
    return path


@pytest.mark.parametrize("scale", [1, 2])
def test_what_is_clicked_is_in_focus(scale, tmp_path, viewed):
    """Along the view, in the camera's own space; whichever part of the lens a sample takes."""
    session = viewed(wall(tmp_path, f"[{{scale: {scale}}}, {{translate: [1, 0, 3]}}]"))
    for pixel in (MIDDLE, (2, 3)):
        answer = session.apply(protocol.Focus(*pixel))
        assert answer == {"is": "focus", "distance": pytest.approx(8.0 / scale, rel=1e-5)}
        assert session.live.pose.camera.focus_distance == answer["distance"]
        assert session.state(None, None)["lens"]["focus_distance"] == answer["distance"]
        # It orbits about the place from now on: that of the pixel, whatever is blurred there.
        x, _, z = session.live.pose.pivot
        assert z == pytest.approx(-5.0, rel=1e-5)
        metres = 2.0 * np.tan(np.radians(20.0)) * 8.0 / 16.0
        assert abs((x - 1.0) / metres - (pixel[0] - 11.5)) <= 0.5 + 1e-3


def test_focus_can_be_undone_and_keeps_a_camera_that_was_moved(tmp_path, viewed):
    session = viewed(wall(tmp_path, "{translate: [0, 0, 3]}"))
    session.apply(protocol.Fly(0.0, 0.0, 0.5))
    there = session.live.pose.to_world
    session.apply(protocol.Focus(*MIDDLE))
    np.testing.assert_array_equal(session.live.pose.to_world, there)
    assert session.live.pose.camera.focus_distance != 3.0
    session.apply(protocol.Undo())
    assert session.live.pose.camera.focus_distance == 3.0
    np.testing.assert_array_equal(session.live.pose.to_world, there)


def test_what_has_no_focus_is_told(tmp_path, viewed):
    answer = viewed("cornell-box").apply(protocol.Focus(*MIDDLE))
    assert answer["why"].startswith("this camera is sharp everywhere; give it the type thin lens")
    away = viewed(wall(tmp_path, "{translate: [0, 0, -9]}"))
    assert away.apply(protocol.Focus(*MIDDLE))["why"] == "there is nothing to focus on"
    assert not away.editor.history.done


# ---------------------------------------------------------------------------- the command


def assert_command_gives_the_film(session, folder, *words):
    """Run what the page shows, and compare all sums."""
    film = settled(session)
    answer = session.apply(protocol.AskCommand())
    assert "text" in answer, answer
    program, *rest = shlex.split(answer["text"])
    assert program == "alight"
    done = CliRunner().invoke(app, [*rest, "-o", str(folder / "again.alight"), "-q"])
    assert done.exit_code == 0, done.output
    again = Film.load(folder / "again.alight")
    np.testing.assert_array_equal(again.sums, film.sums)
    np.testing.assert_array_equal(again.sample_count, film.sample_count)
    assert again.scene_hash == film.scene_hash
    for word in words:
        assert word in answer["text"]
    return answer


def edit(session, item, key, value):
    answer = session.apply(protocol.Edit(item, f"{item}.{key}", json.dumps(value)))
    assert answer["is"] == "edited"


def test_the_command_gives_the_bits_of_a_scene_that_is_as_it_was(tmp_path, viewed):
    session = viewed("cornell-box", seed=3, replicates=2)
    assert_command_gives_the_film(session, tmp_path, "--spp 4", "--seed 3", "--replicates 2")
    session.apply(protocol.More())
    wait_for(lambda: session.film is not None and session.film.spp == 8)
    assert_command_gives_the_film(session, tmp_path, "--spp 8")


def test_the_command_gives_the_bits_of_edits_and_of_a_moved_camera(tmp_path, viewed):
    session = viewed("cornell-box", "bsdfs.white.reflectance=[0.5, 0.6, 0.00001]")
    session.apply(protocol.Orbit(0.05, 0.02))
    session.apply(protocol.Develop(1.0, "agx", "none"))
    edit(session, "bsdfs.white", "reflectance", [0.1 + 0.2, 1e-5, 0.9])
    edit(session, "bsdfs.white", "reflectance", [0.3, 1e-5, 0.9])
    edit(session, "integrator", "max_depth", 3)
    session.apply(protocol.Undo())
    box = next(i.path for i in items_of(session.editor.scene) if "box" in i.name)
    assert session.apply(protocol.AddStep(box, "translate"))["is"] == "edited"
    session.apply(protocol.Region(2, 1, 11, 9))
    answer = assert_command_gives_the_film(
        session, tmp_path, "--exposure 1 ", "--tone-map agx", "--seed 0", "film.crop=[2, 1, 11, 9]"
    )
    assert "max_depth" not in answer["text"]


def test_the_command_names_a_camera_of_the_scene(tmp_path, viewed):
    path = tmp_path / "two.yaml"
    scene = alight.load("cornell-box")
    manager = alight.SceneManager(scene)
    side = scene.camera.replaced(transform=translate(0.1, 0.2, 0.3))
    manager.add("side", side)
    alight.save(manager.scene, path)
    session = viewed(path)
    name = session.editor.cameras[1]
    session.apply(protocol.ChooseCamera(name))
    assert_command_gives_the_film(session, tmp_path, f"--camera {name}")


def test_what_no_command_says_is_told(viewed, monkeypatch):
    monkeypatch.setattr(editing, "MOST_UNDONE", 1)
    session = viewed("cornell-box")
    edit(session, "bsdfs.white", "reflectance", [0.3, 0.2, 0.9])
    edit(session, "integrator", "max_depth", 3)
    assert "save the scene" in session.apply(protocol.AskCommand())["why"]
    session.origin = None
    assert "save it first" in session.apply(protocol.AskCommand())["why"]


def test_a_file_that_has_changed_since_is_told(tmp_path, viewed):
    path = wall(tmp_path, "{translate: [0, 0, 3]}")
    session = viewed(path)
    text = path.read_text()
    for other in (text.replace("radiance: 1", "radiance: 2"), text + "oops: 1", None):
        path.unlink() if other is None else path.write_text(other)
        assert "has changed since it was opened" in session.apply(protocol.AskCommand())["why"]
    path.write_text(text)
    assert "text" in session.apply(protocol.AskCommand())


def test_the_command_asks_for_the_error_and_says_what_it_does_otherwise(viewed):
    session = viewed("cornell-box", spp=None, error=0.9, max_spp=16)
    settled(session)
    answer = session.apply(protocol.AskCommand())
    assert "--error 90%" in answer["text"]
    assert "--spp" not in answer["text"].replace("--max-spp", "")
    assert not answer["notes"]
    session.apply(protocol.More())
    assert "went on to more samples" in session.apply(protocol.AskCommand())["notes"][0]
