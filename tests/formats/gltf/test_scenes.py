"""Files of several scenes: the file's own choice, or one by name or number."""

import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.gltf.scene import parse
from alight.formats.reading.shown import Shown
from tests.formats.gltf.maker import Maker


def rooms():
    """A hall, which the file shows, a kitchen, and a room without a name."""
    m = Maker()
    for name in ("sofa", "stove", "box"):
        m.node(name=name, mesh=m.square())
    m.json["scenes"] = [{"name": "kitchen", "nodes": [1]}, {"name": "hall", "nodes": [0]}]
    m.json["scenes"] += [{"nodes": [2]}]
    m.json["scene"] = 1
    return m


@pytest.mark.parametrize(
    ("wanted", "shown"),
    [(None, "sofa"), ("kitchen", "stove"), ("0", "stove"), ("hall", "sofa"), ("2", "box")],
)
def test_a_scene_is_shown_by_name_or_number(wanted, shown):
    found = parse(rooms().gltf(), "a.gltf", None, Shown(scene_name=wanted))
    assert shown in found.data["nodes"]
    assert not {"sofa", "stove", "box"} - {shown} & set(found.data["nodes"])


def test_a_number_may_be_a_number_of_python(tmp_path):
    (tmp_path / "a.gltf").write_bytes(rooms().gltf())
    assert "stove" in alight.load(tmp_path / "a.gltf", scene_name=0).nodes


def test_scenes_that_are_not_shown_are_told():
    [line] = [n for n in parse(rooms().gltf(), "a.gltf").notes if "other scenes" in n]
    assert line.startswith('other scenes ("kitchen", "2"): the file shows scene 1; --scene-name')


def test_scenes_that_are_not_there_are_one_message(tmp_path):
    (tmp_path / "a.gltf").write_bytes(rooms().gltf())
    with pytest.raises(SceneError, match=r'--scene-name\n.*did you mean "kitchen"'):
        alight.load(tmp_path / "a.gltf", scene_name="kitchn")
    with pytest.raises(SceneError, match="must be below the number of scenes, 3, got 7"):
        alight.load(tmp_path / "a.gltf", scene_name="7")
    m = Maker()
    m.node(mesh=m.square())
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    with pytest.raises(SceneError, match="the file has no scenes"):
        alight.load(tmp_path / "a.gltf", scene_name="hall")
    with pytest.raises(SceneError, match="only glTF files hold several scenes"):
        alight.load("cornell-box", scene_name="hall")
