"""Features of scene files that few files have, in general position: what readers make of them."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import alight
from alight.scene.dump import dump_scene
from alight.scene.flatten import flatten
from tests.formats.gltf.maker import Maker
from tests.recorded.making import briefly, described, in_folder, outcome

FOLDER = Path(__file__).parents[1] / "features"

#: Corners of two triangles and a half, in no plane.
POINTS = np.array(
    [[0, 0, 0.1], [1.2, 0.1, -0.2], [1.1, 1.3, 0.3], [0.2, 0.9, 0.4], [-0.7, 0.6, 0.2]], "<f4"
)
UVS = np.array([[0.1, 0.2], [0.9, 0.3], [0.7, 0.8], [0.2, 0.6], [0.4, 0.95]], "<f4")


def _texels(height: int, width: int, channels: int) -> np.ndarray:
    """Bytes that differ in all directions and channels."""
    return (np.arange(height * width * channels) * 37 % 251).astype(np.uint8).reshape(
        height, width, channels
    )  # fmt: skip


def _volume(channels: int) -> bytes:
    values = (np.arange(2 * 3 * 2 * channels) * 7 % 11 / 12.0).astype("<f4")
    head = struct.pack("<3sBiiiii6f", b"VOL", 3, 1, 2, 3, 2, channels, 0.1, 0.2, 0.3, 1.5, 2.7, 1.9)
    return head + values.tobytes()


#: Four control points of a strand and five of another one.
STRANDS = """0 0 0.1 0.05
0.3 0.5 0.2 0.04
0.1 0.9 0.6 0.03
0.5 1.2 0.4 0.01

1 0.2 0 0.06
1.1 0.6 0.3 0.05
0.9 1.1 0.7 0.02
1.3 1.4 0.9 0.03
1.6 1.3 1.1 0.01
"""


def _files() -> dict[str, str | bytes]:
    texts: dict[str, str | bytes] = {path.name: path.read_bytes() for path in FOLDER.iterdir()}
    texts["a.ply"] = (FOLDER.with_name("scenes") / "a.ply").read_bytes()
    texts |= {"density.vol": _volume(1), "albedo.vol": _volume(3), "strands.txt": STRANDS}
    return texts


def _pictures() -> None:
    from alight.outputs import write_image

    for name, sides in (("a.png", (3, 4)), ("s.png", (4, 4)), ("wide.png", (3, 6))):
        write_image(name, _texels(*sides, 3).astype(np.float32) / 255.0)
    for tile in (1001, 1002, 1012):
        write_image(f"t.{tile}.png", _texels(2, 3, 3).astype(np.float32) / 255.0 * tile / 1012)
    write_image("a.exr", _texels(3, 6, 3).astype(np.float32) / 100.0)


def _told(name: str, **words: Any) -> dict[str, Any]:
    """A scene as plain data, where its surfaces lie, and what is said of it."""
    scene = alight.load(name, lenient=True, **words)
    flat = flatten(scene)
    return {
        "scene": briefly(dump_scene(scene)),
        "placed": [described(item.to_world, 16) for item in flat.shapes],
        "warnings": described(list(scene.warnings)),
        "dropped": described(list(scene.source.remarks.notes)),
    }


def _read(name: str, **words: Any) -> Any:
    with in_folder(_files()):
        _pictures()
        return outcome(_told, name, **words)


def _of(name: str, **words: Any) -> Callable[[], Any]:
    return lambda: _read(name, **words)


# ---------------------------------------------------------------- glTF


def _sheet(m: Maker, **attributes: int) -> dict[str, Any]:
    return {"POSITION": m.accessor(POINTS), "TEXCOORD_0": m.accessor(UVS), **attributes}


def _mesh(m: Maker, attributes: dict[str, Any], **more: Any) -> int:
    faces = m.accessor(np.array([0, 1, 2, 0, 2, 3, 0, 3, 4], "<u2"))
    m.json["meshes"].append({"primitives": [{"attributes": attributes, "indices": faces, **more}]})
    return len(m.json["meshes"]) - 1


def _packed(m: Maker) -> dict[str, int]:
    """Accessors of a view with a stride, a sparse one, and normalised whole numbers."""
    rows = np.zeros(5, [("p", "<f4", 3), ("n", "i1", 4), ("t", "<u2", 2), ("c", "u1", 4)])
    rows["p"] = POINTS[::-1]
    rows["n"][:, :3] = [[9, 20, 110], [-30, 15, 99], [40, -8, 90], [12, 33, 101], [-128, 5, 77]]
    rows["t"] = [[100, 60000], [30000, 50000], [65535, 1234], [777, 40000], [22222, 11111]]
    rows["c"] = _texels(5, 1, 4)[:, 0]
    view = m.view(b"\1\2\3\4" + rows.tobytes(), byteStride=rows.itemsize)
    accessors = m.json["accessors"]
    found = {}
    for name, offset, kind, width, normalized in (
        ("POSITION", 0, 5126, 3, False), ("NORMAL", 12, 5120, 3, True),
        ("TEXCOORD_0", 16, 5123, 2, True), ("COLOR_0", 20, 5121, 4, True),
    ):  # fmt: skip
        accessors.append({
            "bufferView": view, "byteOffset": 4 + offset, "count": 5, "componentType": kind,
            "type": {2: "VEC2", 3: "VEC3", 4: "VEC4"}[width],
            **({"normalized": True} if normalized else {}),
        })  # fmt: skip
        found[name] = len(accessors) - 1
    places, values = np.array([1, 3], "<u2"), np.array([[9, 8, 7], [0.5, 0.6, -0.7]], "<f4")
    accessors[found["POSITION"]]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": m.view(b"\0\0" + places.tobytes()), "byteOffset": 2,
                    "componentType": 5123},
        "values": {"bufferView": m.view(values.tobytes())},
    }  # fmt: skip
    accessors.append({
        "count": 5, "componentType": 5126, "type": "VEC2",
        "sparse": {"count": 1, "indices": {"bufferView": m.view(b"\2"), "componentType": 5121},
                   "values": {"bufferView": m.view(UVS[1:2].tobytes())}},
    })  # fmt: skip
    return found | {"TEXCOORD_1": len(accessors) - 1}


def _materials(m: Maker) -> list[int]:
    color, data = m.picture(_texels(3, 4, 4), wrapS=33071, wrapT=33648), m.picture(_texels(4, 3, 3))
    moved = {"offset": [0.15, 0.35], "rotation": 0.6, "scale": [1.7, -0.8], "texCoord": 1}
    turned = {"index": data, "extensions": {"KHR_texture_transform": moved}}
    layers = {
        "KHR_materials_ior": {"ior": 1.37},
        "KHR_materials_specular": {"specularFactor": 0.6, "specularTexture": {"index": color},
                                   "specularColorFactor": [0.9, 0.7, 0.5]},
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.7, "clearcoatTexture": turned, "clearcoatRoughnessFactor": 0.25,
            "clearcoatNormalTexture": {"index": data, "scale": 0.6},
        },
        "KHR_materials_sheen": {"sheenColorFactor": [0.15, 0.25, 0.35],
                                "sheenRoughnessFactor": 0.45, "sheenColorTexture": turned},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.55, "anisotropyRotation": 0.35,
                                     "anisotropyTexture": {"index": data}},
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.65, "iridescenceIor": 1.6, "iridescenceThicknessMinimum": 150,
            "iridescenceThicknessMaximum": 550, "iridescenceThicknessTexture": {"index": data},
        },
    }  # fmt: skip
    return [
        m.material(
            name="layers", alphaMode="MASK", alphaCutoff=0.35, doubleSided=True,
            pbrMetallicRoughness={
                "baseColorTexture": {"index": color}, "baseColorFactor": [0.9, 0.5, 0.3, 0.75],
                "metallicRoughnessTexture": turned, "metallicFactor": 0.55, "roughnessFactor": 0.8,
            },
            normalTexture={"index": data, "scale": 0.4, "texCoord": 1},
            emissiveFactor=[0.2, 0.4, 0.6], emissiveTexture=turned,
            occlusionTexture={"index": data}, extensions=layers,
        ),
        m.material(
            name="bent", normalTexture={"index": data},
            pbrMetallicRoughness={"metallicFactor": 0.1, "roughnessFactor": 0.3},
        ),
        m.material(
            name="glass", pbrMetallicRoughness={"metallicFactor": 0, "roughnessFactor": 0.15},
            extensions={
                "KHR_materials_transmission": {"transmissionFactor": 0.85,
                                               "transmissionTexture": {"index": data}},
                "KHR_materials_dispersion": {"dispersion": 0.4}, "KHR_materials_ior": {"ior": 1.6},
                "KHR_materials_volume": {"thicknessFactor": 0.8, "attenuationDistance": 0.3,
                                         "attenuationColor": [0.9, 0.6, 0.4]},
            },
        ),
        m.material(
            name="pane", extensions={"KHR_materials_transmission": {"transmissionFactor": 0.9}}
        ),
        m.material(name="old", extensions={
            "KHR_materials_pbrSpecularGlossiness": {
                "diffuseFactor": [0.3, 0.4, 0.2, 0.9], "specularFactor": [0.05, 0.06, 0.04],
                "glossinessFactor": 0.65, "specularGlossinessTexture": {"index": color},
            },
        }),
        m.material(name="metal", extensions={"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.01, 0.01, 0.01, 1], "specularFactor": [0.9, 0.7, 0.5],
            "glossinessFactor": 0.85,
        }}),
        m.material(
            name="jade", pbrMetallicRoughness={"metallicFactor": 0, "roughnessFactor": 0.35},
            extensions={
                "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1.0},
                "KHR_materials_volume_scatter": {"multiscatterColor": [0.6, 0.8, 0.4],
                                                 "scatterAnisotropy": 0.2},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.4,
                                         "attenuationColor": [0.7, 0.9, 0.5]},
                "KHR_materials_ior": {"ior": 1.45},
            },
        ),
    ]  # fmt: skip


def _quaternions(count: int) -> np.ndarray:
    turns = RANDOM_TURNS[:count]
    return (turns / np.linalg.norm(turns, axis=1, keepdims=True)).astype("<f4")


RANDOM_TURNS = np.array(
    [[0.1, 0.5, -0.3, 0.8], [0.6, -0.2, 0.4, 0.5], [-0.3, 0.7, 0.2, -0.6], [0.2, 0.1, 0.9, 0.4]]
)


def _everything() -> Maker:
    """A file with all of it."""
    m = Maker()
    layered, bent, glass, pane, old, metal, jade = _materials(m)
    m.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing", "KHR_lights_punctual"]
    packed = _mesh(
        m, _packed(m), material=layered,
        extensions={"KHR_materials_variants": {"mappings": [
            {"variants": [1], "material": bent}, {"variants": [0], "material": old},
        ]}},
    )  # fmt: skip
    tangents = np.c_[POINTS[:, ::-1] + 0.3, [1, -1, 1, 1, -1]].astype("<f4")
    normals = (POINTS * 0.2 + [0.1, 0.2, 1]).astype("<f4")
    shaped = {
        "NORMAL": m.accessor(normals), "TANGENT": m.accessor(tangents),
        "JOINTS_0": m.accessor(np.array(
            [[0, 1, 2, 0], [1, 2, 0, 0], [2, 0, 1, 1], [0, 2, 1, 0], [1, 0, 2, 2]], "u1")),
        "WEIGHTS_0": m.accessor(np.array(
            [[200, 40, 15, 0], [90, 100, 65, 0], [120, 60, 50, 25], [30, 215, 10, 0],
             [70, 80, 90, 15]], "u1"), normalized=True),
    }  # fmt: skip
    targets = [
        {"POSITION": m.accessor((POINTS[:, [1, 2, 0]] * 0.3).astype("<f4")),
         "NORMAL": m.accessor((POINTS[:, [2, 0, 1]] * 0.1).astype("<f4"))},
        {"POSITION": m.accessor((POINTS[:, [2, 1, 0]] * 0.2 + 0.1).astype("<f4"))},
    ]  # fmt: skip
    skinned = _mesh(m, _sheet(m, **shaped), material=bent, targets=targets)
    m.json["meshes"][skinned]["weights"] = [0.7, -0.4]
    strip = _mesh(m, _sheet(m), material=old, mode=5)
    fan = _mesh(m, _sheet(m), material=metal, mode=6)
    others = [_mesh(m, _sheet(m), material=number) for number in (glass, pane, jade)]
    closed = m.accessor(np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], "<u4"))
    m.json["meshes"].append({"primitives": [
        {"attributes": {"POSITION": m.accessor(np.array(
            [[0, 0, 0.1], [1, 0.2, 0], [0.3, 1.1, 0.2], [0.4, 0.3, 1.2]], "<f4"))},
         "indices": closed, "material": jade}]})  # fmt: skip
    body = len(m.json["meshes"]) - 1
    places = {
        "TRANSLATION": m.accessor(np.array([[1, 2, 3], [-4, 0.5, 1.5], [2.5, -1, 0.7]], "<f4")),
        "ROTATION": m.accessor((_quaternions(3) * 32767).astype("<i2"), normalized=True),
        "SCALE": m.accessor(np.array([[1, 2, 0.5], [0.7, 0.8, 1.9], [1.3, 0.6, 1.1]], "<f4")),
    }
    turns = _quaternions(4).tolist()
    m.node(name="many", mesh=strip, translation=[0.3, 0.2, 0.1], rotation=turns[3],
           extensions={"EXT_mesh_gpu_instancing": {"attributes": places}})  # fmt: skip
    toe = m.node(name="toe", translation=[0.2, 0.9, 0.1], rotation=turns[0])
    knee = m.node(name="knee", children=[toe], translation=[0.1, 1.1, 0], rotation=turns[1],
                  scale=[1.1, 0.9, 1.2])  # fmt: skip
    hip = m.node(name="hip", children=[knee], translation=[0.4, 0.5, 0.6], rotation=turns[2])
    m.json["skins"] = [{
        "joints": [knee, toe, hip],
        "inverseBindMatrices": m.accessor(np.array([
            [1, 0, 0.1, 0, 0, 0.8, 0.6, 0, 0, -0.6, 0.8, 0, 0.1 * i, -0.5 * i, 0.2, 1]
            for i in range(3)
        ], "<f4")),
    }]  # fmt: skip
    m.node(
        name="beast",
        mesh=skinned,
        skin=0,
        translation=[5, 1, 2],
        scale=[0, 0, 0],
        weights=[0.5, 0.3],
    )
    m.node(name="packed", mesh=packed, children=[hip],
           matrix=[1, 0.2, 0, 0, 0.1, 0.9, 0.3, 0, 0, -0.2, 1.2, 0, 0.5, 0.4, 0.3, 1])  # fmt: skip
    m.node(name="fan", mesh=fan, translation=[0.1, 0.2, 0.3], scale=[1.1, 0.8, -1.3])
    for number in (*others, body):
        m.node(mesh=number, rotation=turns[number % 4], translation=[number, 0.3, 0.4])
    m.json["extensions"] = {
        "KHR_materials_variants": {"variants": [{"name": "dawn"}, {"name": "dusk"}]},
        "KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 5.5, "color": [0.9, 0.5, 0.2], "range": 7.0,
             "spot": {"outerConeAngle": 0.6, "innerConeAngle": 0.25}},
            {"type": "directional", "intensity": 2.5, "color": [0.3, 0.6, 0.8]},
            {"type": "point", "intensity": 3.5, "color": [0.2, 0.4, 0.9]},
        ]},
    }  # fmt: skip
    for light in range(3):
        m.node(rotation=turns[light], translation=[light + 0.5, 1.5, 2.5],
               extensions={"KHR_lights_punctual": {"light": light}})  # fmt: skip
    m.json["cameras"] = [
        {"type": "perspective", "perspective": {"yfov": 0.65, "aspectRatio": 1.6, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 2.5, "ymag": 1.5, "znear": 0, "zfar": 9}},
    ]
    eye = m.node(camera=1, name="flat", translation=[0.2, 0.3, 7])
    m.node(children=[eye], rotation=turns[3], scale=[1.2, 1.2, 1.2])
    roots = [i for i in range(len(m.json["nodes"])) if i not in (toe, knee, hip, eye)]
    m.json["scenes"] = [{"nodes": roots}]
    _animate(m, knee, toe, hip)
    return m


def _animate(m: Maker, *joints: int) -> None:
    times = m.accessor(np.array([0.2, 0.7, 1.9], "<f4"))
    turns, moves = _quaternions(3), np.array([[0, 1, 0.2], [0.3, 1.4, 0.1], [0.5, 0.9, 0.6]], "<f4")
    sizes = np.array([[1, 1.2, 0.8], [0.9, 1.1, 1.3], [1.4, 0.7, 1]], "<f4")
    tangents = np.array([[0.1, 0.3, 0.2], [0.4, -0.2, 0.1], [-0.3, 0.2, 0.5]], "<f4")
    spline = np.stack([tangents, moves, tangents[::-1]], axis=1).reshape(9, 3)
    outputs = [("rotation", turns, "LINEAR"), ("translation", spline, "CUBICSPLINE"),
               ("scale", sizes, "STEP")]  # fmt: skip
    m.json["animations"] = [{
        "name": "walk",
        "samplers": [
            {"input": times, "output": m.accessor(np.ascontiguousarray(table, "<f4")),
             "interpolation": how}
            for _, table, how in outputs
        ],
        "channels": [
            {"sampler": i, "target": {"node": joint, "path": path}}
            for i, (joint, (path, _, _)) in enumerate(zip(joints, outputs, strict=True))
        ],
    }]  # fmt: skip


def gltf() -> Any:
    """Strides, sparse and whole numbers, skins, splines, instances, variants, layers, lamps."""
    m = _everything()
    found = {}
    with in_folder({"a.gltf": m.gltf(), "a.glb": m.glb()}):
        found["rests"] = outcome(_told, "a.gltf")
        found["dusk"] = outcome(_told, "a.glb", variant="dusk")
        for at in (0.0, 0.55, 0.9, 5.0):
            moved = outcome(_told, "a.glb", animation="walk", at=at)
            found[f"at {at}"] = moved["scene"]["nodes"] if isinstance(moved, dict) else moved
    return found


CASES = {
    # Steps of transforms, subdivision, strands, points, instances, skins, lamps, networks.
    "usd": _of("a.usda"), "usd_later": _of("a.usda", at=0.3),
    # Objects, media, lenses, patterns, lamps with power; surfaces of pbrt 3.
    "pbrt": _of("objects.pbrt"), "pbrt_3": _of("old.pbrt"),
    # Grids, strands, motion, projectors, daylight; mixtures and coats of version 0.6.
    "mitsuba": _of("interiors.xml"), "mitsuba_06": _of("old.xml"),
    "gltf": gltf,
}  # fmt: skip
