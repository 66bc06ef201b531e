"""Checks that need more than one description: names, cycles, placement, matrices, meshes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from alight.bsdfs.nesting import (
    Nested,
    count_leaves,
    count_levels,
    leaves_problem,
    levels_problem,
    names_in,
)
from alight.core.energy import energy_problem
from alight.core.errors import Issue, SceneError, join_path, show_value, unknown_name
from alight.core.field_types import texture_interval
from alight.core.registry import specs
from alight.core.spec import Bsdf, Light, Spec, Texture
from alight.outputs.texels import reusing_memory
from alight.scene import images
from alight.scene.bodies import body_problems
from alight.scene.description import Node, Scene
from alight.scene.dispersion import dispersion_problems
from alight.scene.files import Files
from alight.scene.media import media_problems
from alight.scene.meshes import displacement_problem, geometry, surface_area
from alight.scene.moving import motion_problems
from alight.scene.nodes import all_nodes, count_shapes, instances_in, placed_nodes, sort_by_use
from alight.scene.strands import strand_problems
from alight.scene.transform import Matrix, is_singular
from alight.shapes.arrays import TriangleShape
from alight.textures import nesting as textures

#: Of the numbers in a matrix.
LARGEST = 1e15
MOST_PLACED = 4_000_000
MOST_LEVELS = 24
#: Prototypes in prototypes at most.
MOST_INSTANCED = 64
#: Lights that surround a scene, portals too: each is compiled by itself.
MOST_SURROUNDINGS = 64


def _is_no_place(to_world: Matrix) -> bool:
    return is_singular(to_world) or bool(np.abs(to_world).max() > LARGEST)


def find_problems(scene: Scene, files: Files | None = None) -> list[Issue]:
    """List everything that keeps a scene from being rendered.

    Parameters
    ----------
    scene : Scene
        Its parts are valid by themselves.
    files : Files, optional
        Reads meshes, pictures and grids; by default those handed on with the scene.

    Returns
    -------
    list of Issue
        Without places; `Source.located` adds them.
    """
    files = files or scene.source.files()
    checker = _Checker(scene, files)
    with reusing_memory():
        checker.check_textures()
        checker.check_materials()
        checker.check_prototypes()
        checker.check_environment()
        checker.check_nodes()
    checker.check_camera()
    issues = checker.issues + media_problems(scene, files)
    # Only materials and a graph that are right so far can be walked with all that is in them.
    return issues or body_problems(scene) + dispersion_problems(scene) + motion_problems(scene)


@dataclass
class _Checker:
    scene: Scene
    files: Files
    issues: list[Issue] = field(default_factory=list)
    # Named textures that cannot be used, and how many steps the others take.
    wrong_textures: set[str] = field(default_factory=set)
    steps: dict[str, int] = field(default_factory=dict)
    # Materials that something makes two-sided, and where.
    two_sided: list[tuple[str, Nested, Bsdf | str]] = field(default_factory=list)

    def report(self, path: str, message: str) -> None:
        self.issues.append(Issue(path, message))

    def check_textures(self) -> None:
        """Check named textures, and that they do not contain themselves or too many others."""
        known = self.scene.textures
        uses = {
            name: [used for used in textures.names_in(spec) if used in known]
            for name, spec in known.items()
        }
        cycle, order = sort_by_use(uses)
        if cycle:
            text = f"contains itself: {' -> '.join(cycle)}"
            self.report(join_path("textures", cycle[0]), text)
            self.wrong_textures = set(known)
            return
        for name in order:
            path, before = join_path("textures", name), len(self.issues)
            problem = textures.steps_problem(known[name], self.steps)
            if problem:
                self.report(path, problem)
            elif self.wrong_textures.isdisjoint(uses[name]) and self.check_image(known[name], path):
                self.check_textured(known[name], path)
                self.steps[name] = textures.count_steps(known[name], self.steps)
            # Each mistake is reported once; whatever uses it is not checked any further.
            if len(self.issues) > before or name not in self.steps:
                self.wrong_textures.add(name)

    def resolved_texture(self, value: Texture | str) -> Texture | None:
        """A texture with all that it is made of, or None if something is wrong with it."""
        names = [value] if isinstance(value, str) else list(textures.names_in(value))
        if any(n in self.wrong_textures or n not in self.scene.textures for n in names):
            return None
        texture = self.scene.textures[value] if isinstance(value, str) else value
        if textures.steps_problem(texture, self.steps):
            return None
        try:
            found = images.resolved(texture, self.scene.textures, self.files)
        except SceneError:
            return None  # reported where it stands
        return None if textures.steps_problem(found) else found

    def check_image(self, spec: Spec, path: str) -> bool:
        """Check the picture that a description takes from a file."""
        try:
            images.loaded(spec, self.files)
        except SceneError as error:
            self.issues += [issue.under(path) for issue in error.issues]
            return False
        return True

    def check_textured(self, spec: Spec, path: str) -> dict[str, Texture]:
        """Check the textures in the fields of a description; those not known to it before."""
        found: dict[str, Texture] = {}
        for name, value in spec:
            interval = texture_interval(type(spec), name)
            if interval is None or not isinstance(value, str | Texture):
                continue
            here = f"{path}.{name}"
            if isinstance(value, str):
                if not self.check_name("texture", value, self.scene.textures, here):
                    continue
            elif not self.check_image(value, here):
                continue
            else:
                before = len(self.issues)
                self.check_textured(value, here)
                if len(self.issues) > before:
                    continue
                problem = textures.steps_problem(value, self.steps)
                if problem:
                    self.report(here, problem)
            loaded = self.resolved_texture(value)
            if loaded is None:
                continue
            if max(loaded.maximum()) > interval.high:
                text = f"must be {interval.describe()} everywhere; the texture's largest value is "
                self.report(here, text + f"{max(loaded.maximum()):g}")
            elif loaded is not value:
                found[name] = loaded
        return found

    def check_materials(self) -> None:
        """Check named materials, and those written inside nodes."""
        for name, bsdf in self.scene.bsdfs.items():
            self.check_bsdf(bsdf, join_path("bsdfs", name))
        for path, node in all_nodes(self.scene):
            if isinstance(node.bsdf, str):
                self.check_name("bsdf", node.bsdf, self.scene.bsdfs, f"{path}.bsdf")
            elif node.bsdf is not None:
                self.check_bsdf(node.bsdf, f"{path}.bsdf")
        self.check_nesting()

    def check_nesting(self) -> None:
        """Check that no material contains itself, and how many models each one holds."""
        known = self.scene.bsdfs
        uses = {name: [used for used in names_in(known[name]) if used in known] for name in known}
        cycle, order = sort_by_use(uses)
        if cycle:
            text = f"contains itself: {' -> '.join(cycle)}"
            self.report(join_path("bsdfs", cycle[0]), text)
            return
        counts: dict[str, int] = {}
        levels: dict[str, int] = {}
        problems = {}
        for name in order:
            spec = known[name]
            problem = levels_problem(spec, levels) or leaves_problem(spec, counts)
            if problem:
                problems[join_path("bsdfs", name)] = problem
            # One that is too large is reported once, not again with all that use it.
            counts[name] = 0 if problem else count_leaves(spec, counts)
            levels[name] = 0 if problem else count_levels(spec, levels)
        for path, node in all_nodes(self.scene):
            if not isinstance(node.bsdf, Bsdf):
                continue
            problem = levels_problem(node.bsdf, levels) or leaves_problem(node.bsdf, counts)
            if problem:
                problems[f"{path}.bsdf"] = problem
        for path, problem in problems.items():
            self.report(path, problem)
        if not problems:
            self.check_two_sided()

    def check_two_sided(self) -> None:
        """Check that what is made two-sided has one side."""
        known = self.scene.bsdfs
        named = {name for name, spec in known.items() if makes_two_sided(spec)}
        twice = [(path, nested) for path, _, nested in self.two_sided if nested in named]
        for path, nested in twice:
            self.report(path, f'must not be two_sided itself, got "{nested}"')
        for path, outer, nested in () if twice else self.two_sided:
            problem = outer.problem_of(nested, known)
            if problem:
                self.report(path, problem)

    def check_name(self, kind: str, name: str, known: dict[str, Any], path: str) -> bool:
        if name in known:
            return True
        text = unknown_name(kind, name, known)
        if kind in ("bsdf", "texture") and name in specs(f"{kind}s"):
            # A single word is the name of an entry; types are in braces.
            before, gap, after = text.partition("  (")
            text = f"{before}; for one of that type write {{type: {name}}}{gap}{after}"
        self.report(path, text)
        return False

    def check_bsdf(self, bsdf: Bsdf, path: str) -> None:
        for name, value in bsdf:
            here = f"{path}.{name}"
            if name in ("bsdf", "back") and value is not None:
                self.check_nested(bsdf, value, here)
            elif name == "bsdfs":
                for i, nested in enumerate(value):
                    self.check_nested(bsdf, nested, f"{here}[{i}]")
        self.check_image(bsdf, path)
        resolved = self.check_textured(bsdf, path)
        # Named textures and files count for the checks inside a model only once they are known.
        if not resolved.keys().isdisjoint(bsdf.shares):
            shares = {name: resolved.get(name, getattr(bsdf, name)) for name in bsdf.shares}
            problem = energy_problem(**shares)
            if problem:
                self.report(path, problem)

    def check_nested(self, outer: Bsdf, nested: Bsdf | str, path: str) -> None:
        if isinstance(nested, Bsdf):
            self.check_bsdf(nested, path)
        else:
            self.check_name("bsdf", nested, self.scene.bsdfs, path)
        if isinstance(outer, Nested) and makes_two_sided(outer):
            self.two_sided.append((path, outer, nested))

    def check_prototypes(self) -> None:
        """Check instance names, cycles, and how many shapes they multiply to."""
        known = self.scene.prototypes
        for path, node in all_nodes(self.scene):
            if node.instance is not None:
                self.check_name("prototype", node.instance, known, f"{path}.instance")
        for name, prototype in known.items():
            for _, path, node in prototype.walk(name, join_path("prototypes", name)):
                if node.camera is not None:
                    self.report(f"{path}.camera", "a camera must not be in a prototype")
        uses = {name: instances_in(node, known) for name, node in known.items()}
        cycle, order = sort_by_use(uses)
        if cycle:
            chain = " -> ".join(cycle)
            self.report(join_path("prototypes", cycle[0]), f"contains itself: {chain}")
            return
        levels: dict[str, int] = {}
        for name in order:
            levels[name] = 1 + max((levels[used] for used in uses[name]), default=0)
            if levels[name] == MOST_INSTANCED + 1:
                text = f"holds instances within instances, deeper than {MOST_INSTANCED} levels"
                self.report(join_path("prototypes", name), text)
        if max(levels.values(), default=0) > MOST_INSTANCED:
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
            own = node.transform
            at_root = to_world is own.matrix
            if own.is_singular:
                self.report(f"{path}.transform", "is singular: it flattens space")
            elif own.largest > LARGEST if at_root else _is_no_place(to_world):
                text = "together with its parents' transforms it is singular or too large"
                self.report(f"{path}.transform", text)
            self.check_light(node, path, to_world)
            if isinstance(node.shape, TriangleShape):
                self.check_mesh(node, path, to_world)
            elif node.shape is not None:
                self.issues += strand_problems(node, path, to_world, self.files)
        lights = (node.light for _, _, node in self.scene.walk())
        around = sum(light is not None and light.placement == "environment" for light in lights)
        around += self.scene.environment is not None
        if around > MOST_SURROUNDINGS:
            text = f"must hold at most {MOST_SURROUNDINGS} lights that surround the scene"
            self.report("nodes", f"{text}, portals too, got {around}")

    def check_light(self, node: Node, path: str, to_world: Matrix) -> None:
        light = node.light
        if light is None:
            return
        kind = f"{light.type_name()} light"
        self.check_light_textures(light, f"{path}.light")
        if light.placement == "environment" and node.shape is not None:
            text = f"{kind} has no shape: give it as environment, or on a node of its own"
            self.report(f"{path}.light", text)
        elif light.placement == "environment":
            self.check_surroundings(light, path, to_world)
        elif light.placement == "node" and node.shape is not None:
            self.report(f"{path}.light", f"{kind} has no shape: give it a node of its own")
        elif light.placement == "shape" and node.shape is None:
            self.report(f"{path}.light", f"{kind} needs a shape on the same node")
        elif light.placement == "shape" and node.shape and not node.shape.finite:
            text = f"{kind} needs a finite shape, got {node.shape.type_name()}"
            self.report(f"{path}.light", text)

    def check_light_textures(self, light: Light, path: str) -> None:
        self.check_image(light, path)
        self.check_textured(light, path)

    def check_surroundings(self, light: Light, path: str, to_world: Matrix) -> None:
        """Check a node with an environment: its matrix keeps angles, a window's right ones."""
        name = light.type_name()
        if path.startswith("prototypes"):
            self.report(f"{path}.light", f"{name} light surrounds the scene: not in a prototype")
            return
        linear = to_world[:3, :3]
        square = linear.T @ linear
        if light.has_place:
            if abs(square[0, 1]) > 1e-4 * np.sqrt(square[0, 0] * square[1, 1]):
                self.report(f"{path}.transform", f"must keep the {name} a rectangle")
            return
        if not np.allclose(square, np.eye(3) * square[0, 0], rtol=0.0, atol=1e-4 * square[0, 0]):
            self.report(f"{path}.transform", "must keep all angles: an environment is only turned")

    def check_mesh(self, node: Node, path: str, to_world: Matrix) -> None:
        assert isinstance(node.shape, TriangleShape)
        try:
            found = geometry(node.shape, self.files)
        except SceneError as error:
            self.issues += [issue.under(f"{path}.shape") for issue in error.issues]
            return
        self.check_textured(node.shape, f"{path}.shape")
        problem = displacement_problem(node.shape, found, self.scene.textures)
        if problem:
            self.report(f"{path}.shape.displacement", problem)
        if node.light is not None and not surface_area(found, to_world) > 0.0:
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
        if light is None:
            return
        if light.placement != "environment":
            self.report("environment", f"must surround the scene, got {light.type_name()} light")
        elif light.has_place:
            text = f"a {light.type_name()} has a place: give it a node of its own"
            self.report("environment", text)
        self.check_light_textures(light, "environment")


def makes_two_sided(bsdf: Bsdf) -> bool:
    """Whether it makes what it holds look the same from both sides."""
    return isinstance(bsdf, Nested) and bsdf.makes_two_sided
