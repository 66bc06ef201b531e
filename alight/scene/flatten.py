"""Scene graph -> flat lists for the compiler: names resolved, transforms composed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from alight.bsdfs.nesting import scatters_inside
from alight.core.errors import SceneError
from alight.core.registry import default_of
from alight.core.spec import Bsdf, Camera, Integrator, Light, Medium, Sampler, Shape, Texture
from alight.media.coefficients import Coefficients
from alight.scene import images, volumes
from alight.scene.checked import checked_files
from alight.scene.description import VACUUM, FilmSettings, Node, Scene
from alight.scene.files import Files
from alight.scene.meshes import Geometry, geometry
from alight.scene.motion import NOWHERE, Motion
from alight.scene.strands import with_arrays
from alight.scene.transform import Matrix
from alight.scene.translucent_strands import strand_problems
from alight.shapes.arrays import TriangleShape

NO_GEOMETRY = -1

#: What the material of shapes is called for which the scene names none.
DEFAULT = "default"


class PlacedShape(NamedTuple):
    """A shape in the world.

    Attributes
    ----------
    name : str
        Node path; below an instance the path inside its prototype follows.
    shape : Shape
        Description; a mesh's arrays are in `FlatScene.geometries`.
    to_world : (4, 4) float64
        From the shape's space to the world, or to where its motion begins.
    bsdf : int
        Index into `FlatScene.bsdfs`.
    light : Light or None
        Emission of the surface.
    geometry : int
        Index into `FlatScene.geometries`, or `NO_GEOMETRY` for other shapes than meshes.
    border : (int, int) or None
        Media on the inner and the outer side: 0 for none, else index into `FlatScene.media` + 1.
        None where the shape does not bound any.
    motion : Motion or None
        What moves it further while the shutter is open.
    material : str
        Name of the material; of one without a name, the path of the node that has it.
    """

    name: str
    shape: Shape
    to_world: Matrix
    bsdf: int
    light: Light | None
    geometry: int
    border: tuple[int, int] | None = None
    motion: Motion | None = None
    material: str = DEFAULT


class PlacedLight(NamedTuple):
    """A light without a shape: name, description, (4, 4) float64 matrix to the world, motion."""

    name: str
    light: Light
    to_world: Matrix
    motion: Motion | None = None


class PlacedCamera(NamedTuple):
    """The camera: description, (4, 4) float64 matrix to the world, and motion."""

    camera: Camera
    to_world: Matrix
    motion: Motion | None = None


@dataclass(frozen=True)
class FlatScene:
    """What the compiler reads.

    Attributes
    ----------
    shapes : list of PlacedShape
        In the order of the scene graph, instances expanded.
    geometries : list of Geometry
        Different meshes; instances and equal meshes share one.
    bsdfs : list of Bsdf
        Different materials, with named textures and nested materials put in place.
    textures : dict of str to Texture
        The named textures.
    lights : list of PlacedLight
        Lights without a shape, but for environments.
    environments : list of PlacedLight
        Light from infinity, which adds up; of their matrices only the rotation counts.
    camera : PlacedCamera
        Viewpoint.
    film, sampler, integrator
        Settings, as in `Scene`.
    warnings : list of str
        What is legal but suspicious.
    media : list of Coefficients
        Different media, grids read.
    start_medium : int
        Index + 1 of the medium around the camera, or 0.
    notes : list of str
        What had to be changed in pictures.
    by_node : dict of str to PlacedNode
        Nodes at the top that came to nothing else than meshes and plain shapes, for the next scene.
    """

    shapes: list[PlacedShape]
    geometries: list[Geometry]
    bsdfs: list[Bsdf]
    textures: dict[str, Texture]
    lights: list[PlacedLight]
    environments: list[PlacedLight]
    camera: PlacedCamera
    film: FilmSettings
    sampler: Sampler
    integrator: Integrator
    warnings: list[str]
    media: list[Coefficients] = field(default_factory=list)
    start_medium: int = 0
    notes: list[str] = field(default_factory=list)
    by_node: dict[str, PlacedNode] = field(default_factory=dict)


class PlacedNode(NamedTuple):
    """A node at the top of the graph, and the shapes that it came to, each with what it was of."""

    node: Node
    found: list[tuple[PlacedShape, Bsdf | str | None, Shape]]


def flatten(scene: Scene, before: FlatScene | None = None) -> FlatScene:
    """Resolve a scene for the compiler.

    Parameters
    ----------
    scene : Scene
    before : FlatScene, optional
        Of a scene with the same prototypes, textures and media: what came of nodes that are the
        same objects is used again.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    files = checked_files(scene)
    camera = place_camera(scene)
    shutter = camera.camera.shutter
    same_times = before is not None and before.camera.camera.shutter == shutter
    flattener = _Flattener(scene, files, shutter, before.by_node if before and same_times else {})
    if scene.environment is not None:
        light = images.resolved(scene.environment, scene.textures, files)
        flattener.environments.append(PlacedLight("environment", light, np.eye(4)))
    for name, node in scene.nodes.items():
        flattener.place(name, node)
    placed = ((one.name, one.shape, flattener.bsdfs[one.bsdf]) for one in flattener.shapes)
    issues = strand_problems(scene.integrator, placed)
    if issues:
        raise SceneError([scene.source.located(issue) for issue in issues])
    standing_in = scene.medium if camera.camera.medium is None else camera.camera.medium
    start_medium = flattener.medium_number(standing_in)
    return FlatScene(
        shapes=flattener.shapes,
        geometries=flattener.geometries,
        bsdfs=flattener.bsdfs,
        textures=dict(scene.textures),
        lights=flattener.lights,
        environments=flattener.environments,
        camera=camera,
        film=scene.film,
        sampler=scene.sampler,
        integrator=scene.integrator,
        warnings=list(scene.warnings),
        media=flattener.media,
        start_medium=start_medium,
        notes=list(files.notes),
        by_node=flattener.by_node,
    )


@dataclass
class _Flattener:
    """Walks the graph, parents before children, and numbers what it meets."""

    scene: Scene
    files: Files
    shutter: tuple[float, float]
    before: Mapping[str, PlacedNode]
    by_node: dict[str, PlacedNode] = field(default_factory=dict)
    shapes: list[PlacedShape] = field(default_factory=list)
    lights: list[PlacedLight] = field(default_factory=list)
    environments: list[PlacedLight] = field(default_factory=list)
    bsdfs: list[Bsdf] = field(default_factory=list)
    geometries: list[Geometry] = field(default_factory=list)
    media: list[Coefficients] = field(default_factory=list)
    _lights: dict[int, Light] = field(default_factory=dict)
    _bsdf_index: dict[Bsdf, int] = field(default_factory=dict)
    _bsdf_by_key: dict[str | int | None, int] = field(default_factory=dict)
    _geometry_index: dict[str, int] = field(default_factory=dict)
    _geometry_of: dict[int, int] = field(default_factory=dict)

    def place(self, name: str, root: Node) -> None:
        """Place a node at the top, or take what it came to before."""
        known = self.before.get(name)
        if known is not None and known.node is root:
            found = [(self.again(*one), *one[1:]) for one in known.found]
            self.by_node[name] = PlacedNode(root, found)
            self.shapes += [placed for placed, _, _ in found]
            return
        found, others = [], (len(self.lights), len(self.environments))
        self.place_tree(name, root, found)
        # Lights, media and files are looked at anew.
        if (
            self.scene.medium is None
            and others == (len(self.lights), len(self.environments))
            and all(
                one.light is None and one.border is None and one.shape is shape
                for one, _, shape in found
            )
        ):
            self.by_node[name] = PlacedNode(root, found)

    def again(self, placed: PlacedShape, bsdf: Bsdf | str | None, shape: Shape) -> PlacedShape:
        """A shape where it was, with the numbers that its material and its arrays have now."""
        index, geometry = self.bsdf_index(bsdf), self.geometry_index(shape)
        if (index, geometry) == (placed.bsdf, placed.geometry):
            return placed
        return placed._replace(bsdf=index, geometry=geometry)

    def place_tree(
        self, path: str, root: Node, found: list[tuple[PlacedShape, Bsdf | str | None, Shape]]
    ) -> None:
        """Place a node, what it instances, and its children."""
        stack: list[Any] = [(path, root, NOWHERE, None, DEFAULT)]
        while stack:
            path, node, parent, bsdf, material = stack.pop()
            here = parent.then(node.transform, self.shutter)
            if node.bsdf is not None:
                bsdf, material = node.bsdf, node.bsdf if isinstance(node.bsdf, str) else path
            light = None if node.light is None else self.light(node.light)
            if node.shape is not None:
                index, geometry = self.bsdf_index(bsdf), self.geometry_index(node.shape)
                self.shapes.append(
                    PlacedShape(
                        name=path,
                        shape=images.with_heights(
                            with_arrays(node.shape, self.files), self.scene.textures, self.files
                        ),
                        to_world=here.matrix,
                        bsdf=index,
                        light=light,
                        geometry=geometry,
                        border=self.border(node, self.bsdfs[index]),
                        motion=here.motion,
                        material=material,
                    )
                )
                found.append((self.shapes[-1], bsdf, node.shape))
            elif light is not None:
                placed = PlacedLight(path, light, here.matrix, here.motion)
                if light.placement == "environment":
                    self.environments.append(placed)
                else:
                    self.lights.append(placed)
            given = here, bsdf, material
            below = [(f"{path}/{name}", child, *given) for name, child in node.children.items()]
            if node.instance is not None:
                prototype = self.scene.prototypes[node.instance]
                below.insert(0, (f"{path}/{node.instance}", prototype, *given))
            stack.extend(reversed(below))

    def border(self, node: Node, bsdf: Bsdf) -> tuple[int, int] | None:
        """Number the media on both sides of a shape, if it bounds any; fog ends at bodies."""
        around = self.scene.medium is not None and scatters_inside(bsdf)
        if node.interior is None and node.exterior is None and not around:
            return None
        outside = self.scene.medium if node.exterior is None else node.exterior
        return self.medium_number(node.interior), self.medium_number(outside)

    def medium_number(self, medium: Medium | str | None) -> int:
        """Number a medium from 1 on; equal ones share a number."""
        if medium is None or medium == VACUUM:
            return 0
        described = self.scene.media[medium] if isinstance(medium, str) else medium
        loaded = volumes.loaded(described, self.files)
        if loaded not in self.media:
            self.media.append(loaded)
        return self.media.index(loaded) + 1

    def light(self, light: Light) -> Light:
        """A light with its textures; the same object for the same description."""
        if id(light) not in self._lights:
            self._lights[id(light)] = images.resolved(light, self.scene.textures, self.files)
        return self._lights[id(light)]

    def bsdf_index(self, bsdf: Bsdf | str | None) -> int:
        """Number a material; equal ones share a number."""
        # The scene holds its descriptions: none takes the place of another while this goes on.
        key = bsdf if bsdf is None or isinstance(bsdf, str) else id(bsdf)
        if key in self._bsdf_by_key:
            return self._bsdf_by_key[key]
        given = default_of(Bsdf) if bsdf is None else bsdf
        resolved = resolve_bsdf(given, self.scene, self.files)
        index = self._bsdf_index.setdefault(resolved, len(self.bsdfs))
        if index == len(self.bsdfs):
            self.bsdfs.append(resolved)
        self._bsdf_by_key[key] = index
        return index

    def geometry_index(self, shape: Shape) -> int:
        """Number a mesh's arrays; equal ones share a number."""
        if not isinstance(shape, TriangleShape):
            return NO_GEOMETRY
        if id(shape) in self._geometry_of:
            return self._geometry_of[id(shape)]
        found = geometry(shape, self.files)
        index = self._geometry_index.setdefault(found.digest, len(self.geometries))
        if index == len(self.geometries):
            self.geometries.append(found)
        self._geometry_of[id(shape)] = index
        return index


def resolve_bsdf(bsdf: Bsdf | str, scene: Scene, files: Files) -> Bsdf:
    """Replace the names of textures, pictures and nested materials by what they name."""
    bsdf = scene.bsdfs[bsdf] if isinstance(bsdf, str) else bsdf
    bsdf = images.resolved(bsdf, scene.textures, files)
    changes: dict[str, Any] = {}
    for name, value in bsdf:
        if name == "bsdfs":
            changes[name] = tuple(resolve_bsdf(nested, scene, files) for nested in value)
        elif name in ("bsdf", "back") and value is not None:
            changes[name] = resolve_bsdf(value, scene, files)
    return bsdf.replaced(**changes) if changes else bsdf


def place_camera(scene: Scene) -> PlacedCamera:
    """The camera of a scene, in its place; the names on its path must be right."""
    assert scene.camera is not None
    nodes = [scene.camera] if isinstance(scene.camera, Node) else []
    children = scene.nodes
    for name in () if nodes else str(scene.camera).split("/"):
        nodes.append(children[name])
        children = nodes[-1].children
    camera, here = nodes[-1].camera, NOWHERE
    assert camera is not None
    for node in nodes:
        here = here.then(node.transform, camera.shutter)
    return PlacedCamera(camera, here.matrix, here.motion)
