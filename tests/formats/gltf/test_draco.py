"""Draco streams: what they hold, and what becomes of broken ones."""

import importlib.util
import sys

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats.gltf import draco
from alight.formats.gltf.scene import parse
from tests.formats.gltf.compressed import COLORS, NAME, encoded, square
from tests.formats.gltf.maker import FACES, POINTS, UVS, Maker
from tests.formats.gltf.reading import parsed
from tests.formats.gltf.test_skins import JOINTS, WEIGHTS

DracoPy = pytest.importorskip("DracoPy")
NORMALS = np.tile(np.array([[0, 0, 1]], "<f4"), (4, 1))


def shape_of(m, name="node 0"):
    return parsed(m).data["nodes"][name]["shape"]


def corners(table, faces):
    """Rows of a table triangle by triangle, whatever the order of vertices and triangles."""
    rows = np.asarray(table)[np.asarray(faces).reshape(-1, 3)].reshape(-1, 3, table.shape[1])
    turned = [rows[:, [i, (i + 1) % 3, (i + 2) % 3]].reshape(len(rows), -1) for i in range(3)]
    return sorted(min(tuple(turn[n]) for turn in turned) for n in range(len(rows)))


@pytest.mark.parametrize("level", [0, 7, 10])
@pytest.mark.parametrize("keeps_order", [False, True])
def test_all_attributes_come_out_by_their_identifiers(level, keeps_order):
    m = Maker()
    uvs = np.round(65535 * UVS).astype("<u2") if keeps_order else UVS
    tables = {"TEXCOORD_0": uvs, "NORMAL": NORMALS, "COLOR_0": COLORS}
    options = {"compression_level": level, "preserve_order": keeps_order}
    m.node(mesh=square(m, tables, quantization_bits=14, **options))
    shape = shape_of(m)
    every = np.column_stack([shape.vertices, shape.uvs, shape.normals, shape.colors])
    colors = COLORS[:, :3].astype("f4") / np.float32(255)
    turned_over = np.column_stack([UVS[:, 0], 1 - UVS[:, 1]])
    wanted = np.column_stack([POINTS, turned_over, NORMALS, colors])
    np.testing.assert_allclose(corners(every, shape.faces), corners(wanted, FACES), atol=1e-4)
    if keeps_order:
        assert shape.faces.ravel().tolist() == FACES.tolist()


@pytest.mark.parametrize("bits", [8, 16])
def test_quantised_positions_are_as_near_as_their_bits_say(bits):
    rng = np.random.default_rng(5)
    points = rng.random((300, 3)).astype("f4")
    points[:2] = [[0, 0, 0], [1, 1, 1]]
    m = Maker()
    index = square(m, {})
    faces = rng.permutation(300).reshape(-1, 3)
    stream, names = encoded(points, faces, quantization_bits=bits)
    primitive = m.json["meshes"][index]["primitives"][0]
    primitive["extensions"][NAME] = {"bufferView": m.view(stream), "attributes": names}
    m.node(mesh=index)
    found = parsed(m)
    # Its accessor still announces the four corners of the square.
    assert any("POSITION has 300 rows in its Draco stream, 4 " in w for w in found.warnings)
    vertices = found.data["nodes"]["node 0"]["shape"].vertices
    away = np.abs(vertices[:, None] - points[None]).max(axis=2).min(axis=1)
    assert len(vertices) == 300
    assert 0.4 / (2**bits - 1) < away.max() < 0.51 / (2**bits - 1)


def test_joints_and_weights_come_out():
    m = Maker()
    tables = {"NORMAL": NORMALS, "JOINTS_0": JOINTS, "WEIGHTS_0": WEIGHTS}
    first = m.node(name="a", translation=[0, 0, 5])
    second = m.node(name="b", translation=[0, 0, 7])
    m.node(name="skinned", mesh=square(m, tables), skin=0)
    m.json["skins"] = [{"joints": [first, second]}]
    found = shape_of(m, "skinned").vertices
    assert sorted(found.round(4).tolist()) == [[0, 0, 5], [0, 1, 5], [1, 0, 7], [1, 1, 7]]


def without_package(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda n: None if n == "DracoPy" else find(n))


def test_a_missing_package_is_named_with_the_command(monkeypatch):
    without_package(monkeypatch)
    m = Maker()
    m.node(mesh=square(m))
    with pytest.raises(SceneError) as caught:
        parse(m.gltf(), "a.gltf")
    assert len(caught.value.issues) == 1
    text = str(caught.value)
    assert f"/meshes/0/primitives/0/extensions/{NAME}" in text
    assert "needs the package DracoPy: pip install" in text and '[gltf]"' in text
    assert "gltf-transform copy" in text


def test_meshes_that_are_there_twice_need_no_package(monkeypatch):
    m = Maker()
    m.node(mesh=square(m, required=False, quantization_bits=2))
    with_package = parsed(m)
    without_package(monkeypatch)
    found = parsed(m)
    for one in (found, with_package):
        np.testing.assert_array_equal(one.data["nodes"]["node 0"]["shape"].vertices, POINTS)
        assert f"{NAME}: the file holds the same meshes without it" in one.notes


def problem(m):
    with pytest.raises(SceneError) as caught:
        parse(m.gltf(), "a.gltf")
    assert len(caught.value.issues) == 1
    return str(caught.value)


def with_stream(stream, names=None):
    m = Maker()
    index = square(m)
    place = m.json["meshes"][index]["primitives"][0]["extensions"][NAME]
    place["bufferView"] = m.view(stream)
    place["attributes"] = names or place["attributes"]
    m.node(mesh=index)
    return m


def varint(number):
    out = b""
    while number > 127:
        out, number = out + bytes([number & 127 | 128]), number >> 7
    return out + bytes([number])


def test_broken_streams_give_one_message():
    stream, names = encoded()
    assert "is no Draco stream" in problem(with_stream(b"hello world, no stream"))
    assert "is no Draco mesh, or a broken one" in problem(with_stream(stream[:40]))
    cloud = DracoPy.encode(POINTS)
    assert "holds points, no triangles" in problem(with_stream(cloud))
    wrong = with_stream(stream, names | {"POSITION": 77})
    assert "/attributes/POSITION\n  must be the identifier" in problem(wrong)


def test_streams_do_not_get_the_memory_that_they_announce():
    head = b"DRACO\2\2\1\0\0\0"
    greedy = head + varint(1) + varint(2**27) + b"\1\0\1\2" * 20
    assert "134217728 triangles or vertices in" in problem(with_stream(greedy))
    # Behind metadata, where the numbers are not looked at before: the process has no room.
    flagged = b"DRACO\2\2\1\0\0\x80" + b"\0\0\0" + varint(1) + varint(2**28) + b"\1"
    flagged += b"\0" * 12 + b"\1\1\0\x0a\xff\0\0\0" + b"\0" * 64
    if sys.platform == "linux":
        assert "more memory than" in problem(with_stream(flagged))


def test_a_decoder_that_dies_or_hangs_is_one_message(monkeypatch, tmp_path):
    worker = tmp_path / "worker.py"
    monkeypatch.setattr(draco, "_WORKER", worker)
    worker.write_text("import os\nos.abort()\n")
    assert "its decoder ended with exit code" in problem(with_stream(encoded()[0]))
    worker.write_text("while True:\n    pass\n")
    monkeypatch.setattr(draco, "SECONDS", 0.5)
    assert "its decoder found no end" in problem(with_stream(encoded()[0]))
