"""Broken glTF files: a pointer to the place, and words."""

import json
import struct

import pytest

from alight.core.errors import SceneError
from alight.formats import load
from alight.formats.gltf.scene import parse
from tests.formats.gltf.maker import Maker, everything


def broken(change):
    m = everything()
    change(m.json)
    return m.gltf()


BROKEN = {
    "asset": (lambda j: j.pop("asset"), "the key asset is missing"),
    "version": (lambda j: j["asset"].update(version="1.0"), "/asset/version\n  must be 2.0"),
    "meshopt": (lambda j: j.update(extensionsRequired=["EXT_meshopt_compression"]), "gltfpack"),
    "required": (lambda j: j.update(extensionsRequired=["KHR_texture_transfrm"]),
                 'did you mean "KHR_texture_transform"?'),
    "accessor": (lambda j: j["accessors"][1].update(count=99), "/accessors/1/count\n  must fit"),
    "component": (lambda j: j["accessors"][0].update(componentType=7), "must be one of 5120"),
    "view": (lambda j: j["bufferViews"][0].update(byteLength=10**6), "must fit into its buffer"),
    "index": (lambda j: j["nodes"][0].update(mesh=7), "/nodes/0/mesh\n  must be in [0, 2], got 7"),
    "range": (lambda j: j["materials"][0]["pbrMetallicRoughness"].update(metallicFactor=2),
              "/materials/0/pbrMetallicRoughness/metallicFactor\n  must be in [0, 1], got 2"),
    "mode": (lambda j: j["materials"][0].update(alphaMode="MASKED"), 'did you mean "MASK"?'),
    "cycle": (lambda j: j["nodes"][0].update(children=[2]), "stands below two nodes"),
    "uri": (lambda j: j["images"].append({"uri": "../../etc/passwd"})
            or j["textures"][0].update(source=2), "leads out of the folder"),
    "address": (lambda j: j["images"].append({"uri": "http://a/b.png"})
                or j["textures"][0].update(source=2), "must be a file beside the scene"),
    "item": (lambda j: j["nodes"].insert(1, 3), "/nodes/1\n  must be an object, got 3"),
    "matrix": (lambda j: j["nodes"][3].update(matrix=[1] * 16), "must be affine"),
}  # fmt: skip


@pytest.mark.parametrize("kind", BROKEN)
def test_problems_have_a_pointer_and_words(kind, tmp_path):
    change, words = BROKEN[kind]
    (tmp_path / "a.gltf").write_bytes(broken(change))
    with pytest.raises(SceneError) as caught:
        load(tmp_path / "a.gltf")
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "a.gltf"))


def test_containers_that_are_none():
    whole = everything().glb()
    cases = {
        b"glTF": "has 4 bytes",
        whole[:-100]: "is cut off",
        whole[:4] + struct.pack("<I", 1) + whole[8:]: "version 2, got 1",
        b"[1]": "must be a JSON object",
        b"{": "is not JSON",
        b'{"asset": NaN}': "NaN is not a number",
        b"[" * 100_000: "nested too deeply",
        b"\xff\xfe": "must be UTF-8",
        json.dumps({"asset": {"version": "2.0"}, "nodes": 3}).encode(): "must be a list",
    }
    for data, words in cases.items():
        with pytest.raises(SceneError, match=words):
            parse(data, "a.gltf")


@pytest.mark.parametrize("mode", [0, 1, None])
def test_a_file_without_surfaces_says_that_there_is_nothing_to_see(mode, tmp_path):
    m = Maker()
    if mode is not None:
        m.node(mesh=m.square())
        m.json["meshes"][0]["primitives"][0]["mode"] = mode
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    assert any("nothing to see" in line for line in load(tmp_path / "a.gltf").warnings)


def test_a_file_with_a_surface_does_not(tmp_path):
    m = Maker()
    m.node(mesh=m.square())
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    assert not any("nothing to see" in line for line in load(tmp_path / "a.gltf").warnings)
