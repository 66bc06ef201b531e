"""The tree of prims -> nodes, prototypes and materials of the native format."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import Any

import numpy as np

from alight.core.errors import SceneError
from alight.core.fields import LARGEST
from alight.formats.geometry.bounds import Bounds, corners
from alight.formats.materials.surfaces import Surface
from alight.formats.reading.names import free_name
from alight.formats.scenes.model_scene import Data, ModelScene
from alight.formats.usd.cameras import read_camera
from alight.formats.usd.curves import read_curves, with_mean_color
from alight.formats.usd.inherited import (
    children_of,
    constants_of,
    handed_down,
    shown_of,
    source_of,
)
from alight.formats.usd.lights import glow_of, is_light, read_light
from alight.formats.usd.materials import plain_material, read_material
from alight.formats.usd.meshes import arrays_of, read_mesh, say_what_is_lacking, solid
from alight.formats.usd.modules import UsdGeom, UsdLux, UsdShade, UsdSkel
from alight.formats.usd.placing import is_placement, say_what_is_inside
from alight.formats.usd.points import read_points
from alight.formats.usd.skins import Pose, poses_of
from alight.formats.usd.stage import Stage
from alight.formats.usd.textures import DEFAULT_COORDINATES
from alight.meshes.polygons import Triangles
from alight.meshes.volume import has_inside
from alight.scene.meshes import mesh_of
from alight.scene.steps import parse_transform
from alight.scene.transform import is_singular
from alight.shapes.mesh import Mesh

Matrix = np.ndarray
#: Schemas that say nothing about what is seen.
_SILENT = (
    "Scope", "Xform", "", "Material", "Shader", "NodeGraph", "GeomSubset", "RenderSettings",
    "SkelRoot", "Skeleton", "SkelAnimation", "BlendShape",
)  # fmt: skip
_HIDDEN = (UsdGeom.Tokens.guide, UsdGeom.Tokens.proxy)
_MOST_DEEP = 200
_SMALL = f"of at most {LARGEST:g} in size"


class Graph(ModelScene):
    """Builds the nodes of a stage.

    Parameters
    ----------
    stage : Stage
    root : (4, 4) float64
        From the stage's space to the world.
    """

    def __init__(self, stage: Stage, root: Matrix) -> None:
        super().__init__(stage.report, stage.reach, {"": stage.name})
        self.stage = stage
        self.root = root
        self._domes: list[Data] = []
        self._poses: dict[str, Pose] = {}
        self._balls: list[tuple[str, Matrix, float]] = []
        self._materials: dict[Hashable, tuple[str, Surface]] = {}
        self._prototype_names: dict[Hashable, str] = {}
        self._prototype_bounds: dict[str, Bounds] = {}

    def build(self, steps: list[Data]) -> None:
        """Convert everything below the root of the stage."""
        world: Data = {"children": self._children(self.stage.stage.GetPseudoRoot(), self.root, "")}
        if steps:
            world["transform"] = steps
            self.nodes["world"] = world
            self.cameras = [(f"world/{path}", aspect) for path, aspect in self.cameras]
        else:
            self.nodes.update(world["children"])
        for dome in self._domes:
            # They are in world space, not in that of their prims.
            self.nodes[free_name("dome", self.nodes, "dome")] = dome
        eye = [] if self.view is None else [self.view[:3, 3]]
        box = corners(self.bounds.low, self.bounds.high)
        say_what_is_inside(self.stage.report, self._balls, (box, eye))

    def _children(self, parent: Any, to_world: Matrix, path: str) -> dict[str, Data]:
        nodes: dict[str, Data] = {}
        if path.count("/") > _MOST_DEEP:
            self.stage.problem(parent, f"is more than {_MOST_DEEP} prims deep")
            raise SceneError(self.stage.report.issues)
        for prim in children_of(parent):
            name = free_name(prim.GetName(), nodes, "prim")
            node = self._node(prim, to_world, f"{path}/{name}" if path else name)
            if node:
                nodes[name] = node
        return nodes

    def _node(self, prim: Any, to_world: Matrix, path: str) -> Data | None:
        """The node of a prim, or None if nothing of it is seen."""
        if prim.IsA(UsdShade.Material) or prim.IsA(UsdGeom.Subset):
            return None
        data: Data = {}
        if prim.IsA(UsdGeom.Imageable):
            imageable = UsdGeom.Imageable(prim)
            if imageable.ComputeVisibility(self.stage.time) == UsdGeom.Tokens.invisible:
                self.stage.report.drop(f"{prim.GetPath()}: invisible")
                return None
            if imageable.ComputePurpose() in _HIDDEN:
                self.stage.report.drop(f"{prim.GetPath()}: {imageable.ComputePurpose()} geometry")
                return None
        mode = self.stage.value(prim.GetAttribute("model:drawMode"), "default")
        if mode not in ("default", "inherited"):
            self.stage.report.approximate("model:drawMode: models are shown as they are")
        local = np.eye(4)
        if prim.IsA(UsdGeom.Xformable):
            local = self._local(prim, to_world)
        to_world = to_world @ local
        if not np.abs(to_world).max() <= LARGEST:
            self.stage.problem(prim, f"stands where the world needs numbers not {_SMALL}")
            return None
        if (local != np.eye(4)).any():
            data["transform"] = {"matrix": local.tolist()}
        if prim.IsA(UsdSkel.Root):
            self._poses |= poses_of(self.stage, prim)
        own = self._own(prim, to_world, path)
        if prim.IsInstance() and not own:
            data["instance"] = self._prototype(prim, to_world)
            return data
        # What a prim itself is has no part in where its children stand.
        children = {} if prim.IsA(UsdGeom.PointInstancer) else self._children(prim, to_world, path)
        if own and (children or "transform" in own):
            children = {free_name("itself", children, "itself"): own, **children}
        elif own:
            data |= own
        if children:
            data["children"] = children
        return data if data.keys() - {"transform"} else None

    def _local(self, prim: Any, parent_to_world: Matrix) -> Matrix:
        xformable = UsdGeom.Xformable(prim)
        matrix = np.array(xformable.GetLocalTransformation(self.stage.time)).T
        if not is_placement(matrix):
            self.stage.problem(prim, f"its transform must be affine, of numbers {_SMALL}")
            return np.eye(4)
        if xformable.GetResetXformStack():
            if is_singular(parent_to_world):
                text = "cannot undo the transforms above it: they flatten it to nothing"
                self.stage.problem(prim, text)
                return np.eye(4)
            matrix = np.linalg.solve(parent_to_world, self.root @ matrix)
        matrix[3] = [0.0, 0.0, 0.0, 1.0]
        return matrix

    def _own(self, prim: Any, to_world: Matrix, path: str) -> Data | None:
        """The nodes for a prim's place."""
        kind = str(prim.GetTypeName())
        if prim.IsA(UsdGeom.Mesh) or prim.IsA(UsdGeom.Points):
            return self._mesh(prim, to_world, path)
        if prim.IsA(UsdGeom.BasisCurves):
            return self._curves(prim, to_world)
        if prim.IsA(UsdGeom.PointInstancer):
            return self._point_instancer(prim, to_world)
        if prim.IsA(UsdGeom.Camera):
            self.stage.report.count("cameras")
            camera, aspect = read_camera(self.stage, prim)
            self.add_camera(path, aspect, to_world)
            return {"camera": camera}
        if is_light(prim):
            return self._light(prim, to_world)
        found = solid(self.stage, prim)
        if found is not None:
            return self._solid(prim, found, to_world)
        if kind not in _SILENT and (prim.IsA(UsdGeom.Imageable) or prim.HasAPI(UsdLux.LightAPI)):
            self.stage.report.drop(f"{prim.GetPath()}: {kind} is not covered")
        return None

    def _light(self, prim: Any, to_world: Matrix) -> Data | None:
        self.stage.report.count("lights")
        placed = read_light(self.stage, prim, to_world)
        self.is_lit = True
        if placed.radius > 0.0:
            self._balls.append((str(prim.GetPath()), to_world, placed.radius))
        if placed.dome and self.environment is None and "transform" not in placed.dome:
            self.environment = placed.dome["light"]
        elif placed.dome:
            self._domes.append(placed.dome)
        return placed.node or None

    def _solid(self, prim: Any, found: tuple[Data, list[Data]], to_world: Matrix) -> Data:
        self.stage.report.count("solids")
        shape, steps = found
        shape = shape.get("__mesh__", shape)
        bsdf, material = self._material_of(prim, prim)
        if material.inside is not None:
            bsdf, material = self._body(prim, shape, material)
        data: Data = {"shape": shape, "bsdf": bsdf}
        placed = parse_transform(steps, lambda issue: None)
        self.bounds.add(data["shape"], to_world @ placed.matrix)
        if steps:
            data["transform"] = steps
        return self._shining(data, material, to_world @ placed.matrix)

    def _curves(self, prim: Any, to_world: Matrix) -> Data | None:
        self.stage.report.count("curves")
        if (shape := read_curves(self.stage, prim)) is None:
            return None
        self.bounds.add(shape, to_world)
        bsdf, material = self._material_of(prim, prim)
        if (colored := with_mean_color(self.stage, prim, material)) is not None:
            material = colored
            bsdf = self._bsdf_name(("curves", str(prim.GetPath())), material, None, prim)
        if material.inside is not None:
            text = f"{prim.GetPath()}: curves are open: no light is scattered below their surface"
            self.stage.report.approximate(text)
        return self._shining({"shape": shape, "bsdf": bsdf}, material, to_world)

    def _mesh(self, prim: Any, to_world: Matrix, path: str) -> Data | None:
        scattered = prim.IsA(UsdGeom.Points)
        self.stage.report.count("points" if scattered else "meshes")
        subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        indices = [self.stage.value(subset.GetIndicesAttr(), []) for subset in subsets]
        bound = [subset.GetPrim() for subset in subsets]
        faces = len(self.stage.value(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr(), []))
        if len({int(face) for part in indices for face in part}) < faces:
            bound.append(prim)
        sets = {name for part in bound for name in self._sets_of(part, prim)}
        pose = self._poses.get(str(prim.GetPath()))
        if scattered:
            triangles = read_points(self.stage, prim)
        else:
            triangles = read_mesh(self.stage, prim, sorted(sets), pose)
        if triangles is None:
            return None
        self.bounds.add(triangles.vertices, to_world)
        # Parts may have an inside together: then light is scattered below all of them.
        scatter = all(self._material_of(part, prim)[1].inside is not None for part in bound)
        whole = scatter and len(bound) > 1 and has_inside(mesh_of(arrays_of(triangles, ())))
        parts: dict[str, Data] = {}
        rest = np.ones(len(triangles.faces), bool)
        for subset, its_faces in zip(subsets, indices, strict=True):
            chosen = np.isin(triangles.origin, np.array(its_faces, np.int64)) & rest
            rest &= ~chosen
            if chosen.any():
                part = subset.GetPrim()
                parts[part.GetName()] = self._part(prim, part, triangles, chosen, to_world, whole)
        if rest.any():
            left = None if rest.all() else rest
            name = free_name("rest", parts, "rest")
            parts[name] = self._part(prim, prim, triangles, left, to_world, whole)
        return next(iter(parts.values())) if len(parts) == 1 else {"children": parts}

    def _sets_of(self, bound: Any, prim: Any) -> tuple[str, ...]:
        """Names of the texture coordinates that a mesh, or a part of one, needs."""
        return self._material_of(bound, prim)[1].sets or (DEFAULT_COORDINATES,)

    def _part(
        self,
        prim: Any,
        bound: Any,
        triangles: Triangles,
        chosen: Any,
        to_world: Matrix,
        whole: bool,
    ) -> Data:
        say_what_is_lacking(self.stage, prim, self._material_of(bound, prim)[1].sets, triangles)
        try:
            mesh = mesh_of(arrays_of(triangles, self._sets_of(bound, prim), chosen))
        except SceneError as error:
            self.stage.problem(prim, error.issues[0].sentence)
            raise SceneError(self.stage.report.issues) from None
        name, material = self._material_of(bound, prim)
        if material.inside is not None:
            name, material = self._body(bound, mesh, material, whole)
        emission = glow_of(self.stage, prim, material.emission, triangles, to_world)
        material = replace(material, emission=emission)
        self.is_lit |= prim.HasAPI(UsdLux.MeshLightAPI)
        return self._shining({"shape": mesh, "bsdf": name}, material, to_world)

    def _body(
        self, prim: Any, shape: Data | Mesh, material: Surface, whole: bool = False
    ) -> tuple[str, Surface]:
        """What a material is that scatters light inside, by whether the shape has an inside."""
        is_mesh = isinstance(shape, Mesh)
        closed = whole or has_inside(shape) if is_mesh else shape["type"] != "rectangle"
        if not closed:
            text = f"{prim.GetPath()}: open or inside out: no light is scattered below its surface"
            self.stage.report.approximate(text)
        material = material.on(closed)
        return self._bsdf_name(("body", str(prim.GetPath())), material, None, prim), material

    def _shining(self, data: Data, material: Surface, to_world: Matrix) -> Data:
        data["shape"] = self.lifting.lift(data["shape"], material.heights, self.bounds, to_world)
        if isinstance(data["shape"], Mesh):
            self.shine(data["shape"], material, to_world)
        elif material.emission is not None:
            self.glow.add_shape(data["shape"], to_world, material.emission)
        return data | material.light

    def _material_of(self, bound: Any, prim: Any) -> tuple[str, Surface]:
        """Name and content of the material of a prim or of a part of it."""
        material, _ = UsdShade.MaterialBindingAPI(bound).ComputeBoundMaterial()
        # Materials may use the primvars of the prim; without a material, only they count.
        shown = shown_of(self.stage, prim)
        constants = constants_of(self.stage, prim) if material else ()
        key = (source_of(material.GetPrim()) if material else "", shown, constants)
        if key not in self._materials:
            read = read_material(self.stage, material, prim) if material else None
            read = read or plain_material(self.stage, prim)
            self._materials[key] = (self._bsdf_name(key, read, material, prim), read)
        return self._materials[key]

    def _bsdf_name(self, key: Hashable, read: Surface, material: Any, prim: Any) -> str:
        """Name of a material, one for all that are alike."""
        for name, bsdf in self.bsdfs.items():
            if bsdf == read.bsdf:
                return name
        self.stage.report.count("materials")
        place = material.GetPath() if material else prim.GetPath()
        wanted = material.GetPrim().GetName() if material else "plain"
        return self.name_of(key, read, wanted, f"{self.stage.name}: {place}")

    def _prototype(self, prim: Any, to_world: Matrix) -> str:
        """Name of what an instance shows; read once for all that are handed the same."""
        key = (str(prim.GetPrototype().GetPath()), handed_down(self.stage, prim))
        name = self._prototype_names.get(key)
        if name is None:
            name = self._shared(key, prim, self._children)
        self._add_bounds(name, to_world)
        return name

    def _shared(self, key: Hashable, prim: Any, read: Any) -> str:
        """Read a prototype in a space of its own."""
        outer, self.bounds = self.bounds, Bounds()
        cameras, self.cameras, view = self.cameras, [], self.view
        name = free_name(prim.GetName(), self.prototypes, "prototype")
        # Reserved now: prototypes may hold others.
        self.prototypes[name] = {}
        self.prototypes[name] = {"children": read(prim, np.eye(4), "")}
        self._prototype_names[key] = name
        self._prototype_bounds[name] = self.bounds
        self.bounds, self.cameras, self.view = outer, cameras, view
        return name

    def _add_bounds(self, name: str, to_world: Matrix) -> None:
        box = self._prototype_bounds[name]
        if np.isfinite(box.low).all():
            self.bounds.add(corners(box.low, box.high), to_world)

    def _point_instancer(self, prim: Any, to_world: Matrix) -> Data | None:
        instancer = UsdGeom.PointInstancer(prim)
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        indices = np.array(self.stage.value(instancer.GetProtoIndicesAttr(), []), np.int64)
        bad = (indices < 0) | (indices >= len(targets))
        if bad.any():
            text = f"protoIndices must be in 0 to {len(targets) - 1}, got {int(indices[bad][0])}"
            self.stage.problem(prim, text)
            return None
        names = [self._prototype_of_point(target) for target in targets]
        moves = instancer.ComputeInstanceTransformsAtTime(
            self.stage.time, self.stage.time, UsdGeom.PointInstancer.IncludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask,
        )  # fmt: skip
        mask = np.array(instancer.ComputeMaskAtTime(self.stage.time), bool)
        if len(moves) != len(indices):
            self.stage.problem(prim, "positions, orientations and scales do not fit protoIndices")
            return None
        children: dict[str, Data] = {}
        for i, (index, move) in enumerate(zip(indices, moves, strict=True)):
            name = names[index]
            if name is None or (len(mask) and not mask[i]):
                continue
            matrix = np.array(move).T
            if not is_placement(matrix):
                self.stage.problem(
                    prim, f"the transform of instance {i} must hold numbers {_SMALL}"
                )
                return None
            children[f"{i}"] = {"instance": name, "transform": {"matrix": matrix.tolist()}}
            self._add_bounds(name, to_world @ matrix)
        self.stage.report.count("instances", len(children))
        return {"children": children} if children else None

    def _prototype_of_point(self, target: Any) -> str | None:
        prim = self.stage.stage.GetPrimAtPath(target)
        if not prim:
            self.stage.report.approximate(f"{target}: no such prototype; left out")
            return None
        key = ("point", source_of(prim), handed_down(self.stage, prim))
        if key not in self._prototype_names:
            self._shared(key, prim, self._point_prototype)
        return self._prototype_names[key]

    def _point_prototype(self, prim: Any, to_world: Matrix, path: str) -> dict[str, Data]:
        # The transform of the prototype's root is part of each instance's.
        own, children = self._own(prim, to_world, path), self._children(prim, to_world, path)
        return ({free_name("itself", children, "itself"): own} if own else {}) | children
