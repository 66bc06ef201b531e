"""A live scene that is edited: which scene to show, and its state for the page."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any

from alight.core.errors import SceneError
from alight.core.registry import specs
from alight.formats.loading import changed
from alight.scene import Scene
from alight.view import protocol
from alight.view.editing import (
    History,
    Step,
    WrongValueError,
    edited,
    focused,
    is_of_camera,
    offered,
    transform_of,
    with_step,
)
from alight.view.live import LiveScene
from alight.view.pose import FOCUS
from alight.view.protocol import RefusedError
from alight.view.tree import items_of


class Editor:
    """Edits what a `LiveScene` shows.

    Parameters
    ----------
    scene : Scene
    live : LiveScene
        It shows that scene.

    Attributes
    ----------
    camera : str
        Path of the camera that is looked through, or "" for the scene's own.
    cameras : tuple of str
        All of them.
    version : int
        Counts the edits, so that a page knows when to ask anew.
    """

    def __init__(self, scene: Scene, live: LiveScene) -> None:
        self._scene, self._own, self.live = scene, scene.camera, live
        self.history, self.version, self.camera = History(), 0, ""
        nodes = [path for path, _, node in scene.walk() if node.camera is not None]
        self.cameras = ("", *nodes)
        # Several browsers may edit at once.
        self._lock = threading.Lock()

    @property
    def scene(self) -> Scene:
        """The newest scene, its camera as it is now."""
        pose = self.live.wish.pose
        if pose is None:
            return self._scene
        return self._scene.replaced(camera=pose.node).from_source(self._scene.source)

    def apply(self, event: protocol.Event) -> dict[str, Any] | None:
        """Do what the browser asks of the scene.

        Raises
        ------
        RefusedError
            For what makes no sense here.
        """
        with self._lock:
            match event:
                case protocol.AskTree():
                    return self._tree()
                case protocol.AskFields(item):
                    return self._fields(item)
                case protocol.Edit(item, path, value):
                    return self._edit(
                        path, lambda scene: edited(scene, item, path, value), lambda _: value
                    )
                case protocol.AddStep(item, step):
                    path = f"{item}.transform"
                    return self._edit(
                        path, lambda scene: with_step(scene, item, step),
                        lambda scene: transform_of(scene, item),
                    )  # fmt: skip
                case protocol.Region(x, y, width, height):
                    left, top, _, _ = self.live.movable.window
                    return self._crop((left + x, top + y, width, height))
                case protocol.Whole():
                    return self._crop(None)
                case protocol.Undo():
                    if step := self.history.back():
                        self._show(step.before, step.path)
                case protocol.Redo():
                    if step := self.history.forth():
                        self._show(step.after, step.path)
                case protocol.ChooseCamera(name):
                    self._look_through(name)
        return None

    def state(self) -> dict[str, Any]:
        """What the page knows at any time."""
        return {
            "cameras": list(self.cameras), "camera": self.camera, "version": self.version,
            "undo": bool(self.history.done), "redo": bool(self.history.undone),
            "prepares": self.live.prepares, "is_part": self._scene.film.crop is not None,
        }  # fmt: skip

    def focus(self, x: int, y: int) -> dict[str, Any]:
        """Put the plane of focus through what a pixel of the window shows.

        Returns
        -------
        dict
            ``distance``, in the camera's own space, or ``why`` it stays where it is.
        """
        pose = self.live.pose
        if not pose.has_focus:
            kinds = [name for name, spec in specs("cameras").items() if FOCUS in spec.model_fields]
            text = f"this camera is sharp everywhere; give it the type {' or '.join(sorted(kinds))}"
            return {"why": f"{text.replace('_', ' ')}, under Scene, camera"}
        point = self.live.seen_at(x, y)
        if point is None:
            return {"why": "there is nothing to focus on"}
        distance = pose.depth_of(point)
        with self._lock:
            answer = self._edit(
                f"camera.{FOCUS}", lambda scene: focused(scene, distance), lambda _: ""
            )
        self.live.turn_about(point)
        return {"why": answer["why"]} if "why" in answer else {"distance": distance}

    def assignments(self) -> list[str]:
        """Edits since the scene was read, but for those of its camera, as words of ``--set``."""
        done = self.history.done
        return [step.assignment for step in done if not is_of_camera(step.path)]

    def _edit(
        self, path: str, change: Callable[[Scene], Scene], value_of: Callable[[Scene], str]
    ) -> dict[str, Any]:
        """Make an edit, or say what is wrong with it; the answer is for the one that edits.

        `change` makes it, `value_of` gives what was assigned, as JSON, from the scene after it.
        """
        # The keys of the camera are those of where it is now.
        before = self.scene if is_of_camera(path) else self._scene
        try:
            after = change(before)
            self.live.change(after, keeps_camera=not is_of_camera(path))
        except (WrongValueError, SceneError) as error:
            return {"is": "wrong", "path": path, "why": str(error)}
        self.history.add(Step(path, before, after, f"{path}={value_of(after)}"))
        self._scene = after
        self.version += 1
        return {"is": "edited", "path": path}

    def _crop(self, crop: tuple[int, int, int, int] | None) -> dict[str, Any]:
        """Render a part of the picture only, or all of it again; its pixels stay the same."""

        def cropped(scene: Scene) -> Scene:
            film = scene.film.replaced(crop=crop)
            return scene.replaced(film=film).from_source(scene.source)

        return self._edit("film.crop", cropped, lambda _: json.dumps(crop))

    def _show(self, scene: Scene, path: str) -> None:
        """Go to a scene of the history; the camera moves only if it was what was edited."""
        if not is_of_camera(path):
            scene = scene.replaced(camera=self._scene.camera).from_source(scene.source)
        self.live.change(scene, keeps_camera=not is_of_camera(path))
        self._scene = scene
        self.version += 1

    def _look_through(self, name: str) -> None:
        if name not in self.cameras:
            raise RefusedError("camera: the scene has none of this name")
        if name:
            scene = changed(self._scene, [f'camera="{name}"'])
        else:
            scene = self._scene.replaced(camera=self._own).from_source(self._scene.source)
        self.live.change(scene, keeps_camera=False)
        self._scene, self.camera = scene, name
        self.version += 1

    def _tree(self) -> dict[str, Any]:
        items = [[i.path, i.name, i.group, i.type] for i in items_of(self.scene)]
        return {"is": "tree", "version": self.version, "items": items}

    def _fields(self, item: str) -> dict[str, Any]:
        fields = [field.plain() for field in offered(self.scene, item)]
        return {"is": "fields", "item": item, "version": self.version, "fields": fields}
