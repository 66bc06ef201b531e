"""glTF: materials in general position, a branch of the reader each."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

import alight
from alight.core.errors import AlightError
from alight.scene.dump import dump_scene
from tests.formats.gltf.maker import Maker
from tests.recorded.cases.reader_features import UVS, _texels
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


CASES = {"materials": materials}
