"""The hierarchy of nodes, with meshes, cameras and lights, as nodes of the native format.

Meshes at several places become prototypes. Nodes below which nothing can be seen are left out.
Where a hierarchy is deeper than the native format allows, the transforms of the deepest nodes are
multiplied together.

Source: Khronos Group, glTF 2.0 specification, sections 3.5 and 3.10; KHR_lights_punctual.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.errors import SceneError
from alight.formats.geometry.skinning import Matrices
from alight.formats.gltf.bodies import have_insides
from alight.formats.gltf.container import Document
from alight.formats.gltf.instances import NAME, add_bounds, instance_matrices, rotations
from alight.formats.gltf.materials import Materials
from alight.formats.gltf.meshes import morph_weights, read_primitive
from alight.formats.gltf.places import unscaled
from alight.formats.gltf.skins import joint_matrices
from alight.formats.gltf.textures import Data
from alight.formats.gltf.values import Item
from alight.formats.materials.surfaces import Surface
from alight.formats.reading.names import free_name
from alight.formats.scenes.cameras import Parallel, Perspective
from alight.formats.scenes.lamps import parallel, point, spot, turned
from alight.formats.scenes.model_scene import ModelScene
from alight.formats.scenes.surroundings import SIZE
from alight.scene.transform import Matrix, is_singular

#: Nodes this deep carry all that is below them; the native format ends at 24.
DEEPEST = 16
#: Radians, least and most, that a picture can span.
_ANGLES = 1e-12, math.radians(179.9999)
#: A mesh, the weights of its morph targets, and the place of what has a skin.
_Variant = tuple[int, tuple[float, ...], str]


@dataclass
class _Open:
    """A node that is still to be visited."""

    index: int
    siblings: dict[str, Data]
    path: str
    keys: str
    to_world: Matrix
    level: int
    # What the parents that are no nodes of ours do, or None.
    before: Matrix | None = None


class Graph(ModelScene):
    """Nodes in the making.

    Parameters
    ----------
    document : Document
    materials : Materials
    """

    def __init__(self, document: Document, materials: Materials) -> None:
        super().__init__(document.report, document.reach, {"": document.root.name})
        self.document, self.materials = document, materials
        self._order: list[int] = []
        self._worlds: dict[int, Matrix] = {}
        self._uses: dict[int, int] = {}
        self._meshes: dict[_Variant, dict[str, Data]] = {}
        self._prototype_names: dict[_Variant, str] = {}
        self._surfaces: dict[int, Surface] = {}

    def build(self) -> None:
        """Visit all nodes of the scene that the file shows."""
        roots = self._roots()
        order = self._order = self._check_tree(roots)
        for index in order:
            mesh = self.document.list("nodes")[index].value.get("mesh")
            if isinstance(mesh, int):
                self._uses[mesh] = self._uses.get(mesh, 0) + 1
        visible = self._visible(order)
        stack = [_Open(i, self.nodes, "", "nodes", np.eye(4), 0) for i in reversed(roots)]
        while stack:
            task = stack.pop()
            if task.index in visible:
                stack += reversed(self._visit(task))

    def _roots(self) -> list[int]:
        document = self.document
        count, scenes = len(document.list("nodes")), document.list("scenes")
        if scenes:
            index = document.root.index("scene", len(scenes), "scenes") or 0
            return scenes[index].indices("nodes", count, "nodes")
        nodes = document.list("nodes")
        children = {child for node in nodes for child in node.indices("children", count, "nodes")}
        return [i for i in range(count) if i not in children]

    def _check_tree(self, roots: list[int]) -> list[int]:
        """All nodes below some, parents first; a node must not come twice."""
        nodes, order = self.document.list("nodes"), []
        seen = set()
        stack = list(reversed(roots))
        while stack:
            index = stack.pop()
            if index in seen:
                raise nodes[index].fatal("", "stands below two nodes, or below itself")
            seen.add(index)
            order.append(index)
            stack += reversed(nodes[index].indices("children", len(nodes), "nodes"))
        return order

    def _visible(self, order: list[int]) -> set[int]:
        """Nodes at or below which there is something to show."""
        nodes, found = self.document.list("nodes"), set()
        for index in reversed(order):
            children = nodes[index].indices("children", len(nodes), "nodes")
            if self._shows(nodes[index]) or any(child in found for child in children):
                found.add(index)
        return found

    def _shows(self, node: Item) -> bool:
        return bool({"mesh", "camera"} & set(node.value)) or self._light_of(node) is not None

    def _visit(self, task: _Open) -> list[_Open]:
        item = self.document.list("nodes")[task.index]
        steps, matrix = placement(item)
        to_world = task.to_world @ matrix
        own = matrix if task.before is None else task.before @ matrix
        if is_singular(own) or is_singular(to_world):
            self._flattened(task.index)
            return []
        name = free_name(item.text("name"), task.siblings, f"node {task.index}")
        keys = f"{task.keys}.{name}"
        path = f"{task.path}/{name}" if task.path else name
        self.places[keys] = f"{item.name}#{item.pointer}"
        data: Data = {}
        if task.before is not None:
            data["transform"] = {"matrix": own.tolist()}
        elif steps:
            data["transform"] = steps
        task.siblings[name] = data
        children: dict[str, Data] = {}
        data["children"] = children
        self._add_mesh(item, data, children, keys, to_world)
        self._add_light(item, children)
        camera = item.index("camera", len(self.document.list("cameras")), "cameras")
        if camera is not None:
            lens = self._camera(self.document.list("cameras")[camera])
            view = unscaled(to_world)
            # Where it stands does not count: far away it would hide a scale.
            if np.allclose(view[:3, :3], to_world[:3, :3], rtol=0.0, atol=1e-5):
                data["camera"] = lens
            else:
                # Below the node, by the same name, without its scale.
                back = np.linalg.inv(to_world) @ view
                child = free_name(name, children, name)
                children[child] = {"camera": lens, "transform": {"matrix": back.tolist()}}
                path, where = f"{path}/{child}", f"{keys}.children.{child}"
                self.places[where] = f"{item.name}#{item.pointer}"
            self.add_camera(path, self._aspect(self.document.list("cameras")[camera]), view)
        indices = item.indices("children", len(self.document.list("nodes")), "nodes")
        if task.level < DEEPEST:
            where = f"{keys}.children"
            return [_Open(i, children, path, where, to_world, task.level + 1) for i in indices]
        # Beside this node, with its transform multiplied in.
        return [
            _Open(i, task.siblings, task.path, task.keys, to_world, task.level, own)
            for i in indices
        ]

    def _flattened(self, index: int) -> None:
        """Show of a node without size what has a skin: it stands where its joints are."""
        nodes = self.document.list("nodes")
        below = self._check_tree([index])
        shown = [nodes[i] for i in below if self._shows(nodes[i])]
        held = [item for item in shown if item.has("mesh") and item.has("skin")]
        for item in held:
            name = free_name(item.text("name"), self.nodes, "skinned")
            keys, children = f"nodes.{name}", {}
            self.places[keys] = f"{item.name}#{item.pointer}"
            self.nodes[name] = data = {"children": children}
            self._add_mesh(item, data, children, keys, np.eye(4))
        if held != shown or not held:
            pointer = nodes[index].pointer
            self.document.report.drop(f"{pointer}: its transform flattens it to nothing")

    def _add_mesh(
        self, item: Item, data: Data, children: dict[str, Data], keys: str, to_world: Matrix
    ) -> None:
        meshes = self.document.list("meshes")
        index = item.index("mesh", len(meshes), "meshes")
        if index is None:
            return
        mesh = meshes[index]
        skin = item.index("skin", len(self.document.list("skins")), "skins")
        weights = morph_weights(item, mesh)
        # What a skin holds has a shape of its own at each place.
        place = item.pointer if skin is not None else ""
        variant = (index, tuple(weights), place)
        if variant not in self._meshes:
            joints = None if skin is None else self._joints(skin, to_world)
            self._meshes[variant] = self._primitives(mesh, weights, joints)
        parts = self._meshes[variant]
        if not parts:
            return
        moves = instance_matrices(self.document, item) if skin is None else None
        if moves is not None:
            self._add_instances(parts, moves, self._prototype(variant, mesh), children, to_world)
            return
        for part in parts.values():
            self.bounds.add(part["shape"].vertices, to_world)
            self.shine(part["shape"], self._surfaces[id(part["shape"])], to_world)
        if self._uses.get(index, 0) > 1 and skin is None:
            data["instance"] = self._prototype(variant, mesh)
        elif len(parts) == 1:
            data.update(next(iter(parts.values())))
        else:
            children.update(parts)

    def _prototype(self, variant: _Variant, mesh: Item) -> str:
        """The name of what instances of a mesh stand for."""
        if variant not in self._prototype_names:
            name = free_name(mesh.text("name"), self.prototypes, f"mesh {variant[0]}")
            self._prototype_names[variant] = name
            self.prototypes[name] = {"children": self._meshes[variant]}
            self.places[f"prototypes.{name}"] = f"{mesh.name}#{mesh.pointer}"
        return self._prototype_names[variant]

    def _add_instances(
        self,
        parts: dict[str, Data],
        moves: Matrices,
        prototype: str,
        children: dict[str, Data],
        to_world: Matrix,
    ) -> None:
        flat = np.array([is_singular(to_world @ move) for move in moves], bool)
        if flat.any():
            self.report.drop(f"{NAME}: {flat.sum()} instances are flattened to nothing")
        for number in np.flatnonzero(~flat):
            place = {"matrix": moves[number].tolist()}
            children[f"instance {number}"] = {"instance": prototype, "transform": place}
        for part in parts.values():
            shape = part["shape"]
            add_bounds(self.bounds, shape.vertices, moves[~flat], to_world)
            surface = self._surfaces[id(shape)]
            for move in moves[~flat] if surface.emission is not None else ():
                self.shine(shape, surface, to_world @ move)

    def _joints(self, index: int, to_world: Matrix) -> Matrix:
        """The matrices of a skin's joints, as the nodes stand."""
        if not self._worlds:
            nodes = self.document.list("nodes")
            for node in self._order:
                world = self._worlds.get(node, np.eye(4)) @ placement(nodes[node])[1]
                self._worlds[node] = world
                for child in nodes[node].indices("children", len(nodes), "nodes"):
                    self._worlds[child] = world
        return joint_matrices(
            self.document, self.document.list("skins")[index], self._worlds, to_world
        )

    def _primitives(
        self, mesh: Item, weights: list[float], joints: Matrix | None
    ) -> dict[str, Data]:
        """The parts of a mesh, each with its material."""
        found: list[tuple[Any, Surface, Item]] = []
        asked: list[tuple[int | None, int]] = []
        parts: dict[str, Data] = {}
        self.document.report.count("meshes")
        for number, primitive in enumerate(mesh.objects("primitives")):
            count = len(self.document.list("materials"))
            index = primitive.index("material", count, "materials")
            attributes = primitive.object("attributes")
            channels = self.materials.channels(index, attributes)
            material = self.materials.get(index, channels)
            if self.document.report.issues:
                raise SceneError(self.document.report.issues)
            shape = read_primitive(self.document, primitive, weights, material.sets, joints)
            if shape is None:
                continue
            self._surfaces[id(shape)] = material
            found.append((shape, material, primitive))
            parts[f"primitive {number}"] = {"shape": shape}
            asked.append((index, channels))
        for part, (_, material, _), (index, channels), closed in zip(
            parts.values(), found, asked, have_insides(found), strict=True
        ):
            part |= {"bsdf": self._bsdf(index, channels, closed), **material.light}
        return parts

    def _bsdf(self, index: int | None, channels: int, closed: bool) -> str:
        """The name of a material, which is entered at its first use."""
        key, surface = (index, channels, closed), self.materials.get(index, channels).on(closed)
        if index is None or self.has_named(key):
            return self.name_of(key, surface, "default material")
        self.report.count("materials")
        item = self.document.list("materials")[index]
        wanted = item.text("name") or f"material {index}"
        return self.name_of(key, surface, wanted, f"{item.name}#{item.pointer}")

    def _light_of(self, item: Item) -> Item | None:
        extension = item.extension("KHR_lights_punctual")
        table = self.document.root.extension("KHR_lights_punctual")
        if extension is None or table is None:
            return None
        lights = table.objects("lights")
        index = extension.index("light", len(lights), "lights")
        return None if index is None else lights[index]

    def _add_light(self, item: Item, children: dict[str, Data]) -> None:
        light = self._light_of(item)
        if light is None:
            return
        name = free_name(light.text("name"), children, "light")
        children[name] = punctual(light)
        self.document.report.count("lights")
        self.is_lit = True

    def _camera(self, item: Item) -> Data:
        """The camera that an object describes."""
        self.document.report.count("cameras")
        kind = item.text("type", "perspective", ("perspective", "orthographic"))
        lens = item.object(kind)
        if lens is None:
            raise item.fatal(kind, "is missing")
        if kind == "orthographic":
            return Parallel(2.0 * lens.number("ymag", 1.0, 1e-9)).data()
        fov = lens.number("yfov", math.radians(45.0), *_ANGLES)
        return Perspective(math.degrees(fov)).data()

    def _aspect(self, item: Item) -> float:
        """The shape of a camera's picture, width by height; only that of the first one counts."""
        perspective = item.object("perspective")
        orthographic = item.object("orthographic")
        aspect = SIZE[0] / SIZE[1]
        if self.cameras:
            return aspect
        if perspective is not None and perspective.has("aspectRatio"):
            return perspective.number("aspectRatio", aspect, 1e-3, 1e3)
        if orthographic is not None:
            height = orthographic.number("ymag", 1.0, 1e-9)
            return orthographic.number("xmag", height, 1e-9) / height
        return aspect


def placement(item: Item) -> tuple[Any, Matrix]:
    """Steps of a node's transform (empty for the identity), and their matrix."""
    if item.has("matrix"):
        numbers = item.numbers("matrix", tuple(np.eye(4).ravel().tolist()))
        matrix = np.array(numbers).reshape(4, 4).T
        if not np.array_equal(matrix[3], [0.0, 0.0, 0.0, 1.0]):
            item.wrong("matrix", "must be affine: its last row must be 0 0 0 1")
            return [], np.eye(4)
        return ({"matrix": matrix.tolist()} if (matrix != np.eye(4)).any() else []), matrix
    scale = item.numbers("scale", (1.0, 1.0, 1.0))
    turn = np.array(item.numbers("rotation", (0.0, 0.0, 0.0, 1.0)))
    shift = item.numbers("translation", (0.0, 0.0, 0.0))
    length = float(np.linalg.norm(turn))
    if not length > 1e-6:
        item.wrong("rotation", f"must be a unit quaternion, got length {length:g}")
        return [], np.eye(4)
    rotation = np.eye(4)
    rotation[:3, :3] = rotations((turn / length)[None])[0]
    matrix = rotation @ np.diag([*scale, 1.0])
    matrix[:3, 3] = shift
    steps: list[Data] = []
    if scale != (1.0, 1.0, 1.0):
        steps.append({"scale": list(scale)})
    if (rotation != np.eye(4)).any():
        steps.append({"matrix": rotation.tolist()})
    if shift != (0.0, 0.0, 0.0):
        steps.append({"translate": list(shift)})
    return steps, matrix


def punctual(light: Item) -> Data:
    """The node of a light: candela and lux are taken as W/sr and W/m^2, nits as W/(m^2 sr)."""
    kind = light.text("type", "point", ("point", "spot", "directional"))
    color = light.numbers("color", (1.0, 1.0, 1.0), 0.0)
    intensity = light.number("intensity", 1.0, 0.0)
    emitted = [intensity * c for c in color]
    if light.has("range"):
        light.report.drop("range: lights reach as far as light does")
    if kind == "point":
        return {"light": point(emitted)}
    if kind == "directional":
        return turned(parallel(emitted), "x")
    cone = light.object("spot") or Item({}, light.at("spot"), light.name, light.report)
    outer = cone.number("outerConeAngle", math.pi / 4.0, 1e-4, math.pi / 2.0)
    inner = cone.number("innerConeAngle", 0.0, 0.0, outer)
    cutoff = math.degrees(outer)
    return turned(spot(emitted, cutoff, min(math.degrees(inner), cutoff), "quadratic"), "x")
