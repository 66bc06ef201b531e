"""Accessors, primitives, nodes and morph targets of glTF."""

import numpy as np
import pytest

from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import open_document
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.scene import flatten
from tests.formats.bare import load, nodes_of
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.reading import parsed

ACCESSORS = {
    "bytes": (np.array([[-128, 0, 127]], "i1"), True, [[-1, 0, 1]]),
    "unsigned bytes": (np.array([[0, 51, 255]], "u1"), True, [[0, 0.2, 1]]),
    "shorts": (np.array([[-32767, 0, 32767]], "<i2"), True, [[-1, 0, 1]]),
    "unsigned shorts": (np.array([[0, 13107, 65535]], "<u2"), True, [[0, 0.2, 1]]),
    "plain shorts": (np.array([[-5, 300, 7]], "<i2"), False, [[-5, 300, 7]]),
    "floats": (np.array([[-5, 300, 7]], "<f4"), False, [[-5, 300, 7]]),
}


@pytest.mark.parametrize("kind", ACCESSORS)
def test_accessors_of_every_type(kind):
    table, normalized, wanted = ACCESSORS[kind]
    m = Maker()
    index = m.accessor(table, normalized=normalized)
    document = open_document(m.glb(), "a", Reach(), Report())
    np.testing.assert_allclose(read_accessor(document, index), wanted, atol=1e-7)


def test_accessors_with_strides_and_sparse_rows():
    m = Maker()
    rows = np.arange(20, dtype="<f4").reshape(4, 5)
    view = m.view(rows.tobytes(), byteStride=20)
    m.json["accessors"].append(
        {"bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 4, "type": "VEC3",
         "sparse": {
             "count": 2,
             "indices": {"bufferView": m.view(np.array([1, 3], "<u2").tobytes()),
                         "componentType": 5123},
             "values": {"bufferView": m.view((-np.ones((2, 3), "<f4")).tobytes())},
         }}
    )  # fmt: skip
    document = open_document(m.glb(), "a", Reach(), Report())
    wanted = rows[:, 1:4].copy()
    wanted[[1, 3]] = -1
    np.testing.assert_array_equal(read_accessor(document, 0), wanted)


def test_strips_and_fans_keep_their_sides():
    for mode, order in ((5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])):
        m = Maker()
        m.node(mesh=m.square())
        primitive = m.json["meshes"][0]["primitives"][0]
        primitive |= {"mode": mode, "indices": m.accessor(np.array(order, "<u1"))}
        faces = parsed(m).data["nodes"]["node 0"]["shape"].faces
        a, b, c = (POINTS[faces[:, i]] for i in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0).all(), mode
        wanted = {5: [{0, 1, 3}, {1, 2, 3}], 6: [{0, 1, 2}, {0, 2, 3}]}[mode]
        assert [set(face) for face in faces.tolist()] == wanted


def test_nodes_are_scaled_then_turned_then_moved(tmp_path):
    m = Maker()
    # A quarter turn about z: from x to y.
    turn = [0, 0, np.sin(np.pi / 4), np.cos(np.pi / 4)]
    m.node(mesh=m.square(), scale=[2, 3, 4], rotation=turn, translation=[5, 6, 7])
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    (shape,) = flatten(load(tmp_path / "a.gltf")).shapes
    np.testing.assert_allclose(shape.to_world @ [1, 0, 0, 1], [5, 8, 7, 1], atol=1e-12)
    np.testing.assert_allclose(shape.to_world @ [0, 1, 1, 1], [2, 6, 11, 1], atol=1e-12)


@pytest.mark.parametrize("normalized", [True, False])
def test_colors_of_vertices_in_bytes_reach_one(normalized):
    m = Maker()
    table = np.array([[0, 51, 255]] * 4, "u1")
    m.node(mesh=m.square(COLOR_0=m.accessor(table, normalized=normalized)))
    colors = parsed(m).data["nodes"]["node 0"]["shape"].colors
    np.testing.assert_allclose(colors, [[0, 0.2, 1]] * 4, atol=1e-7)


@pytest.mark.parametrize("number", [-0.25, 1.5])
def test_colors_of_vertices_are_cut_to_what_surfaces_can_have(number):
    m = Maker()
    table = np.array([[0.5, number, 0.25]] * 4, "<f4")
    m.node(mesh=m.square(COLOR_0=m.accessor(table)))
    scene = parsed(m)
    colors = scene.data["nodes"]["node 0"]["shape"].colors
    np.testing.assert_allclose(colors, [[0.5, np.clip(number, 0, 1), 0.25]] * 4)
    assert any("were cut to [0, 1]" in text for text in scene.warnings)


def test_the_same_mesh_with_other_weights_is_another_one():
    m = Maker()
    square = m.square()
    targets = {
        "POSITION": m.accessor(np.tile(np.array([[0, 0, 2]], "<f4"), (4, 1))),
        "NORMAL": m.accessor(np.tile(np.array([[1, 0, 0]], "<f4"), (4, 1))),
    }
    primitive = m.json["meshes"][0]["primitives"][0]
    primitive["targets"] = [targets]
    upright = np.tile(np.array([[0, 0, 1]], "<f4"), (4, 1))
    primitive["attributes"]["NORMAL"] = m.accessor(upright)
    for weight in (0.5, 1.5):
        m.node(mesh=square, weights=[weight])
    found = parsed(m)
    for node, weight in zip(nodes_of(found).values(), (0.5, 1.5), strict=True):
        [part] = found.data["prototypes"][node["instance"]]["children"].values()
        np.testing.assert_array_equal(part["shape"].vertices[:, 2], 2 * weight)
        np.testing.assert_array_equal(part["shape"].normals, [[weight, 0, 1]] * 4)


def test_morph_targets_move_vertices():
    m = Maker()
    m.node(mesh=m.square(), weights=[0.5])
    up = np.tile(np.array([[0, 0, 2]], "<f4"), (4, 1))
    m.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": m.accessor(up)}]
    shape = parsed(m).data["nodes"]["node 0"]["shape"]
    np.testing.assert_array_equal(shape.vertices, POINTS + np.array([0, 0, 1]))


def test_hierarchies_deeper_than_ours_are_multiplied_out(tmp_path):
    m = Maker()
    last = m.node(mesh=m.square())
    for _ in range(60):
        last = m.node(children=[last], translation=[1, 0, 0], scale=[1, 1, 1])
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    (shape,) = flatten(load(tmp_path / "a.gltf")).shapes
    np.testing.assert_allclose(shape.to_world[:3, 3], [60, 0, 0])


@pytest.mark.parametrize(("weights", "text"), [([1], "has 1 for 2"), ([1, 0, 3], "has 3 for 2")])
def test_weights_that_do_not_fit_the_morph_targets_are_told(weights, text):
    m = Maker()
    square, up = m.square(), np.tile(np.array([[0, 0, 1]], "<f4"), (4, 1))
    targets = [{"POSITION": m.accessor(k * up)} for k in (1.0, 10.0)]
    m.json["meshes"][square] |= {"weights": weights}
    m.json["meshes"][square]["primitives"][0]["targets"] = targets
    m.node(name="it", mesh=square)
    found = parsed(m)
    assert set(found.data["nodes"]["it"]["shape"].vertices[:, 2]) == {1.0}
    assert any(f"/meshes/0/weights: {text} morph targets" in line for line in found.warnings)
