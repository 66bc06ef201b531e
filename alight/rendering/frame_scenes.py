"""The scene of an animation's frame: at its time, or from where a turntable has its camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from alight.formats.loading import load_again
from alight.formats.scenes.made_up import as_made_up_for
from alight.scene import Node, Scene, SceneManager
from alight.scene.flatten import FlatScene, place_camera
from alight.scene.keyframes import Keyframes
from alight.scene.nodes import all_nodes
from alight.scene.transform import matrix, rotate, translate
from alight.shapes.model import SHAPES


def at_time(scene: Scene, number: int, fps: float) -> Scene:
    """The scene while the camera's shutter is open, which counts in frames."""
    named = scene.camera
    camera = SceneManager(scene).get(named) if isinstance(named, str) else named
    assert isinstance(camera, Node)
    assert camera.camera is not None
    opens, closes = camera.camera.shutter
    shutter = ((number + opens) / fps, (number + closes) / fps)
    node = camera.replaced(camera=camera.camera.replaced(shutter=shutter))
    if isinstance(named, str):
        return SceneManager(scene).replace(named, node).scene.made_from(scene)
    return scene.replaced(camera=node).made_from(scene)


def shown_from(opened: Scene) -> Scene:
    """The scene when its file's own animation begins, or at the time that it was opened at."""
    how = opened.source.recipe
    assert how is not None
    return opened if how.at is not None else load_again(replace(how, at=0.0))


def played(origin: Scene, seconds: float) -> Scene:
    """The scene so long after `origin`, as its file's own animation has it then.

    Parameters
    ----------
    origin : Scene
        Of `shown_from`.
    seconds : float
        At or after 0.

    Raises
    ------
    SceneError
        If the file is no longer there, or wrong by now.
    """
    how = origin.source.recipe
    assert how is not None
    assert how.at is not None
    if seconds == 0.0:
        return origin
    return as_made_up_for(origin, load_again(replace(how, at=how.at + seconds)))


def is_still(scene: Scene) -> bool:
    """Whether no node has keyframes, so that the scene is the same at any time."""
    nodes = [node for _, node in all_nodes(scene)]
    if isinstance(scene.camera, Node):
        nodes.append(scene.camera)
    return not any(isinstance(node.transform, Keyframes) for node in nodes)


def turned(scene: Scene, pivot: np.ndarray, angle: float) -> Scene:
    """The scene with its camera turned about the vertical through a point, metres; degrees."""
    about = translate(*pivot).matrix @ rotate("y", angle).matrix
    about = about @ translate(*-pivot).matrix
    seen = place_camera(scene)
    camera = Node(transform=matrix(about @ seen.to_world), camera=seen.camera)
    return scene.replaced(camera=camera).made_from(scene)


def middle(flat: FlatScene) -> np.ndarray:
    """The middle of the box around all meshes and shapes with bounds, metres; else the origin.

    Lamps stand around what is looked at: they count only where there is nothing else.
    """
    corners: list[np.ndarray] = []
    for placed in [s for s in flat.shapes if s.light is None] or flat.shapes:
        if placed.geometry >= 0:
            points = flat.geometries[placed.geometry].vertices
            box = np.array([points.min(axis=0), points.max(axis=0)])
            mesh = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
            corners.append(mesh @ placed.to_world[:3, :3].T + placed.to_world[:3, 3])
            continue
        for part, place in placed.shape.parts() or [(placed.shape, np.eye(4))]:
            model = SHAPES[part.type_name()]
            if model.bounds is not None and model.pack is not None:
                ends = model.bounds(model.pack(part, placed.to_world @ place))
                corners += [end.reshape(-1, 3) for end in ends]
    if not corners:
        return np.zeros(3)
    every = np.concatenate(corners)
    return 0.5 * (every.min(axis=0) + every.max(axis=0))
