"""A scene is checked once: what it was checked by stays with it.

Scenes never change; those that are made from one are checked anew.
"""

from __future__ import annotations

from alight.core.errors import SceneError
from alight.scene.description import Scene
from alight.scene.files import Files
from alight.scene.validation import find_problems


def checked_files(scene: Scene) -> Files:
    """The files of a scene that is right; it is looked at once.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    files = scene.checked
    if files is None:
        files = scene.source.files()
        issues = find_problems(scene, files)
        if issues:
            raise SceneError([scene.source.located(issue) for issue in issues])
        scene.mark_checked(files)
    return files
