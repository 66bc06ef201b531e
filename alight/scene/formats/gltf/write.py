"""Scenes -> .glb files, as far as glTF can hold them; the rest is listed.

Meshes, their places, the camera, point, spot and directional lights, and materials that are
`principled` or `diffuse`, with bitmaps and their factors. Shapes that are formulas become meshes.
What glTF has no word for (environments, other materials) is named in the list that comes back.
"""

from __future__ import annotations

import io
import json
import math
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.spec import Bsdf, Light, Texture
from alight.outputs.atomic import replacing
from alight.scene.flatten import FlatScene, PlacedShape, at_opening
from alight.scene.formats.gltf.tessellate import EXACT, flipped, tessellated
from alight.scene.formats.triangles import MeshArrays
from alight.textures.bitmap import Bitmap
from alight.textures.multiply import Multiply
from alight.textures.vertex_color import VertexColor

Json = dict[str, Any]
WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}
_TURNED = np.diag([1.0, -1.0, -1.0, 1.0])


def write(flat: FlatScene, path: Path) -> list[str]:
    """Write a scene.

    Parameters
    ----------
    flat : FlatScene
    path : Path
        Ends in ``.glb``.

    Returns
    -------
    list of str
        What the file does not hold, or not quite, a line each.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    writer = _Writer(at_opening(flat))
    if any(placed.motion for placed in (*flat.shapes, *flat.lights, flat.camera)):
        writer.lose("what moves: it stands where it is when the shutter opens")
    writer.add_all()
    with replacing(path) as beside:
        beside.write_bytes(writer.bytes())
    return list(writer.lost)


@dataclass
class _Writer:
    flat: FlatScene
    json: Json = field(default_factory=lambda: {"asset": {"version": "2.0", "generator": "alight"}})
    data: bytearray = field(default_factory=bytearray)
    lost: dict[str, None] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    _meshes: dict[Any, int] = field(default_factory=dict)
    _materials: dict[Any, int] = field(default_factory=dict)
    _attributes: dict[Any, Json] = field(default_factory=dict)
    _textures: dict[Any, int] = field(default_factory=dict)

    def add_all(self) -> None:
        for shape in self.flat.shapes:
            self.add_shape(shape)
        for placed in self.flat.lights:
            self.add_light(placed.light, placed.to_world)
        if self.flat.environments:
            self.lose("the environment: glTF has no light from infinity around a scene")
        if self.flat.media:
            self.lose("media: glTF has nothing between surfaces")
        self.add_camera()

    def lose(self, text: str) -> None:
        self.lost[text] = None

    def put(self, key: str, value: Json) -> int:
        table = self.json.setdefault(key, [])
        table.append(value)
        return len(table) - 1

    def node(self, matrix: np.ndarray, **content: Any) -> None:
        self.put("nodes", {"matrix": matrix.T.ravel().tolist(), **content})

    def view(self, data: bytes) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += data
        return self.put("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def accessor(self, table: np.ndarray, component: int, kind: str) -> int:
        item: Json = {
            "bufferView": self.view(np.ascontiguousarray(table).tobytes()),
            "componentType": component, "count": len(table), "type": kind,
        }  # fmt: skip
        if kind == "VEC3":
            item |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self.put("accessors", item)

    def add_shape(self, shape: PlacedShape) -> None:
        kind, to_world = shape.shape.type_name(), shape.to_world
        if shape.geometry >= 0:
            found = self.flat.geometries[shape.geometry]
        else:
            made = tessellated(shape.shape)
            if made is None:
                self.lose(f"{shape.name}: a {kind} is no mesh")
                return
            found, placed = made
            to_world = to_world @ placed
            if kind not in EXACT:
                self.lose(f"{kind}s: became meshes of {len(found.faces)} triangles")
        flip = shape.shape.flip_normals
        surface = (shape.bsdf, None if shape.light is None else id(shape.light))
        source = (kind, shape.geometry, flip)
        if (*source, *surface) not in self._meshes:
            if source not in self._attributes:
                arrays = MeshArrays(*(getattr(found, name) for name in MeshArrays._fields))
                self._attributes[source] = self.attributes(flipped(arrays) if flip else arrays)
            primitive = {**self._attributes[source], "material": self.material(shape, surface)}
            self._meshes[(*source, *surface)] = self.put("meshes", {"primitives": [primitive]})
        self.node(to_world, mesh=self._meshes[(*source, *surface)], name=shape.name)

    def attributes(self, geometry: MeshArrays) -> Json:
        found: Json = {"POSITION": self.accessor(geometry.vertices, 5126, "VEC3")}
        if geometry.normals is not None:
            found["NORMAL"] = self.accessor(geometry.normals, 5126, "VEC3")
        if geometry.uvs is not None:
            turned = geometry.uvs * np.float32([1, -1]) + np.float32([0, 1])
            found["TEXCOORD_0"] = self.accessor(turned.astype(np.float32), 5126, "VEC2")
        if geometry.colors is not None:
            found["COLOR_0"] = self.accessor(geometry.colors, 5126, "VEC3")
        indices = geometry.faces.astype(np.uint32).ravel()
        return {"attributes": found, "indices": self.accessor(indices, 5125, "SCALAR")}

    def material(self, shape: PlacedShape, key: Any) -> int:
        if key not in self._materials:
            made = self.surface(self.flat.bsdfs[shape.bsdf])
            if shape.light is not None:
                self.emit(shape.light, made)
            self._materials[key] = self.put("materials", made)
        return self._materials[key]

    def surface(self, bsdf: Bsdf) -> Json:
        """The words of a material."""
        made: Json = {}
        fields = dict(bsdf)
        while "bsdf" in fields:
            kind = bsdf.type_name()
            if kind == "two_sided":
                made["doubleSided"] = True
            elif kind == "mask" and isinstance(fields["opacity"], float):
                made["alphaMode"] = "BLEND"
                made["opacity"] = fields["opacity"]
            elif kind == "normal_map" and isinstance(fields["texture"], Bitmap):
                info = self.texture(fields["texture"])
                made["normalTexture"] = {**info, "scale": fields["scale"]}
            else:
                self.lose(f"{kind}: what it does to a material")
            bsdf = fields["bsdf"]
            fields = dict(bsdf)
        kind = bsdf.type_name()
        opacity = made.pop("opacity", 1.0)
        if kind == "principled":
            pbr = self.colored(fields["base_color"], opacity)
            pbr["metallicFactor"] = self.number(fields, "metallic")
            pbr["roughnessFactor"] = self.number(fields, "roughness")
            self.extend(fields, made)
        elif kind == "diffuse":
            pbr = {**self.colored(fields["reflectance"], opacity), "metallicFactor": 0.0}
            self.extension(made, "KHR_materials_specular", {"specularFactor": 0.0})
        else:
            self.lose(f"{kind}: became a grey surface")
            pbr = self.colored((0.5, 0.5, 0.5), opacity)
        return {**made, "pbrMetallicRoughness": pbr}

    def extend(self, fields: Json, made: Json) -> None:
        """Extensions for what is not at its default."""
        if fields["ior"] != 1.5:
            self.extension(made, "KHR_materials_ior", {"ior": fields["ior"]})
        specular: Json = {}
        if fields["specular"] != 1.0:
            specular["specularFactor"] = self.number(fields, "specular")
        if fields["specular_color"] != (1.0, 1.0, 1.0):
            specular["specularColorFactor"] = list(self.mean(fields, "specular_color"))
        if specular:
            self.extension(made, "KHR_materials_specular", specular)
        if fields["transmission"] != 0.0:
            share = {"transmissionFactor": self.number(fields, "transmission")}
            self.extension(made, "KHR_materials_transmission", share)
            if not fields["thin"]:
                volume: Json = {"thicknessFactor": 1.0}
                volume["attenuationColor"] = list(self.mean(fields, "attenuation_color"))
                if math.isfinite(fields["attenuation_distance"]):
                    volume["attenuationDistance"] = fields["attenuation_distance"]
                self.extension(made, "KHR_materials_volume", volume)
        if fields["clearcoat"] != 0.0:
            coat = {
                "clearcoatFactor": self.number(fields, "clearcoat"),
                "clearcoatRoughnessFactor": self.number(fields, "clearcoat_roughness"),
            }
            self.extension(made, "KHR_materials_clearcoat", coat)
        if fields["sheen_color"] != (0.0, 0.0, 0.0):
            sheen = {
                "sheenColorFactor": list(self.mean(fields, "sheen_color")),
                "sheenRoughnessFactor": self.number(fields, "sheen_roughness"),
            }
            self.extension(made, "KHR_materials_sheen", sheen)
        for name in ("anisotropy", "iridescence"):
            if fields[name] != 0.0:
                self.lose(f"principled: its {name}")

    def extension(self, owner: Json, name: str, content: Json) -> None:
        self.used.add(name)
        owner.setdefault("extensions", {})[name] = content

    def number(self, fields: Json, name: str) -> float:
        value = fields[name]
        return float(value) if isinstance(value, float | int) else self.mean(fields, name)[1]

    def mean(self, fields: Json, name: str) -> tuple[float, ...]:
        value = fields[name]
        if isinstance(value, tuple):
            return value
        self.lose(f"{name}: its texture became the mean")
        return value.mean()

    def colored(self, value: Any, opacity: float) -> Json:
        """Base colour: a colour, a bitmap, or the product of both."""
        factor, picture = (1.0, 1.0, 1.0), value
        if isinstance(value, tuple):
            factor, picture = value, None
        elif isinstance(value, Multiply):
            for one, other in ((value.a, value.b), (value.b, value.a)):
                if isinstance(one, tuple):
                    factor, picture = one, other
        if isinstance(picture, VertexColor):
            picture = None
        made: Json = {}
        if isinstance(picture, Bitmap):
            made["baseColorTexture"] = self.texture(picture)
        elif isinstance(picture, Texture):
            self.lose(f"{picture.type_name()} texture: became its mean colour")
            factor = tuple(a * b for a, b in zip(factor, picture.mean(), strict=True))
        return {**made, "baseColorFactor": [*(min(c, 1.0) for c in factor), opacity]}

    def texture(self, spec: Bitmap) -> Json:
        """The texture info of a bitmap, which becomes a PNG picture of 8 bits."""
        from PIL import Image

        key = (spec.pixels, spec.wrap, spec.wrap_v, spec.interpolation)
        if key not in self._textures:
            assert spec.pixels is not None
            texels = spec.pixels.whole
            if texels.dtype != np.uint8:
                self.lose("pictures of 16 bits and floats: became 8 bits")
                texels = np.clip(np.rint(texels / spec.pixels.levels * 255.0), 0, 255)
            texels = np.broadcast_to(texels, (*texels.shape[:2], max(3, texels.shape[2])))
            file = io.BytesIO()
            Image.fromarray(np.ascontiguousarray(texels, np.uint8)).save(file, "PNG")
            image = {"bufferView": self.view(file.getvalue()), "mimeType": "image/png"}
            sampler = {
                "wrapS": WRAPS[spec.wrap], "wrapT": WRAPS[spec.wrap_v or spec.wrap],
                "magFilter": 9728 if spec.interpolation == "nearest" else 9729,
            }  # fmt: skip
            self._textures[key] = self.put(
                "textures",
                {"source": self.put("images", image), "sampler": self.put("samplers", sampler)},
            )
        if (spec.to_uv.matrix != np.eye(3)[:2]).any():
            self.lose("to_uv: places of pictures on surfaces")
        return {"index": self._textures[key]}

    def emit(self, light: Light, made: Json) -> None:
        radiance = dict(light).get("radiance", (0.0, 0.0, 0.0))
        color = radiance if isinstance(radiance, tuple) else self.mean(dict(light), "radiance")
        strength = max(*color, 1.0)
        made["emissiveFactor"] = [c / strength for c in color]
        if strength > 1.0:
            content = {"emissiveStrength": strength}
            self.extension(made, "KHR_materials_emissive_strength", content)

    def add_light(self, light: Light, to_world: np.ndarray) -> None:
        kind = light.type_name()
        if kind not in ("point", "spot", "directional"):
            self.lose(f"{kind} light: glTF has no word for it")
            return
        fields = dict(light)
        color = fields["irradiance" if kind == "directional" else "intensity"]
        strength = max(*color, 1e-30)
        item: Json = {"type": kind, "color": [c / strength for c in color], "intensity": strength}
        if kind == "spot":
            if fields["falloff"] != "quadratic":
                self.lose(f"a spot's {fields['falloff']} falloff: glTF's is quadratic")
            beam = fields["beam_width"]
            beam = 0.75 * fields["cutoff_angle"] if beam is None else beam
            outer = min(math.radians(fields["cutoff_angle"]), math.pi / 2.0)
            item["spot"] = {
                "outerConeAngle": outer, "innerConeAngle": min(math.radians(beam), outer),
            }  # fmt: skip
        name = "KHR_lights_punctual"
        self.used.add(name)
        table = self.json.setdefault("extensions", {}).setdefault(name, {"lights": []})["lights"]
        table.append(item)
        number = {name: {"light": len(table) - 1}}
        self.node(to_world @ _TURNED, extensions=number)

    def add_camera(self) -> None:
        placed, (width, height) = self.flat.camera, self.flat.film.size
        kind, fields = placed.camera.type_name(), dict(placed.camera)
        if kind == "orthographic":
            half = 0.5 * fields["height"]
            lens = {"ymag": half, "xmag": half * width / height, "znear": 0.0, "zfar": 1e6}
            camera: Json = {"type": kind, "orthographic": lens}
        elif "fov" in fields:
            from alight.cameras.basis import perspective_half_extents

            _, up = perspective_half_extents(fields["fov"], fields["fov_axis"], width, height)
            lens = {"yfov": 2.0 * math.atan(up), "aspectRatio": width / height, "znear": 1e-3}
            camera = {"type": "perspective", "perspective": lens}
            if kind != "pinhole":
                self.lose(f"{kind} camera: its lens")
        else:
            self.lose(f"{kind} camera: glTF has no word for it")
            return
        self.node(placed.to_world, camera=self.put("cameras", camera))

    def bytes(self) -> bytes:
        """The file."""
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["buffers"] = [{"byteLength": max(len(self.data), 4)}]
        self.json["scenes"] = [{"nodes": list(range(len(self.json.get("nodes", []))))}]
        if self.used:
            self.json["extensionsUsed"] = sorted(self.used)
        data = bytes(self.data) or b"\0" * 4
        text = json.dumps(self.json, allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
        json_chunk = struct.pack("<II", len(text), 0x4E4F534A) + text
        return head + json_chunk + struct.pack("<II", len(data), 0x004E4942) + data
