"""All that is legal but suspicious of a scene, for those who do not render it."""

from __future__ import annotations

from alight.compiled.scene import compile_scene
from alight.scene import Scene, flatten


def warnings_of_scene(scene: Scene) -> tuple[str, ...]:
    """`CompiledScene.warnings` of a scene, for which nothing is built or traced.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    return compile_scene(flatten(scene), structure="none").warnings
