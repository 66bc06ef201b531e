"""What must not move while the shutter is open, or not in every way."""

from __future__ import annotations

from collections.abc import Iterator

from alight.core.errors import Issue, join_path
from alight.core.spec import Camera
from alight.scene.description import Node, Scene
from alight.scene.keyframes import Keyframes
from alight.scene.motion import NOWHERE, Placement
from alight.shapes.model import SHAPES


def motion_problems(scene: Scene) -> list[Issue]:
    """List what is wrong with what moves; names and cycles must have been checked before."""
    if not any(isinstance(node.transform, Keyframes) for node in _all_nodes(scene)):
        return []
    shutter = _camera(scene).shutter
    issues: dict[tuple[str, str], Issue] = {}
    for keys, node, here in _placed(scene, shutter):
        if here.motion is None:
            continue
        for name, text in _node_problems(scene, node, here):
            path = f"{keys}.{name}"
            issues.setdefault((path, text), Issue(path, text))
    return list(issues.values())


def has_keyframes(scene: Scene) -> bool:
    """Whether anything moves at any time: a node, or the camera."""
    camera = [scene.camera] if isinstance(scene.camera, Node) else []
    return any(isinstance(node.transform, Keyframes) for node in (*_all_nodes(scene), *camera))


def _node_problems(scene: Scene, node: Node, here: Placement) -> Iterator[tuple[str, str]]:
    """(field, message) of what one moving node holds."""
    if node.shape is not None and not node.shape.finite:
        kind = node.shape.type_name()
        yield "shape", f"a {kind} is infinite and cannot move: take a large finite shape"
    elif node.shape is not None and SHAPES[node.shape.type_name()].is_many:
        yield "shape", f"{node.shape.type_name()} cannot move while the shutter is open"
    for side in ("interior", "exterior"):
        medium = getattr(node, side)
        medium = scene.media.get(medium) if isinstance(medium, str) else medium
        if medium is not None and medium.has_place:
            name = medium.type_name()
            yield side, f"a {name} medium has its own place in the world: its border cannot move"
    if node.light is None:
        return
    kind = node.light.type_name()
    if node.light.placement == "environment":
        yield "light", f"a light from infinity ({kind}) cannot move while the shutter is open"
    elif here.motion is not None and not here.motion.is_rigid:
        yield "light", "a moving light can shift and turn only: its size or shape must not change"


def _placed(scene: Scene, shutter: tuple[float, float]) -> Iterator[tuple[str, Node, Placement]]:
    """Every node of the graph, and of the prototypes that moving ones instance, each once."""
    stack = [(join_path("nodes", name), node, NOWHERE) for name, node in scene.nodes.items()]
    seen = set()
    while stack:
        keys, node, above = stack.pop()
        here = above.then(node.transform, shutter)
        yield keys, node, here
        children = node.children.items()
        stack += [(f"{keys}.children.{name}", child, here) for name, child in children]
        name = node.instance
        if name is not None:
            # What a prototype may hold depends on this much of what moves it.
            rigid = None if here.motion is None else here.motion.is_rigid
            if (name, rigid) not in seen:
                seen.add((name, rigid))
                stack.append((join_path("prototypes", name), scene.prototypes[name], here))


def _all_nodes(scene: Scene) -> Iterator[Node]:
    for name, root in (*scene.prototypes.items(), *scene.nodes.items()):
        for _, _, node in root.walk(name, ""):
            yield node


def _camera(scene: Scene) -> Camera:
    """The camera in use, or one like any other."""
    if isinstance(scene.camera, Node):
        return scene.camera.camera or Camera()
    nodes = {path: node for path, _, node in scene.walk()}
    found = nodes.get(scene.camera or "")
    return Camera() if found is None or found.camera is None else found.camera
