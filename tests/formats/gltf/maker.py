"""Small glTF files, made part by part."""

from __future__ import annotations

import base64
import io
import json
import struct

import numpy as np
from PIL import Image

TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}

#: A unit square in the plane z = 0, seen from +z; texture coordinates run downwards, as in glTF.
POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
UVS = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4")
FACES = np.array([0, 1, 2, 0, 2, 3], "<u2")


class Maker:
    """A file in the making; `json` is the document."""

    def __init__(self) -> None:
        self.json: dict = {
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "buffers": [{}],
            "meshes": [], "materials": [], "nodes": [], "textures": [], "images": [],
        }  # fmt: skip
        self.data = b""

    def view(self, data: bytes, **more) -> int:
        """Append bytes; the index of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more}
        self.json["bufferViews"].append(view)
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, table: np.ndarray, **more) -> int:
        """Append a table; the index of its accessor."""
        table = np.ascontiguousarray(table)
        columns = 1 if table.ndim == 1 else table.shape[1]
        item = {
            "bufferView": self.view(table.tobytes()), "count": len(table),
            "componentType": COMPONENTS[table.dtype.str[1:]], "type": TYPES[columns], **more,
        }  # fmt: skip
        self.json["accessors"].append(item)
        return len(self.json["accessors"]) - 1

    def square(self, material: int | None = None, **attributes: int) -> int:
        """Append a mesh of two triangles; its index."""
        primitive = {
            "attributes": {
                "POSITION": self.accessor(POINTS), "TEXCOORD_0": self.accessor(UVS), **attributes,
            },
            "indices": self.accessor(FACES),
        }  # fmt: skip
        if material is not None:
            primitive["material"] = material
        self.json["meshes"].append({"primitives": [primitive]})
        return len(self.json["meshes"]) - 1

    def picture(self, pixels: np.ndarray, **sampler) -> int:
        """Append a PNG and a texture that shows it; the texture's index."""
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "PNG")
        self.json["images"].append(
            {"bufferView": self.view(file.getvalue()), "mimeType": "image/png"}
        )
        texture = {"source": len(self.json["images"]) - 1}
        if sampler:
            self.json.setdefault("samplers", []).append(sampler)
            texture["sampler"] = len(self.json["samplers"]) - 1
        self.json["textures"].append(texture)
        return len(self.json["textures"]) - 1

    def material(self, **material) -> int:
        """Append a material; its index."""
        self.json["materials"].append(material)
        return len(self.json["materials"]) - 1

    def node(self, **node) -> int:
        """Append a node; its index."""
        self.json["nodes"].append(node)
        return len(self.json["nodes"]) - 1

    def gltf(self) -> bytes:
        """The file as .gltf, with its buffer in a data URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        self.json["buffers"] = [{"byteLength": len(self.data), "uri": uri}]
        return json.dumps(self._plain()).encode()

    def glb(self) -> bytes:
        """The file as .glb."""
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self._plain()).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        size = 12 + 8 + len(text) + 8 + len(data)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(data), 0x004E4942) + data
        return struct.pack("<4sII", b"glTF", 2, size) + chunks

    def _plain(self) -> dict:
        return {key: value for key, value in self.json.items() if value != []}


def everything() -> Maker:
    """A file that uses most of what is read."""
    m = Maker()
    rng = np.random.default_rng(3)
    color = m.picture(rng.integers(0, 256, (4, 8, 4)).astype(np.uint8), wrapS=33071, wrapT=33648)
    data = m.picture(rng.integers(0, 256, (4, 4, 3)).astype(np.uint8), magFilter=9728)
    moved = {"offset": [0.25, 0.5], "rotation": 0.5, "scale": [2.0, -1.0]}
    info = {"index": color, "extensions": {"KHR_texture_transform": moved}}
    m.json["extensionsUsed"] = ["KHR_texture_transform", "KHR_lights_punctual", "ACME_hats"]
    extensions = {
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": color}},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.7, "clearcoatTexture": {"index": data}},
        "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 0.3},
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.5, "iridescenceThicknessTexture": {"index": data},
        },
        "ACME_glitter": {},
    }  # fmt: skip
    first = m.material(
        name="all", alphaMode="MASK", alphaCutoff=0.25, doubleSided=True,
        pbrMetallicRoughness={
            "baseColorTexture": info, "baseColorFactor": [1, 0.5, 0.25, 0.75],
            "metallicRoughnessTexture": {"index": data}, "metallicFactor": 0.5,
        },
        normalTexture={"index": data, "scale": 0.5}, occlusionTexture={"index": data},
        extensions=extensions,
    )  # fmt: skip
    glass = m.material(
        name="glass",
        extensions={
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationColor": [0.5, 1, 1],
                                     "attenuationDistance": 2.0},
        },
    )  # fmt: skip
    glowing = m.material(
        emissiveFactor=[1, 0.5, 0], emissiveTexture={"index": color}, alphaMode="BLEND",
        pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.5]},
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
    )  # fmt: skip
    colors = m.accessor(rng.integers(0, 256, (4, 4)).astype(np.uint8), normalized=True)
    plain, clear, lamp = m.square(first, COLOR_0=colors), m.square(glass), m.square(glowing)
    m.json["extensions"] = {
        "KHR_lights_punctual": {
            "lights": [
                {"type": "spot", "intensity": 5, "color": [1, 0.5, 0.2], "name": "lamp",
                 "spot": {"outerConeAngle": 0.5, "innerConeAngle": 0.1}},
                {"type": "directional", "intensity": 2, "range": 3.0},
                {"type": "point"},
            ]
        }
    }  # fmt: skip
    m.json["cameras"] = [
        {"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}},
    ]
    leaf = m.node(mesh=plain, translation=[0.5, 0, 0], rotation=[0, 0.6, 0, 0.8], scale=[1, 2, 1])
    eye = m.node(camera=0, name="eye", translation=[0, 0, 5])
    m.node(name="root", children=[leaf, eye])
    lit = {"KHR_lights_punctual": {"light": 0}}
    m.node(mesh=plain, extensions=lit, matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -2, 0, 0, 1])
    m.node(mesh=clear, translation=[0, 0, 1], extensions={"KHR_lights_punctual": {"light": 1}})
    m.node(mesh=lamp, translation=[0, 2, 0], extensions={"KHR_lights_punctual": {"light": 2}})
    m.node(camera=1, translation=[0, 0, 7])
    m.node(name="empty")
    m.json["scenes"] = [{"nodes": [2, 3, 4, 5, 6, 7]}]
    m.json["animations"] = [{}]
    return m
