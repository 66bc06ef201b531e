"""Edits in the view: the picture is that of the edited scene, and nothing wrong gets in."""

import json
import threading

import numpy as np
import pytest

import alight
from alight.compiled.kept import Kept, is_same
from alight.scene import content_hash
from alight.view import editing, protocol
from alight.view import tree as tree_of_scene
from alight.view.editing import WrongValueError, edited, with_step
from alight.view.movable import Movable
from alight.view.saving import save
from alight.view.tree import fields_of, items_of
from tests.view.looking import cornell, settled, wait_for
from tests.view.test_session import content

WHITE = "bsdfs.white"


@pytest.fixture
def session():
    found = cornell()
    yield found
    found.close()


def edit(session, item, key, value):
    return session.apply(protocol.Edit(item, f"{item}.{key}", json.dumps(value)))


def tree(session):
    return session.apply(protocol.AskTree())


def values(session, item):
    found = session.apply(protocol.AskFields(item))["fields"]
    return {field["path"].removeprefix(f"{item}."): field["value"] for field in found}


def assert_same_bits_when_saved(session, folder):
    film = settled(session)
    save(session, folder / "scene.yaml")
    again = alight.render(folder / "scene.yaml", spp=4, threads=1)
    assert content(film, folder / "a.alight") == content(again, folder / "b.alight")
    return film


def test_the_film_of_edited_values_is_that_of_the_saved_scene(session, tmp_path):
    before = settled(session).image
    session.apply(protocol.Orbit(0.05, 0.02))
    assert edit(session, WHITE, "reflectance", [0.2, 0.4, 0.9])["is"] == "edited"
    light = next(i[0] for i in tree(session)["items"] if i[2] == "Lights")
    assert edit(session, light, "radiance", [30.0, 20.0, 10.0])["is"] == "edited"
    box = next(i[0] for i in tree(session)["items"] if "box" in i[1])
    assert session.apply(protocol.AddStep(box, "translate"))["is"] == "edited"
    key = next(key for key in values(session, box) if key.endswith("translate"))
    assert edit(session, box, key, [0.1, 0.0, -0.2])["is"] == "edited"
    film = assert_same_bits_when_saved(session, tmp_path)
    assert not np.array_equal(film.image, before)
    # The camera has stayed where it was moved to.
    assert session.live.wish.pose is not None


def test_a_scene_of_very_many_parts_keeps_its_integrator(session, monkeypatch):
    monkeypatch.setattr(tree_of_scene, "MOST_ITEMS", 5)
    found = items_of(session.editor.scene)
    assert len(found) == 5
    assert [item.path for item in found[-2:]] == ["integrator", "sampler"]


def test_values_neither_compile_kernels_nor_build_the_tree_again(session, monkeypatch):
    settled(session)
    movable = session.live.movable
    monkeypatch.setattr(Movable, "prepare", lambda self: pytest.fail("kernels are compiled"))
    for value in (0.1, 0.5):
        edit(session, WHITE, "reflectance", [value] * 3)
    settled(session)
    now = session.live.movable
    assert now.compiled.tables.accel is movable.compiled.tables.accel
    assert now.compiled.content_hash != movable.compiled.content_hash


def test_a_new_type_compiles_while_the_picture_before_stays(session, monkeypatch, tmp_path):
    settled(session)
    before, go, real = session.film, threading.Event(), Movable.prepare

    def slow(self):
        go.wait(60)
        real(self)

    monkeypatch.setattr(Movable, "prepare", slow)
    assert edit(session, "sampler", "type", "independent")["is"] == "edited"
    assert session.live.prepares
    assert session.film is before
    # It can even be moved in.
    session.apply(protocol.Orbit(0.02, 0.0))
    assert settled(session) is not before
    go.set()
    wait_for(lambda: not session.live.prepares)
    assert_same_bits_when_saved(session, tmp_path)
    assert session.live.movable.scene.sampler.type == "independent"


def test_a_camera_that_waits_for_its_kernels_is_in_later_edits_too(session, monkeypatch):
    settled(session)
    go, real = threading.Event(), Movable.prepare

    def slow(self):
        go.wait(60)
        real(self)

    monkeypatch.setattr(Movable, "prepare", slow)
    session.apply(protocol.Orbit(0.02, 0.0))
    edit(session, "camera", "type", "orthographic")
    edit(session, WHITE, "reflectance", [0.1] * 3)
    go.set()
    wait_for(lambda: not session.live.prepares)
    kinds = [one.scene.camera.camera.type for one in (session.live, session.editor)]
    assert kinds == ["orthographic"] * 2


def test_undo_and_redo_go_through_all_edits(session):
    first = session.editor.scene
    edit(session, WHITE, "reflectance", [0.1] * 3)
    edit(session, WHITE, "reflectance", [0.2] * 3)  # of one drag: one edit
    edit(session, "camera", "fov", 50.0)
    last = session.editor.scene
    assert last != first
    session.apply(protocol.Undo())
    assert values(session, WHITE)["reflectance"] == [0.2] * 3
    assert values(session, "camera")["fov"] != 50.0
    session.apply(protocol.Undo())
    assert session.editor.scene == first
    session.apply(protocol.Undo())
    assert session.editor.scene == first
    for _ in range(3):
        session.apply(protocol.Redo())
    assert session.editor.scene == last
    assert not session.state(None, None)["redo"]


def test_undo_leaves_a_camera_that_was_moved_where_it_is(session):
    edit(session, WHITE, "reflectance", [0.1] * 3)
    session.apply(protocol.Orbit(0.05, 0.0))
    there = session.live.pose.to_world
    session.apply(protocol.Undo())
    np.testing.assert_array_equal(session.live.pose.to_world, there)
    np.testing.assert_array_equal(session.editor.scene.camera.transform.matrix, there)


@pytest.mark.parametrize(
    ("item", "key", "value", "words"),
    [(WHITE, "reflectance", [0.2, 1.5, 0.2], "must be in [0, 1], got 1.5"),
     (WHITE, "reflectance", [0.2, 0.2], "must be 3 numbers"),
     (WHITE, "reflectance", "white", "must be 3 numbers"),
     (WHITE, "type", "difuse", "must be one of"),
     ("camera", "fov", "wide", "must be a number"),
     ("camera", "fov", 10**400, "must be a number"),
     ("camera", "fov", 180.0, "must be in (0, 180), got 180"),
     ("integrator", "max_depth", 2.5, "must be a whole number, got 2.5"),
     ("integrator", "hide_emitters", 1, "must be true or false")],
)  # fmt: skip
def test_a_wrong_value_is_told_and_the_picture_stays(session, item, key, value, words):
    film = settled(session)
    answer = edit(session, item, key, value)
    assert (answer["is"], answer["path"]) == ("wrong", f"{item}.{key}")
    assert words in answer["why"]
    assert session.film is film and session.live.phase == "done"
    assert not session.editor.history.done


@pytest.mark.parametrize(
    ("item", "path"),
    [("film", "film.size"), ("", "film"), (WHITE, "bsdfs.red.reflectance"), ("nodes", "nodes"),
     (WHITE, f"{WHITE}.__class__"), ("environment", "environment.file")],
)  # fmt: skip
def test_what_is_not_offered_cannot_be_changed(item, path):
    scene = alight.load("cornell-box")
    with pytest.raises(WrongValueError, match="cannot be changed here"):
        edited(scene, item, path, '"/etc/hostname"')


def test_files_are_told_but_not_offered():
    scene = alight.load("environment-map")
    fields = {f.path: f for i in items_of(scene) for f in fields_of(scene, i.path)}
    files = [f for path, f in fields.items() if path.endswith(".file")]
    assert files and all(f.kind == "told" for f in files)
    with pytest.raises(WrongValueError, match="cannot be changed here"):
        edited(scene, files[0].path.rpartition(".")[0], files[0].path, '"other.exr"')


@pytest.mark.parametrize("name", ["material-ball", "blurred-foreground", "cloud", "lamp-profiles"])
def test_values_that_are_offered_can_be_set_to_what_they_are(name):
    scene = alight.load(name)
    found = [(item.path, f) for item in items_of(scene) for f in fields_of(scene, item.path)]
    # One of each kind: the same code sets the others.
    for item, field in {f.kind: (item, f) for item, f in found if f.kind != "told"}.values():
        assert edited(scene, item, field.path, json.dumps(field.value)) == scene


def test_steps_change_nothing_until_they_are_edited():
    scene = alight.load("cornell-box")
    item = next(i.path for i in items_of(scene) if i.group == "Objects")
    for step in ("translate", "rotate", "scale"):
        scene = with_step(scene, item, step)
    assert content_hash(scene) == content_hash(alight.load("cornell-box"))
    with pytest.raises(WrongValueError, match="no such step"):
        with_step(scene, item, "shear")


def test_many_edits_of_one_value_are_one_only_for_a_moment(monkeypatch):
    clock = iter(np.arange(0.0, 100.0, 0.6))
    monkeypatch.setattr(editing.time, "monotonic", lambda: next(clock))
    history = editing.History()
    for number in range(4):
        history.add(editing.Step("a", number, number + 1))
    assert [(step.before, step.after) for step in history.done] == [(0, 4)]
    history.back()
    history.add(editing.Step("a", 0, 9))
    assert len(history.done) == 1 and not history.undone
    history.add(editing.Step("b", 9, 8))
    assert len(history.done) == 2


def test_what_is_kept_is_of_equal_arguments_only():
    kept, calls = Kept(), []

    def make(*arguments):
        calls.append(arguments)
        return len(calls)

    one = np.arange(4.0)
    assert kept("a", make, [one, "x"]) == kept("a", make, [one.copy(), "x"]) == 1
    assert kept("b", make, [one, "x"]) == 2
    assert kept("a", make, [one + 1.0, "x"]) == 3
    assert kept("a", make, [(one + 1.0).astype(np.float32), "x"]) == 4
    assert not is_same((1, 2), [1, 2])
    assert not is_same(np.array([0.0]), np.array([-0.0]))
