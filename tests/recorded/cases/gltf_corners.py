"""glTF: materials in general position, a branch of the reader each, and wrong documents."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import alight
from alight.core.errors import AlightError
from alight.scene.dump import dump_scene
from tests.formats.gltf.maker import Maker
from tests.recorded.cases.reader_edits import leaves
from tests.recorded.cases.reader_features import POINTS, UVS, _quaternions, _texels
from tests.recorded.making import briefly, described, in_folder

Data = dict[str, Any]


def _of(name: str, **words: Any) -> Data:
    """A scene as plain data, and all that is said of it; or its problems."""
    try:
        scene = alight.load(name, **words)
    except AlightError as error:
        return {"refused": described(str(error)).splitlines()}
    remarks = scene.source.remarks
    return {
        **briefly(dump_scene(scene)),
        "warnings": described(list(scene.warnings)),
        "notes": described(list(remarks.notes)),
        "read": described(remarks.read),
    }


# ---------------------------------------------------------------- materials

#: Index of a picture of colours with opacity, of one of numbers, of a grey one with other wraps.
COLOR, NUMBERS, GREY = 0, 1, 2


def _on(index: int, **more: Any) -> Data:
    return {"index": index, **more}


def _moved(index: int, **more: Any) -> Data:
    """A texture whose coordinates are moved."""
    return _on(index, extensions={"KHR_texture_transform": more})


def _layers(**layers: Data) -> Data:
    return {f"KHR_materials_{name}": layer for name, layer in layers.items()}


def _plain(roughness: Any, metallic: float = 0.0, color: Any = (0.7, 0.6, 0.4, 0.9)) -> Data:
    return {
        "baseColorFactor": list(color),
        "metallicFactor": metallic,
        "roughnessFactor": roughness,
    }


VOLUME = {"thicknessFactor": 0.6, "attenuationDistance": 0.45, "attenuationColor": [0.8, 0.5, 0.3]}
ENTERS = {"diffuseTransmissionFactor": 1.0}
SCATTERS = {"multiscatterColor": [0.7, 0.4, 0.2], "scatterAnisotropy": -0.3}


def _body(pbr: Data, scatter: Data = SCATTERS, volume: Data = VOLUME, **more: Data) -> Data:
    layers = {"diffuse_transmission": ENTERS, "volume_scatter": scatter, "volume": volume, **more}
    return {"pbrMetallicRoughness": pbr, "extensions": _layers(**layers)}


#: By name: what a material says. No two numbers are alike, and no colour is grey.
MATERIALS: dict[str, Data] = {
    "nothing": {},
    "metal by index 0": {
        "pbrMetallicRoughness": _plain(0.31, color=(0.0, 0.0, 0.0, 1.0)),
        "extensions": _layers(
            ior={"ior": 0.0},
            specular={"specularFactor": 0.9, "specularColorFactor": [0.95, 0.7, 1.4],
                      "specularColorTexture": _on(COLOR)},
        ),
    },
    "no metal by index 0": {
        "pbrMetallicRoughness": _plain(0.32),
        "extensions": _layers(ior={"ior": 0}, specular={"specularTexture": _on(NUMBERS)}),
    },
    "metal beside index 0": {
        "pbrMetallicRoughness": _plain(0.33, 0.4),
        "extensions": _layers(ior={"ior": 0}, specular={"specularColorFactor": [0.3, 0.2, 0.1]}),
    },
    "too dense": {"extensions": _layers(ior={"ior": 4.7})},
    "tinted": {
        "pbrMetallicRoughness": _plain(0.34),
        "extensions": _layers(ior={"ior": 1.33}, specular={
            "specularFactor": 0.8, "specularColorFactor": [1.9, 1.2, 0.6]}),
    },
    "tinted beyond": {"extensions": _layers(specular={"specularColorFactor": [30, 21, 13]})},
    "tinted glass": {
        "pbrMetallicRoughness": _plain(0.11),
        "extensions": _layers(
            specular={"specularColorFactor": [1.3, 0.8, 0.5]},
            transmission={"transmissionFactor": 0.65},
            volume={**VOLUME, "thicknessTexture": _on(NUMBERS)},
            dispersion={"dispersion": 40.0},
        ),
    },
    "clear": {"extensions": _layers(
        transmission={"transmissionFactor": 0.9, "transmissionTexture": _on(NUMBERS)},
        volume={"thicknessFactor": 0.2}, dispersion={"dispersion": 0.0},
    )},
    "dispersing": {"extensions": _layers(
        ior={"ior": 1.52}, transmission={"transmissionFactor": 0.9},
        volume={"thicknessFactor": 0.2}, dispersion={"dispersion": 0.31},
    )},
    "not let through": {"extensions": _layers(transmission={}, volume=VOLUME)},
    "coat as below": {
        "normalTexture": _on(NUMBERS, scale=0.7),
        "extensions": _layers(clearcoat={
            "clearcoatFactor": 0.6, "clearcoatRoughnessFactor": 0.9,
            "clearcoatRoughnessTexture": _on(NUMBERS),
            "clearcoatNormalTexture": _on(NUMBERS, scale=0.7),
        }),
    },
    "smooth coat": {
        "normalTexture": _on(NUMBERS),
        "extensions": _layers(clearcoat={"clearcoatFactor": 0.4}),
    },
    "no coat": {"normalTexture": _on(NUMBERS, scale=-0.4), "extensions": _layers(clearcoat={})},
    "bent coat": {"extensions": _layers(clearcoat={
        "clearcoatFactor": 0.3, "clearcoatNormalTexture": _on(NUMBERS)})},
    "velvet": {"extensions": _layers(sheen={
        "sheenColorFactor": [0.6, 0.3, 0.2], "sheenRoughnessFactor": 0.75,
        "sheenRoughnessTexture": _on(COLOR)})},
    "brushed": {
        "pbrMetallicRoughness": {"metallicRoughnessTexture": _on(NUMBERS), "roughnessFactor": 0.35},
        "extensions": _layers(anisotropy={"anisotropyStrength": 0.8, "anisotropyRotation": -1.1}),
    },
    "film": {"extensions": _layers(iridescence={
        "iridescenceFactor": 0.45, "iridescenceTexture": _on(NUMBERS),
        "iridescenceThicknessMaximum": 340.0})},
    "film by default": {"extensions": _layers(iridescence={
        "iridescenceFactor": 0.55, "iridescenceThicknessTexture": _on(NUMBERS)})},
    "unlit": {
        "pbrMetallicRoughness": _plain(0.36), "doubleSided": True, "alphaMode": "BLEND",
        "extensions": _layers(unlit={}, volume_scatter=SCATTERS),
    },
    "shines": {
        "emissiveFactor": [0.7, 0.4, 0.1], "alphaMode": "MASK", "doubleSided": True,
        "pbrMetallicRoughness": {"baseColorTexture": _on(COLOR), "baseColorFactor": [1, 1, 1, 0.8]},
        "extensions": _layers(emissive_strength={"emissiveStrength": 6.5}),
    },
    "shines by a picture": {
        "emissiveFactor": [0.2, 0.9, 0.5], "emissiveTexture": _on(GREY),
        "extensions": _layers(emissive_strength={}),
    },
    "dark": {"emissiveTexture": _on(COLOR), "doubleSided": True},
    "holes": {
        "alphaMode": "MASK", "alphaCutoff": 0.7,
        "pbrMetallicRoughness": {"baseColorTexture": _on(COLOR), "baseColorFactor": [1, 1, 1, 0.9]},
    },
    "fades": {
        "alphaMode": "BLEND", "pbrMetallicRoughness": _plain(0.37, color=(0.2, 0.5, 0.7, 0.4)),
    },
    "opaque": {"pbrMetallicRoughness": _plain(0.38, color=(0.6, 0.3, 0.7, 0.3))},
    "glossy": {"extensions": _layers(pbrSpecularGlossiness={
        "diffuseFactor": [0.5, 0.3, 0.6, 0.7], "specularFactor": [0.03, 0.04, 0.02],
        "diffuseTexture": _on(COLOR), "glossinessFactor": 0.55})},
    "glossy by default": {"extensions": _layers(pbrSpecularGlossiness={})},
    "glossy metal": {"extensions": _layers(pbrSpecularGlossiness={
        "diffuseFactor": [0, 0, 0, 1], "specularFactor": [0.8, 0.6, 0.3],
        "specularGlossinessTexture": _on(COLOR)})},
    "moved": {
        "pbrMetallicRoughness": {
            "baseColorTexture": _moved(GREY, offset=[0.3, -0.2], rotation=-0.8, texCoord=2)},
        "normalTexture": _moved(NUMBERS, scale=[0.7, 1.9]),
        "emissiveTexture": _moved(COLOR), "emissiveFactor": [0.1, 0.2, 0.3],
    },
    "three sets": {
        "pbrMetallicRoughness": {
            "baseColorTexture": _on(COLOR, texCoord=1),
            "metallicRoughnessTexture": _on(NUMBERS, texCoord=2)},
        "emissiveTexture": _on(GREY, texCoord=3), "emissiveFactor": [0.3, 0.2, 0.1],
        "normalTexture": _on(NUMBERS, texCoord=0),
        "occlusionTexture": _on(NUMBERS, texCoord=4),
        "extensions": _layers(
            specular={"specularTexture": _on(NUMBERS, texCoord=4)},
            sheen={"sheenColorFactor": [1, 0.9, 0.8], "sheenColorTexture": _on(COLOR, texCoord=5)},
        ),
    },
    "jade": _body(_plain(0.41, color=(1, 1, 1, 1)), ior={"ior": 1.4}),
    "rough jade": _body({"metallicFactor": 0, "metallicRoughnessTexture": _on(NUMBERS)},
                        {}, {"thicknessFactor": 1}, specular={"specularTexture": _on(NUMBERS)}),
    "weak jade": _body(_plain(0.42), {"multiscatterColor": [0.2, 0.9, 0.6]}, specular={
        "specularFactor": 0.5, "specularColorFactor": [0.9, 0.5, 0.7]}),
    "metal jade": _body(_plain(0.43, 0.5)),
    "coated jade": _body(_plain(0.44), clearcoat={"clearcoatFactor": 0.2}),
    "half jade": _body(_plain(0.45), diffuse_transmission={"diffuseTransmissionFactor": 0.5}),
    "green jade": _body(_plain(0.46), diffuse_transmission={
        **ENTERS, "diffuseTransmissionColorFactor": [0.5, 1, 0.5]}),
    "painted jade": _body(_plain(0.47), diffuse_transmission={
        **ENTERS, "diffuseTransmissionTexture": _on(NUMBERS)}),
    "fading jade": {**_body(_plain(0.48)), "alphaMode": "BLEND"},
    "leaf": {"extensions": _layers(diffuse_transmission={"diffuseTransmissionFactor": 0.3})},
    "other pictures": {
        "pbrMetallicRoughness": {"baseColorTexture": _on(3)},
        "emissiveTexture": _on(4), "emissiveFactor": [0.4, 0.5, 0.6],
        "normalTexture": _on(5),
    },
}  # fmt: skip


def _solid(m: Maker) -> Data:
    """A closed mesh with five sets of coordinates and colours of its vertices."""
    corners = np.array([[0, 0, 0.1], [1, 0.2, 0], [0.3, 1.1, 0.2], [0.4, 0.3, 1.2]], "<f4")
    faces = np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], "u1")
    return {
        "attributes": {
            "POSITION": m.accessor(corners),
            **{f"TEXCOORD_{n}": m.accessor(UVS[:4] * (0.3 + 0.1 * n)) for n in range(5)},
        },
        "indices": m.accessor(faces),
    }


def _pictures(m: Maker) -> None:
    m.picture(_texels(3, 4, 4), wrapS=33071, wrapT=33648)
    m.picture(_texels(4, 3, 3), magFilter=9728, minFilter=9987)
    m.picture(_texels(2, 3, 1)[..., 0], wrapS=33648, wrapT=10497, magFilter=9729)
    m.json["textures"] += [
        {"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}},
        {"extensions": {"EXT_texture_webp": {"source": 2}}, "sampler": 2},
        {"source": 0, "sampler": 0, "extensions": {"EXT_texture_webp": {"source": 2}}},
    ]


def _everything() -> Maker:
    m = Maker()
    _pictures(m)
    solid = _solid(m)
    for name, material in MATERIALS.items():
        m.json["meshes"].append({"primitives": [solid | {"material": len(m.json["materials"])}]})
        m.material(name=name, **material)
        m.node(mesh=len(m.json["meshes"]) - 1, name=name)
    colors = (_texels(4, 1, 4)[:, 0] / 260.0).astype("<f4")
    painted = {"attributes": {**solid["attributes"], "COLOR_0": m.accessor(colors)}}
    names = [*MATERIALS]
    m.json["meshes"].append({"primitives": [
        solid | painted | {"material": names.index(name)}
        for name in ("fades", "holes", "shines", "opaque", "unlit", "glossy")
    ]})  # fmt: skip
    m.node(mesh=len(m.json["meshes"]) - 1, name="painted", translation=[0.1, 2.2, 3.3])
    return m


def materials() -> Any:
    """What becomes of each material, where its sets of coordinates go, and what is said."""
    with in_folder({"a.glb": _everything().glb()}):
        found = _of("a.glb")
    seen: set[str] = set()
    for node in found["nodes"].values():
        for one in (node, *node.get("children", {}).values()):
            # The mesh is the same for all that have the same coordinates.
            shape = json.dumps(one.get("shape"))
            if shape in seen:
                del one["shape"]
            seen.add(shape)
    return found


# ---------------------------------------------------------------- wrong documents

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
    "materials": materials,
    "wrong": _told(EDITS),
    "lenient": _told([one for one in EDITS if "images" in one[0]], lenient=True),
    "moving": _told(MOVING, at=0.5),
}
