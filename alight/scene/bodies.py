"""Checks of bodies that scatter light inside: where such a material may be, and who sees it."""

from __future__ import annotations

from collections.abc import Iterator

from alight.bsdfs.nesting import Nested, scatters_inside
from alight.core.errors import Issue, join_path
from alight.core.spec import Bsdf
from alight.scene.description import VACUUM, Scene
from alight.scene.nodes import all_nodes
from alight.shapes.strands import StrandShape


def body_problems(scene: Scene) -> list[Issue]:
    """List what is wrong with the materials of bodies that scatter light inside."""
    known, issues = scene.bsdfs, []
    for path, bsdf in _materials(scene):
        if isinstance(bsdf, Nested) and scatters_inside(bsdf, known):
            parts = [part.bsdf for part in bsdf.parts]
            if len(parts) > 1:
                text = f"{bsdf.type_name()} cannot hold a material that scatters light inside"
                issues.append(Issue(path, f"{text}: use that alone, or under a normal or bump map"))
    used = []
    for path, node in all_nodes(scene):
        if node.bsdf is None or not scatters_inside(node.bsdf, known):
            continue
        used.append(f"{path}.bsdf")
        if node.interior not in (None, VACUUM):
            text = "the material scatters light inside: nothing else can be there"
            issues.append(Issue(f"{path}.interior", text))
        if isinstance(node.shape, StrandShape):
            text = (
                f"{node.shape.type_name()} has no inside for a material that scatters light there"
            )
            issues.append(Issue(f"{path}.bsdf", text))
    integrator = scene.integrator
    if used and integrator.needs_light and not integrator.walks_inside:
        text = f"{integrator.type_name()} does not see light that is scattered inside bodies"
        issues.append(Issue("integrator", f"{text}, and the scene has some ({used[0]}): use path"))
    return issues


def _materials(scene: Scene) -> Iterator[tuple[str, Bsdf]]:
    """Every description of a material that is not inside another one."""
    for name, bsdf in scene.bsdfs.items():
        yield join_path("bsdfs", name), bsdf
    for path, node in all_nodes(scene):
        if isinstance(node.bsdf, Bsdf):
            yield f"{path}.bsdf", node.bsdf
