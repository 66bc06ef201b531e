"""Checks of a scene's media: names, grids, shapes that bound them, an integrator that sees them."""

from __future__ import annotations

from alight.core.errors import Issue, SceneError, join_path, unknown_name
from alight.core.spec import Medium
from alight.scene import volumes
from alight.scene.description import VACUUM, Node, Scene
from alight.scene.files import Files


def media_problems(scene: Scene, files: Files) -> list[Issue]:
    """List what is wrong with the media of a scene."""
    issues = []
    if VACUUM in scene.media:
        text = f'"{VACUUM}" is the name of empty space: give the medium another one'
        issues.append(Issue(join_path("media", VACUUM), text))
    for name, medium in scene.media.items():
        issues += _unreadable(medium, join_path("media", name), files)
    used = list(scene.used_media())
    for path, medium in used:
        if isinstance(medium, Medium):
            issues += _unreadable(medium, path, files)
        elif medium not in scene.media:
            issues.append(Issue(path, unknown_name("medium", medium, (*scene.media, VACUUM))))
    issues += _without_shape(scene)
    integrator = scene.integrator
    if used and integrator.needs_light and not integrator.sees_media:
        text = (
            f"{integrator.type_name()} does not see media, and the scene has some "
            f"({used[0][0]}): use volpath"
        )
        issues.append(Issue("integrator", text))
    return issues


def _unreadable(medium: Medium, path: str, files: Files) -> list[Issue]:
    try:
        problem = volumes.loaded(medium, files).problem()
    except SceneError as error:
        return [issue.under(path) for issue in error.issues]
    return [Issue(path, problem)] if problem else []


def _without_shape(scene: Scene) -> list[Issue]:
    """Nodes with a medium and no surface to bound it."""
    roots = [(join_path("prototypes", name), node) for name, node in scene.prototypes.items()]
    roots += [(join_path("nodes", name), node) for name, node in scene.nodes.items()]
    return [
        Issue(f"{path}.{side}", "needs a shape on the same node, which bounds the medium")
        for keys, root in roots
        for _, path, node in root.walk("", keys)
        for side in _sides(node)
        if node.shape is None
    ]


def _sides(node: Node) -> list[str]:
    return [side for side in ("interior", "exterior") if getattr(node, side) is not None]
