"""EXT_mesh_gpu_instancing: one mesh in many places of a node."""

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats.gltf import instances
from alight.formats.gltf.scene import parse
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.reading import parsed

NAME = "EXT_mesh_gpu_instancing"
HALF = np.sqrt(0.5)
SHIFTS = np.array([[0, 0, 0], [5, 0, 0], [0, 7, 0]], "<f4")
#: None, 90 degrees about z, none.
TURNS = np.array([[0, 0, 0, 1], [0, 0, HALF, HALF], [0, 0, 0, 2]], "<f4")
SCALES = np.array([[1, 1, 1], [2, 1, 1], [1, 3, 1]], "<f4")


def forest(required=True, **attributes):
    m = Maker()
    held = {key: m.accessor(table) for key, table in attributes.items()}
    m.node(name="trees", mesh=m.square(), translation=[100, 0, 0],
           extensions={NAME: {"attributes": held}})  # fmt: skip
    if required:
        m.json["extensionsUsed"] = m.json["extensionsRequired"] = [NAME]
    return m


def places(m):
    """World matrices of the instances, and the scene's data."""
    data = parsed(m).data
    trees = data["nodes"]["trees"]
    assert trees["transform"] == [{"translate": [100.0, 0.0, 0.0]}]
    node = np.eye(4)
    node[0, 3] = 100
    children = trees["children"].values()
    assert len({child["instance"] for child in children}) == 1
    [prototype] = data["prototypes"]
    assert all(child["instance"] == prototype for child in children)
    return [node @ np.array(child["transform"]["matrix"]) for child in children], data


def test_scale_comes_first_then_rotation_then_translation():
    found, data = places(forest(TRANSLATION=SHIFTS, ROTATION=TURNS, SCALE=SCALES))
    corner = np.array([1, 1, 0, 1])
    # Scaled to (2, 1), turned to (-1, 2), moved by 5; the node's own 100 last.
    np.testing.assert_allclose(found[0] @ corner, [101, 1, 0, 1], atol=1e-5)
    np.testing.assert_allclose(found[1] @ corner, [100 + 5 - 1, 2, 0, 1], atol=1e-5)
    np.testing.assert_allclose(found[2] @ corner, [101, 7 + 3, 0, 1], atol=1e-5)
    shape = data["prototypes"]["mesh 0"]["children"]["primitive 0"]["shape"]
    np.testing.assert_array_equal(shape.vertices, POINTS)


def test_rotations_may_be_normalised_bytes():
    turns = np.array([[0, 0, 0, 127], [0, 0, 90, 90], [127, 0, 0, 0]], "i1")
    m = forest(TRANSLATION=SHIFTS, ROTATION=turns)
    m.json["accessors"][1]["normalized"] = True
    found, _ = places(m)
    np.testing.assert_allclose(found[1] @ [1, 0, 0, 1], [105, 1, 0, 1], atol=1e-5)
    np.testing.assert_allclose(found[2] @ [0, 1, 0, 1], [100, 6, 0, 1], atol=1e-5)


def test_the_camera_sees_all_instances(monkeypatch):
    box = parse(forest(TRANSLATION=SHIFTS).gltf(), "a.gltf").framed
    np.testing.assert_allclose([box.low, box.high], [[100, 0, 0], [106, 8, 0]])
    # The same from the corners of boxes.
    monkeypatch.setattr(instances, "MOST_SEEN", 0)
    again = parse(forest(TRANSLATION=SHIFTS).gltf(), "a.gltf").framed
    np.testing.assert_allclose([again.low, again.high], [box.low, box.high])


def test_flattened_instances_are_dropped_and_told():
    m = forest(SCALE=np.array([[1, 1, 1], [0, 1, 1]], "<f4"))
    found, _ = places(m)
    assert len(found) == 1
    assert f"{NAME}: 1 instances are flattened to nothing" in parsed(m).notes


@pytest.mark.parametrize(
    ("attributes", "words"),
    [
        ({"TRANSLATION": SHIFTS, "SCALE": SCALES[:2]}, "alike, has TRANSLATION 3, SCALE 2"),
        ({"_ID": SHIFTS}, "alike, has none"),
        ({"TRANSLATION": TURNS}, "/attributes/TRANSLATION\n  must have 3 components, got 4"),
        ({"TRANSLATION": SHIFTS * np.float32(np.nan)}, "must be finite"),
        (
            {"ROTATION": TURNS * np.array([[1], [0], [1]], "f4")},
            "quaternions, not so in row 1",
        ),
    ],
)
def test_what_is_wrong_is_said(attributes, words):
    with pytest.raises(SceneError) as caught:
        parse(forest(**attributes).gltf(), "a.gltf")
    assert words in str(caught.value)
    assert f"/nodes/0/extensions/{NAME}/attributes" in str(caught.value)


def test_a_small_file_does_not_ask_for_millions(monkeypatch):
    monkeypatch.setattr(instances, "MOST_INSTANCES", 2)
    with pytest.raises(SceneError, match="must have at most 2 instances, has 3"):
        parse(forest(TRANSLATION=SHIFTS).gltf(), "a.gltf")
