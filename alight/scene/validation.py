"""Checks that need more than one description: names, cycles, placement, matrices, meshes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.core.errors import Issue, SceneError, join_path, show_value, unknown_name
from alight.core.spec import Bsdf, Spec, Texture, energy_problem
from alight.scene.description import Node, Scene
from alight.scene.meshes import MeshStore, surface_area
from alight.scene.transform import Matrix, is_singular
from alight.shapes.mesh import Mesh

MOST_PLACED = 4_000_000
MOST_LEVELS = 24


def find_problems(scene: Scene, store: MeshStore | None = None) -> list[Issue]:
    """List everything that keeps a scene from being rendered.

    Parameters
    ----------
    scene : Scene
        Its parts are valid by themselves.
    store : MeshStore, optional
        Reads the meshes; an own one by default.

    Returns
    -------
    list of Issue
        Without places; `Source.located` adds them.
    """
    checker = _Checker(scene, store or MeshStore(scene.source.folder))
    checker.check_materials()
    checker.check_prototypes()
    checker.check_nodes()
    checker.check_camera()
    checker.check_environment()
    return checker.issues


@dataclass
class _Checker:
    scene: Scene
    store: MeshStore
    issues: list[Issue] = field(default_factory=list)

    def report(self, path: str, message: str) -> None:
        self.issues.append(Issue(path, message))

    def check_materials(self) -> None:
        """Check named materials, and those written inside nodes."""
        for name, bsdf in self.scene.bsdfs.items():
            self.check_bsdf(bsdf, join_path("bsdfs", name))
        for path, node in all_nodes(self.scene):
            if isinstance(node.bsdf, str):
                self.check_name("bsdf", node.bsdf, self.scene.bsdfs, f"{path}.bsdf")
            elif node.bsdf is not None:
                self.check_bsdf(node.bsdf, f"{path}.bsdf")

    def check_name(self, kind: str, name: str, known: dict[str, Any], path: str) -> bool:
        if name in known:
            return True
        self.report(path, unknown_name(kind, name, known))
        return False

    def check_bsdf(self, bsdf: Bsdf, path: str) -> None:
        resolved = {}
        for name, value in bsdf:
            here = f"{path}.{name}"
            if name == "bsdf":
                self.check_nested(value, here)
                continue
            named = isinstance(value, str) and holds_texture(bsdf, name)
            if named and self.check_name("texture", value, self.scene.textures, here):
                resolved[name] = self.scene.textures[value]
        # Named textures count for the checks inside a model only once they are known.
        if {"diffuse", "specular"} & set(resolved):
            names = ("diffuse", "specular")
            problem = energy_problem(**{n: resolved.get(n, getattr(bsdf, n)) for n in names})
            if problem:
                self.report(path, problem)

    def check_nested(self, nested: Bsdf | str, path: str) -> None:
        if isinstance(nested, Bsdf):
            self.check_bsdf(nested, path)
        elif self.check_name("bsdf", nested, self.scene.bsdfs, path):
            target = self.scene.bsdfs[nested]
            if hasattr(target, "bsdf"):
                self.report(path, f'must not be {target.type_name()} itself, got "{nested}"')
            elif target.transmissive:
                kind = target.type_name()
                self.report(path, f'"{nested}" ({kind}) has two sides already: use it alone')

    def check_prototypes(self) -> None:
        """Check instance names, cycles, and how many shapes they multiply to."""
        known = self.scene.prototypes
        for path, node in all_nodes(self.scene):
            if node.instance is not None:
                self.check_name("prototype", node.instance, known, f"{path}.instance")
        for name, prototype in known.items():
            for _, path, node in prototype.walk(name, join_path("prototypes", name)):
                if node.camera is not None:
                    self.report(f"{path}.camera", "a camera must not stand in a prototype")
        cycle = find_cycle(known)
        if cycle:
            chain = " -> ".join(cycle)
            self.report(join_path("prototypes", cycle[0]), f"contains itself: {chain}")
            return
        counts = count_shapes(self.scene)
        if counts > MOST_PLACED:
            self.report("nodes", f"must place at most {MOST_PLACED} shapes, got {counts}")

    def check_nodes(self) -> None:
        """Check transforms, lights and meshes of every node."""
        for path, node, to_world in placed_nodes(self.scene):
            if path.count(".children.") >= MOST_LEVELS:
                self.report(path, f"is nested deeper than {MOST_LEVELS} levels")
                continue
            singular = is_singular(node.transform.matrix)
            if singular:
                self.report(f"{path}.transform", "is singular: it flattens space")
            elif is_singular(to_world) or np.abs(to_world).max() > 1e15:
                text = "together with its parents' transforms it is singular or too large"
                self.report(f"{path}.transform", text)
            self.check_light(node, path)
            if isinstance(node.shape, Mesh):
                self.check_mesh(node, path, to_world)

    def check_light(self, node: Node, path: str) -> None:
        light = node.light
        if light is None:
            return
        kind = f"{light.type_name()} light"
        if light.placement == "environment":
            self.report(f"{path}.light", f"{kind} has no place: give it as environment")
        elif light.placement == "node" and node.shape is not None:
            self.report(f"{path}.light", f"{kind} has no shape: give it a node of its own")
        elif light.placement == "shape" and node.shape is None:
            self.report(f"{path}.light", f"{kind} needs a shape on the same node")
        elif light.placement == "shape" and node.shape and not node.shape.finite:
            text = f"{kind} needs a finite shape, got {node.shape.type_name()}"
            self.report(f"{path}.light", text)

    def check_mesh(self, node: Node, path: str, to_world: Matrix) -> None:
        assert isinstance(node.shape, Mesh)
        try:
            geometry = self.store.geometry(node.shape)
        except SceneError as error:
            self.issues += [issue.under(f"{path}.shape") for issue in error.issues]
            return
        if node.light is not None and not surface_area(geometry, to_world) > 0.0:
            self.report(f"{path}.light", "its shape must have an area > 0, got 0 m^2")

    def check_camera(self) -> None:
        camera = self.scene.camera
        if camera is None:
            self.report("camera", "is missing: a scene needs a camera")
        elif isinstance(camera, str):
            nodes = {p: node for p, _, node in self.scene.walk()}
            known = {p: node for p, node in nodes.items() if node.camera is not None}
            if camera in nodes and camera not in known:
                self.report("camera", f"node {show_value(camera)} has no camera")
            elif camera not in nodes:
                self.check_name("camera node", camera, known, "camera")
        elif is_singular(camera.transform.matrix):
            self.report("camera.transform", "is singular: it flattens space")

    def check_environment(self) -> None:
        light = self.scene.environment
        if light is not None and light.placement != "environment":
            self.report("environment", f"must surround the scene, got {light.type_name()} light")


def holds_texture(spec: Spec, name: str) -> bool:
    """Whether a field takes a texture, described or named."""
    metadata = type(spec).model_fields[name].metadata
    return any(Texture in getattr(item, "other", ()) for item in metadata)


def all_nodes(scene: Scene) -> Iterator[tuple[str, Node]]:
    """Visit every node, prototypes too: key path and node."""
    for name, prototype in scene.prototypes.items():
        for _, path, node in prototype.walk(name, join_path("prototypes", name)):
            yield path, node
    for _, path, node in scene.walk():
        yield path, node


def placed_nodes(scene: Scene) -> Iterator[tuple[str, Node, Matrix]]:
    """Visit every node with its matrix: to the world, for prototypes to their instances."""
    roots = [(join_path("prototypes", name), node) for name, node in scene.prototypes.items()]
    roots += [(join_path("nodes", name), node) for name, node in scene.nodes.items()]
    for keys, root in roots:
        stack = [(keys, root, np.eye(4))]
        while stack:
            path, node, parent = stack.pop()
            with np.errstate(over="ignore", invalid="ignore"):
                to_world = parent @ node.transform.matrix
            yield path, node, to_world
            stack.extend(
                (f"{path}.children.{name}", child, to_world)
                for name, child in reversed(node.children.items())
            )


def find_cycle(prototypes: dict[str, Node]) -> list[str] | None:
    """Find a prototype that contains itself: the chain of names, its first one repeated last."""
    done: set[str] = set()

    def uses(name: str) -> list[str]:
        nodes = prototypes[name].walk("", "")
        return [n.instance for _, _, n in nodes if n.instance in prototypes]

    for start in prototypes:
        chain, pending = [start], [iter(uses(start))]
        while chain:
            following = next((n for n in pending[-1] if n not in done), None)
            if following is None:
                done.add(chain.pop())
                pending.pop()
            elif following in chain:
                return [*chain[chain.index(following) :], following]
            else:
                chain.append(following)
                pending.append(iter(uses(following)))
    return None


def count_shapes(scene: Scene) -> int:
    """Count the shapes after all instances are put in place; prototypes must have no cycle."""
    counts: dict[str, int] = {}

    def count(nodes: Iterator[Node], in_prototype: Callable[[str], int]) -> int:
        return sum(
            (node.shape is not None) + (in_prototype(node.instance) if node.instance else 0)
            for node in nodes
        )

    def count_prototype(name: str) -> int:
        if name not in scene.prototypes:
            return 0
        if name not in counts:
            nodes = (node for _, _, node in scene.prototypes[name].walk("", ""))
            counts[name] = count(nodes, count_prototype)
        return counts[name]

    return count((node for _, _, node in scene.walk()), count_prototype)
