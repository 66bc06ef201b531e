"""The scene of a render, loaded and changed as the options say that all entries share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from alight.formats import load
from alight.formats.loading import changed
from alight.formats.scenes.made_up import fitted
from alight.options.plugins import load_plugins
from alight.options.scene import SceneOptions
from alight.scene import Scene


def scene_of(scene: Any, options: SceneOptions) -> Scene:
    """Load a scene after the models that scripts register, and change what the options say.

    Parameters
    ----------
    scene : Scene, path, name of a built-in scene, dict or object
    options : SceneOptions

    Raises
    ------
    AlightError
        For a scene, a script or an option that is wrong.
    """
    load_plugins(options.plugins)
    changes = options.assignments()
    if not isinstance(scene, Scene):
        return load(
            scene,
            changes,
            definitions=options.definitions,
            lenient=options.lenient,
            root=options.root,
            variant=options.variant,
            scene_name=options.scene_name,
            animation=options.animation,
            at=options.at,
        )
    options.check_reads()
    if not changes:
        return scene
    made, recipe = fitted(scene, changed(scene, changes), None), scene.source.recipe
    if recipe is None:
        return made
    recipe = replace(recipe, changes=(*recipe.changes, *changes))
    return made.from_source(replace(made.source, recipe=recipe))
