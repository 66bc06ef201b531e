"""Scenes -> .glb files, as far as glTF can hold them; the rest is listed.

Meshes with all their texture coordinates, their places, the camera, point, spot and directional
lights, and materials: `principled` and `diffuse` as they are, others as the nearest `principled`,
with pictures. Shapes that are formulas become meshes. What glTF has no word for (environments,
noise) is named in the list that comes back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.fields import LARGEST
from alight.core.spec import Light
from alight.formats.gltf.places import fits_node, is_skewed, unscaled, unskewed
from alight.formats.gltf.store import Json, Store
from alight.formats.gltf.tessellate import EXACT, flipped, tessellated
from alight.formats.gltf.write_materials import MaterialWriter
from alight.formats.gltf.write_meshes import moved, with_coordinates, with_unit_normals
from alight.meshes.triangles import MeshArrays
from alight.outputs.atomic import replacing
from alight.scene.flatten import FlatScene, PlacedShape
from alight.scene.opening import at_opening
from alight.shapes.arrays import is_displaced

_TURNED = np.diag([1.0, -1.0, -1.0, 1.0])
_MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
#: Radians: the file's spots shine into half of space at most, and must fade.
_WIDEST, _NARROWEST = math.pi / 2.0, 1e-6


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
    writer = _Writer(flat=at_opening(flat))
    if any(placed.motion for placed in (*flat.shapes, *flat.lights, flat.camera)):
        writer.lose("what moves: it stands where it is when the shutter opens")
    writer.add_all()
    data = writer.bytes()
    with replacing(path) as beside:
        beside.write_bytes(data)
    return list(writer.lost)


@dataclass
class _Writer(Store):
    flat: FlatScene = field(kw_only=True)
    _meshes: dict[Any, int] = field(default_factory=dict)
    _materials: dict[Any, tuple[int, frozenset[int], bool]] = field(default_factory=dict)
    _attributes: dict[Any, Json] = field(default_factory=dict)
    _writer: MaterialWriter = field(init=False)
    # What is done to the world: cameras cannot mirror.
    _world: np.ndarray = field(default_factory=lambda: np.eye(4))

    def __post_init__(self) -> None:
        mirrored = bool(np.linalg.det(self.flat.camera.to_world[:3, :3]) < 0.0)
        if mirrored:
            self._world = _MIRROR
            self.lose("a camera that mirrors: the whole scene is mirrored instead (x became -x)")
        self._writer = MaterialWriter(self, mirrored)

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

    def node(self, matrix: np.ndarray, **content: Any) -> None:
        # Products of what is allowed may be too large by their rounding.
        held = np.clip(matrix, -LARGEST, LARGEST)
        self.put("nodes", {"matrix": held.T.ravel().tolist(), **content})

    def add_shape(self, shape: PlacedShape) -> None:
        kind, to_world = shape.shape.type_name(), shape.to_world
        if is_displaced(shape.shape):
            self.lose(f"{shape.name}: its displacement")
        if shape.geometry >= 0:
            found = self.flat.geometries[shape.geometry]
        else:
            made = tessellated(shape.shape)
            if made is None:
                self.lose(f"{shape.name}: a {kind} is not a mesh")
                return
            found, placed = made
            to_world = to_world @ placed
            if kind not in EXACT:
                self.lose(f"{kind}s: became meshes of {len(found.faces)} triangles")
        flip = shape.shape.flip_normals
        arrays = MeshArrays(*(getattr(found, name) for name in MeshArrays._fields))
        has_colors = arrays.colors is not None
        surface = (shape.bsdf, None if shape.light is None else id(shape.light), has_colors)
        material = self.material(shape, surface, has_colors)
        has_to_be_mapped = bool(material[1]) and arrays.uvs is None
        to_world, first = self._world @ to_world, None
        if not fits_node(to_world):
            to_world, first = unskewed(to_world)
        shear = None if first is None else first.tobytes()
        source = (kind, shape.geometry, flip, has_to_be_mapped, shear)
        if (*source, *surface) not in self._meshes:
            if source not in self._attributes:
                arrays = with_coordinates(arrays) if has_to_be_mapped else arrays
                arrays = flipped(arrays) if flip else arrays
                arrays = arrays if first is None else moved(arrays, first)
                self._attributes[source] = self.attributes(with_unit_normals(arrays))
            primitive = self.primitive(self._attributes[source], material)
            self._meshes[(*source, *surface)] = self.put("meshes", {"primitives": [primitive]})
        self.node(to_world, mesh=self._meshes[(*source, *surface)], name=shape.name)

    def primitive(self, arrays: Json, material: tuple[int, frozenset[int], bool]) -> Json:
        """Arrays with a material, which must have what it asks for, and no colours but then."""
        number, sets, has_colors = material
        attributes = dict(arrays["attributes"])
        if not has_colors:
            attributes.pop("COLOR_0", None)
        # Where a mesh lacks a set, its own is taken; numbers must not be left out.
        for wanted in range(max(sets, default=-1) + 1):
            attributes.setdefault(f"TEXCOORD_{wanted}", attributes["TEXCOORD_0"])
        return {**arrays, "attributes": attributes, "material": number}

    def attributes(self, geometry: MeshArrays) -> Json:
        found: Json = {"POSITION": self.accessor(geometry.vertices, 5126, "VEC3")}
        if geometry.normals is not None:
            found["NORMAL"] = self.accessor(geometry.normals, 5126, "VEC3")
        more = () if geometry.more_uvs is None else geometry.more_uvs
        for number, uvs in enumerate(() if geometry.uvs is None else (geometry.uvs, *more)):
            turned = uvs * np.float32([1, -1]) + np.float32([0, 1])
            table = self.accessor(turned.astype(np.float32), 5126, "VEC2")
            found[f"TEXCOORD_{number}"] = table
        if geometry.colors is not None:
            found["COLOR_0"] = self.accessor(geometry.colors, 5126, "VEC3")
        indices = geometry.faces.astype(np.uint32).ravel()
        return {"attributes": found, "indices": self.accessor(indices, 5125, "SCALAR")}

    def material(
        self, shape: PlacedShape, key: Any, has_colors: bool
    ) -> tuple[int, frozenset[int], bool]:
        if key not in self._materials:
            bsdf = self.flat.bsdfs[shape.bsdf]
            self._materials[key] = self._writer.material(bsdf, shape.light, has_colors)
        return self._materials[key]

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
            if fields["cutoff_angle"] > 90.0:
                self.lose("a spot's cutoff_angle: became 90 degrees, the most that glTF has")
            outer = min(math.radians(fields["cutoff_angle"]), _WIDEST)
            inner = max(0.0, min(math.radians(beam), outer - _NARROWEST))
            item["spot"] = {"outerConeAngle": outer, "innerConeAngle": inner}
        name = "KHR_lights_punctual"
        self.used.add(name)
        table = self.json.setdefault("extensions", {}).setdefault(name, {"lights": []})["lights"]
        table.append(item)
        number = {name: {"light": len(table) - 1}}
        self.node(unscaled(self._world @ to_world) @ _TURNED, extensions=number)

    def add_camera(self) -> None:
        placed, (width, height) = self.flat.camera, self.flat.film.size
        kind, fields = placed.camera.type_name(), dict(placed.camera)
        to_world = self._world @ placed.to_world
        right, up, back = np.linalg.norm(to_world[:3, :3], axis=0).tolist()
        if kind == "orthographic":
            half = 0.5 * fields["height"] * up
            aspect = width / height * right / up
            lens = {"ymag": half, "xmag": half * aspect, "znear": 0.0, "zfar": 1e6}
            camera: Json = {"type": kind, "orthographic": lens}
        elif "fov" in fields:
            from alight.cameras.basis import perspective_half_extents

            x, y = perspective_half_extents(fields["fov"], fields["fov_axis"], width, height)
            yfov, aspect = 2.0 * math.atan(y * up / back), x * right / (y * up)
            lens = {"yfov": yfov, "aspectRatio": aspect, "znear": 1e-3}
            camera = {"type": "perspective", "perspective": lens}
            if kind != "pinhole":
                self.lose(f"{kind} camera: its lens")
        else:
            self.lose(f"{kind} camera: glTF has no word for it")
            return
        if is_skewed(to_world):
            self.lose("camera: the shear of its picture")
        if self.flat.film.crop is not None:
            self.lose("film: the crop of its picture")
        self.node(unscaled(to_world), camera=self.put("cameras", camera))
