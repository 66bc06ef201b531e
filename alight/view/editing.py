"""Edits of a scene: a value is checked where it is entered, and everything can be undone.

An edit is an assignment as for ``--set``, but only of what the page offers (`alight.view.tree`):
a message cannot make the server read a file.
"""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass, field, replace
from typing import Any

from alight.core.errors import SceneError
from alight.formats.loading import changed
from alight.scene import Node, Scene, SceneManager
from alight.scene.keyframes import Keyframes
from alight.scene.nodes import all_nodes
from alight.scene.steps import dump_transform
from alight.view.pose import FOCUS
from alight.view.tree import NEUTRAL, Field, fields_of, items_of

#: Edits that can be undone.
MOST_UNDONE = 200

#: Seconds in which further edits of the same value count as one.
SAME_EDIT = 1.0


class WrongValueError(ValueError):
    """A value that a scene cannot have; its text says why, without the key."""


@dataclass(frozen=True)
class Step:
    """The scene before and after an edit of `path`; `assignment` is the same edit for ``--set``."""

    path: str
    before: Scene
    after: Scene
    assignment: str = ""


@dataclass
class History:
    """Edits that were made, and those that were undone."""

    done: list[Step] = field(default_factory=list)
    undone: list[Step] = field(default_factory=list)
    _last: float = -math.inf

    def add(self, step: Step) -> None:
        """Note an edit; one of the same value right after the last joins it."""
        now = time.monotonic()
        if self.done and self.done[-1].path == step.path and now - self._last < SAME_EDIT:
            step = replace(step, before=self.done.pop().before)
        self._last = now
        self.done = [*self.done, step][-MOST_UNDONE:]
        self.undone.clear()

    def back(self) -> Step | None:
        """Take back the last edit; None if there is none."""
        if not self.done:
            return None
        self._last = -math.inf
        self.undone.append(self.done.pop())
        return self.undone[-1]

    def forth(self) -> Step | None:
        """Make again what was taken back last; None if there is none."""
        if not self.undone:
            return None
        self.done.append(self.undone.pop())
        return self.done[-1]


def is_of_camera(path: str) -> bool:
    """Whether an edit changes the scene's own camera."""
    return path.startswith("camera.")


def edited(scene: Scene, item: str, path: str, text: str) -> Scene:
    """Change a value.

    Parameters
    ----------
    scene : Scene
    item, path : str
        Of an `alight.view.tree.Item` and one of its fields.
    text : str
        The value, as JSON.

    Raises
    ------
    WrongValueError
        If there is no such field, or the value does not fit; the scene stays as it is.
    """
    found = next((one for one in offered(scene, item) if one.path == path), None)
    if found is None or found.kind == "told":
        raise WrongValueError("cannot be changed here")
    return _assigned(scene, path, _value(found, text))


def with_step(scene: Scene, item: str, step: str) -> Scene:
    """Append a step to the transform of a node: one that changes nothing yet.

    Raises
    ------
    WrongValueError
        If there is no such node or step, or it moves.
    """
    node = next((node for path, node in all_nodes(scene) if path == item), None)
    if node is None or step not in NEUTRAL:
        raise WrongValueError(f"there is no such step; steps: {', '.join(NEUTRAL)}")
    if isinstance(node.transform, Keyframes):
        raise WrongValueError("a transform with keyframes has no steps")
    data = dump_transform(node.transform)
    steps = data if isinstance(data, list) else [data]
    return _assigned(scene, f"{item}.transform", [*steps, {step: NEUTRAL[step]}])


def transform_of(scene: Scene, item: str) -> str:
    """The transform of a node, as JSON."""
    node = next(node for path, node in all_nodes(scene) if path == item)
    return json.dumps(dump_transform(node.transform))


def focused(scene: Scene, distance: float) -> Scene:
    """Put the plane of focus of the scene's camera at a distance, in the camera's own space."""
    held = scene.camera
    node = SceneManager(scene).get(held) if isinstance(held, str) else held
    assert isinstance(node, Node)
    assert node.camera is not None
    node = node.replaced(camera=node.camera.replaced(**{FOCUS: distance}))
    if isinstance(held, str):
        return SceneManager(scene).replace(held, node).scene.made_from(scene)
    return scene.replaced(camera=node).made_from(scene)


def offered(scene: Scene, item: str) -> list[Field]:
    """The fields of a part that is listed; of anything else none."""
    return fields_of(scene, item) if any(one.path == item for one in items_of(scene)) else []


def _assigned(scene: Scene, path: str, value: Any) -> Scene:
    try:
        return changed(scene, [f"{path}={json.dumps(value)}"])
    except SceneError as error:
        issues = [i.message if i.path == path else i.sentence for i in error.issues]
        raise WrongValueError("\n".join(issues)) from None


def _value(field: Field, text: str) -> Any:
    """Read a value; only its kind is checked here, the rest by the description itself."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        raise WrongValueError("this is no JSON") from None
    kind = field.kind
    if kind == "choice" and value not in field.choices:
        raise WrongValueError(f"must be one of {', '.join(field.choices)}")
    if kind == "truth" and not isinstance(value, bool):
        raise WrongValueError("must be true or false")
    if kind in ("number", "whole") and not _is_number(value):
        raise WrongValueError("must be a number")
    if kind in ("color", "vector"):
        count = len(field.value)
        if not isinstance(value, list) or len(value) != count or not all(map(_is_number, value)):
            raise WrongValueError(f"must be {count} numbers")
    return value


def _is_number(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
