"""glTF: documents with one thing wrong, or said in another way: what becomes of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from tests.formats.gltf.maker import Maker
from tests.recorded.cases.gltf_corners import Data, _layers, _of, _pictures
from tests.recorded.cases.reader_edits import leaves
from tests.recorded.cases.reader_features import POINTS, UVS, _quaternions
from tests.recorded.making import in_folder

GONE = object()


def _small() -> Maker:
    """A small file with one of everything that a wrong document needs."""
    m = Maker()
    _pictures(m)
    m.material(
        name="paint", normalTexture={"index": 1}, alphaMode="MASK",
        pbrMetallicRoughness={"baseColorTexture": {"index": 0}, "roughnessFactor": 0.4},
        extensions=_layers(ior={"ior": 1.4}, clearcoat={"clearcoatFactor": 0.3}),
    )  # fmt: skip
    faces = np.array([0, 1, 2, 0, 2, 3, 0, 3, 4], "<u2")
    sheet = {
        "POSITION": m.accessor(POINTS), "TEXCOORD_0": m.accessor(UVS),
        "NORMAL": m.accessor((POINTS * 0.2 + [0.1, 0.2, 1]).astype("<f4")),
        "JOINTS_0": m.accessor(np.eye(4, dtype="u1")[[0, 1, 0, 1, 0]] % 2),
        "WEIGHTS_0": m.accessor(np.eye(4, dtype="<f4")[[1, 0, 2, 1, 0]] * 0.7 + 0.1),
    }  # fmt: skip
    moves = {"POSITION": m.accessor((POINTS[:, ::-1] * 0.3).astype("<f4"))}
    m.json["meshes"] = [
        {"primitives": [{"attributes": sheet, "indices": m.accessor(faces), "material": 0,
                         "targets": [moves]}], "weights": [0.4]}
    ]  # fmt: skip
    places = {
        "TRANSLATION": m.accessor(POINTS[:3] * 2), "SCALE": m.accessor(POINTS[1:4] + 2),
        "ROTATION": m.accessor(_quaternions(3)),
    }  # fmt: skip
    toe = m.node(name="toe", translation=[0.2, 0.9, 0.1])
    hip = m.node(name="hip", translation=[0.4, 0.5, 0.6], children=[toe])
    m.node(name="held", mesh=0, skin=0, children=[hip])
    m.node(name="many", mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": places}})
    m.node(name="eye", camera=0, extensions={"KHR_lights_punctual": {"light": 0}})
    bind = np.tile(np.eye(4, dtype="<f4").ravel(), (2, 1))
    bind[:, 12:15] = [[0.1, 0.2, 0.3], [0.5, 0.4, 0.7]]
    m.json["skins"] = [{"joints": [hip, toe], "inverseBindMatrices": m.accessor(bind)}]
    m.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7}}]
    m.json["scenes"] = [{"nodes": [2, 3, 4], "name": "all"}]
    m.json["extensions"] = {"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 2.5, "color": [0.4, 0.7, 0.9], "spot": {}}]}}  # fmt: skip
    times = m.accessor(np.array([0.3, 0.8, 1.7], "<f4"))
    m.json["animations"] = [{
        "samplers": [{"input": times, "output": m.accessor(POINTS[:3])}],
        "channels": [{"sampler": 0, "target": {"node": hip, "path": "translation"}}],
    }]  # fmt: skip
    return m


#: Pointer -> what stands there; each is refused, or says what becomes of it.
EDITS: list[tuple[str, Any]] = [
    ("/accessors/0/count", 0), ("/accessors/0/count", 2.5), ("/accessors/0/count", 5.0),
    ("/accessors/0/count", 99), ("/accessors/0/type", "VEC5"), ("/accessors/0/type", "VEC2"),
    ("/accessors/0/type", GONE), ("/accessors/0/componentType", 5124),
    ("/accessors/0/componentType", "f4"), ("/accessors/0/bufferView", 99),
    ("/accessors/0/bufferView", True), ("/accessors/0/bufferView", GONE),
    ("/accessors/0/byteOffset", -1), ("/accessors/0/byteOffset", 8),
    ("/accessors/0/normalized", 1), ("/accessors/1/count", 4),
    ("/accessors/0", {"count": 2**22 + 1, "componentType": 5126, "type": "VEC3"}),
    ("/accessors/0/sparse", {}), ("/accessors/0/sparse", []),
    ("/accessors/0/sparse", {"count": 1, "indices": {"componentType": 5120}, "values": {}}),
    ("/accessors/0/sparse",
     {"count": 1, "indices": {"componentType": 5123, "bufferView": 0}, "values": {}}),
    ("/accessors/7", {"count": 2, "componentType": 5121, "type": "MAT2"}),
    ("/accessors/7/componentType", 5126), ("/accessors/7/type", "VEC2"),
    ("/bufferViews/3/buffer", 3), ("/bufferViews/3/buffer", GONE),
    ("/bufferViews/3/byteLength", 0), ("/bufferViews/3/byteOffset", 10**7),
    ("/bufferViews/3/byteStride", 5), ("/bufferViews/3/byteStride", 16),
    ("/bufferViews/3/extensions", {"EXT_meshopt_compression": {}}),
    ("/buffers/0/byteLength", 10**6), ("/buffers/0/uri", GONE),
    ("/buffers/0/uri", "data:application/octet-stream,abc"),
    ("/buffers/0/uri", "data:application/octet-stream;base64,a"),
    ("/buffers/0/uri", "none.bin"), ("/buffers/0/uri", "../a.bin"), ("/buffers/0/uri", 3),
    ("/buffers/0/uri", "https://example.org/a.bin"), ("/buffers/0/uri", "sub%20folder/b.bin"),
    ("/meshes/0/primitives/0/mode", 0), ("/meshes/0/primitives/0/mode", 3),
    ("/meshes/0/primitives/0/mode", 5), ("/meshes/0/primitives/0/mode", 7),
    ("/meshes/0/primitives/0/indices", GONE), ("/meshes/0/primitives/0/indices", 1),
    ("/meshes/0/primitives/0/indices", "a"), ("/meshes/0/primitives/0/attributes", GONE),
    ("/meshes/0/primitives/0/attributes/POSITION", GONE),
    ("/meshes/0/primitives/0/attributes/POSITION", 99),
    ("/meshes/0/primitives/0/attributes/NORMAL", 1),
    ("/meshes/0/primitives/0/attributes/NORMAL", 8),
    ("/meshes/0/primitives/0/attributes/TEXCOORD_0", GONE),
    ("/meshes/0/primitives/0/attributes/TANGENT", 4),
    ("/meshes/0/primitives/0/attributes/COLOR_1", 4),
    ("/meshes/0/primitives/0/attributes/JOINTS_0", 4),
    ("/meshes/0/primitives/0/attributes/JOINTS_1", 3),
    ("/meshes/0/primitives/0/attributes/WEIGHTS_0", GONE),
    ("/meshes/0/primitives/0/material", 4), ("/meshes/0/primitives/0/targets", 3),
    ("/meshes/0/primitives/0/targets/0/TEXCOORD_0", 1), ("/meshes/0/primitives", GONE),
    ("/meshes/0/weights", [0.1, 0.2]), ("/meshes/0/weights", []), ("/meshes/0/weights", 3),
    ("/nodes/2/weights", [0.9]), ("/nodes/2/mesh", 1), ("/nodes/2/mesh", -1), ("/nodes/2/skin", 5),
    ("/nodes/2/children", [1, 1]), ("/nodes/2/children", [7, "a"]), ("/nodes/2/children", 1),
    ("/nodes/1/children", [2]), ("/nodes/2/scale", [1, 2]), ("/nodes/2/scale", [1, "a", 2]),
    ("/nodes/2/scale", [0, 0, 0]), ("/nodes/3/scale", [1, 0, 2]),
    ("/nodes/2/scale", [1, 1e16, 2]), ("/nodes/2/rotation", [0, 0, 0, 0]),
    ("/nodes/2/rotation", [0.2, 0.3, 0.1, 0.9]), ("/nodes/2/matrix", [1] * 16),
    ("/nodes/2/matrix", [0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0.5, 0.6, 0.7, 1]),
    ("/nodes/2/name", 5), ("/nodes/3/name", "held"), ("/nodes/3/name", GONE),
    ("/nodes/4/camera", 2), ("/nodes/4/scale", [2, 3, 0.5]), ("/nodes/4/mesh", 0),
    ("/nodes/4/extensions/KHR_lights_punctual/light", 1),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes", GONE),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes", {}),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", 0),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", 99),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", GONE),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/ROTATION", 7),
    ("/nodes/3/extensions/EXT_mesh_gpu_instancing/attributes/_ID", 0),
    ("/skins/0/joints", [1]), ("/skins/0/joints", [1, 9]), ("/skins/0/joints", 3),
    ("/skins/0/joints", [1, 0, 4]), ("/skins/0/inverseBindMatrices", GONE),
    ("/skins/0/inverseBindMatrices", 0),
    ("/cameras/0/type", "panoramic"), ("/cameras/0/type", "orthographic"),
    ("/cameras/0/perspective", GONE), ("/cameras/0/perspective/yfov", 9),
    ("/cameras/0/perspective/yfov", GONE), ("/cameras/0/perspective/aspectRatio", 0.6),
    ("/cameras/0", {"type": "orthographic", "orthographic": {"xmag": 3.1, "ymag": 1.3}}),
    ("/cameras/0", {"type": "orthographic", "orthographic": {"xmag": -2, "ymag": 0}}),
    ("/extensions/KHR_lights_punctual/lights/0/type", "tube"),
    ("/extensions/KHR_lights_punctual/lights/0/type", GONE),
    ("/extensions/KHR_lights_punctual/lights/0/type", "directional"),
    ("/extensions/KHR_lights_punctual/lights/0/spot", GONE),
    ("/extensions/KHR_lights_punctual/lights/0/spot", {"outerConeAngle": 0.7}),
    ("/extensions/KHR_lights_punctual/lights/0/spot", {"innerConeAngle": 0.9}),
    ("/extensions/KHR_lights_punctual/lights/0/color", [0.1, -0.2, 0.3]),
    ("/extensions/KHR_lights_punctual/lights/0/range", 0.5),
    ("/extensions/KHR_lights_punctual", GONE),
    ("/scene", 1), ("/scene", 0), ("/scenes/0/nodes", [4]), ("/scenes", GONE), ("/scenes", []),
    ("/materials/0/alphaMode", "MASKED"), ("/materials/0/alphaMode", 3),
    ("/materials/0/alphaCutoff", -1), ("/materials/0/doubleSided", "yes"),
    ("/materials/0/normalTexture", 3), ("/materials/0/normalTexture", {}),
    ("/materials/0/normalTexture/index", 9), ("/materials/0/normalTexture/scale", "a"),
    ("/materials/0/normalTexture/texCoord", 1), ("/materials/0/normalTexture/texCoord", 16),
    ("/materials/0/pbrMetallicRoughness/roughnessFactor", 1.5),
    ("/materials/0/pbrMetallicRoughness/baseColorFactor", [0.1, 0.2, 0.3]),
    ("/materials/0/pbrMetallicRoughness/baseColorFactor", [0.1, 0.2, 0.3, True]),
    ("/materials/0/pbrMetallicRoughness/baseColorFactor", [0.1, 0.2, 3, 1]),
    ("/materials/0/extensions/KHR_materials_ior/ior", 0.7),
    ("/materials/0/extensions/KHR_materials_ior/ior", 0),
    ("/materials/0/extensions/KHR_materials_ior/ior", 1e16),
    ("/materials/0/extensions/KHR_materials_ior/iro", 1.3),
    ("/materials/0/extensions", []), ("/materials/0/roughness", 0.3), ("/materials/0/name", GONE),
    ("/materials/0/extensions/KHR_materials_varnish", {}),
    ("/materials/0/emissivFactor", [1, 0, 0]), ("/materials/0/extras", {"a": 1}),
    ("/samplers/0/wrapS", 7), ("/textures/0/sampler", 9), ("/textures/0/source", GONE),
    ("/textures/0/source", 9), ("/images/0/bufferView", 2), ("/images/0/bufferView", GONE),
    ("/images/0", {"uri": "none.png"}), ("/images/1", {"uri": "none.png"}),
    ("/images/0", {"uri": "b.png"}), ("/images/0", {"uri": "data:image/png;base64,aaaa"}),
    ("/textures/0", {"extensions": {"KHR_texture_basisu": {"source": 0}}}),
    ("/textures/0", {"extensions": {"MSFT_texture_dds": {"source": 0}}}),
    ("/textures/0", {"extensions": {"EXT_texture_webp": {"source": 9}}}),
    ("/textures/0", {"extensions": {"EXT_texture_webp": {}}}),
    ("/images", GONE), ("/textures", GONE),
    ("/extensionsRequired", ["KHR_lights_punctal"]), ("/extensionsRequired", "KHR_materials_ior"),
    ("/extensionsRequired", ["KHR_texture_basisu", "EXT_meshopt_compression", "ACME_hats"]),
    ("/extensionsUsed", [3]), ("/extensionsUsed", ["ACME_hats", "KHR_materials_ior"]),
    ("/extras", {"a": 3}), ("/asset/extras", 3), ("/asset/version", "1.0"), ("/asset/version", 2.1),
    ("/asset/version", []), ("/asset", GONE), ("/nodes", 5), ("/nodes", [3]), ("/nodes", GONE),
    ("/animation", []), ("/extensions/KHR_xmp", {}), ("/asset/minVersion", "2.0"),
]  # fmt: skip

#: As `EDITS`, of an animation, which is shown at a time.
MOVING: list[tuple[str, Any]] = [
    ("/animations/0/channels/0/target", GONE),
    ("/animations/0/channels/0/sampler", GONE),
    ("/animations/0/channels/0/target/path", "pointer"),
    ("/animations/0/channels/0/target/path", "rotation"),
    ("/animations/0/channels/0/target/node", GONE),
    ("/animations/0/channels/0/target/node", 9),
    ("/animations/0/samplers/0/input", GONE),
    ("/animations/0/samplers/0/output", 2),
    ("/animations/0/samplers/0/input", 0),
    ("/animations/0/samplers/0/interpolation", "CUBIC"),
    ("/animations/0/samplers/0/interpolation", "STEP"),
    ("/animations/0/samplers/0/interpolation", "CUBICSPLINE"),
    ("/animations/0/name", "walk"),
    ("/animations", GONE),
    ("/nodes/1/matrix", [1.0] * 16),
    ("/animations/0/channels/0/target", {"node": 2, "path": "weights"}),
]


def _edited(document: Data, pointer: str, value: Any) -> Data:
    """A copy of a document in which another value stands at a place."""
    copy = json.loads(json.dumps(document))
    *parents, last = pointer.split("/")[1:]
    place = copy
    for key in parents:
        place = place[int(key)] if isinstance(place, list) else place.setdefault(key, {})
    key = int(last) if isinstance(place, list) else last
    if value is GONE:
        del place[key]
    else:
        place[key] = value
    return copy


def _changes(edits: list[tuple[str, Any]], **words: Any) -> Iterator[tuple[str, Any]]:
    """What each edit changes."""
    m = _small()
    files = {"a.gltf": m.gltf(), "sub folder/b.bin": m.data, "b.png": b"no picture"}
    with in_folder(files) as folder:
        document = json.loads(files["a.gltf"])
        right = dict(leaves(_of("a.gltf", **words)))
        for pointer, value in edits:
            text = json.dumps(_edited(document, pointer, value))
            (folder / "a.gltf").write_text(text, "utf-8")
            found = dict(leaves(_of("a.gltf", **words)))
            change = {key: one for key, one in found.items() if right.get(key, GONE) != one}
            kept = right if "refused" in found else found
            gone = dict.fromkeys(".".join(key.split(".")[:4]) for key in right if key not in kept)
            shown = "left out" if value is GONE else json.dumps(value)[:60]
            yield f"{pointer}: {shown}", {**change, **({"gone": [*gone]} if gone else {})}


def _told(edits: list[tuple[str, Any]], **words: Any) -> Callable[[], Any]:
    return lambda: dict(_changes(edits, **words))


CASES = {
    "wrong": _told(EDITS),
    "lenient": _told([one for one in EDITS if "images" in one[0]], lenient=True),
    "moving": _told(MOVING, at=0.5),
}
