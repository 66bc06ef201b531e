"""What a reader of a foreign file made up, after the user has changed the scene.

A studio is placed where a file has no light, and a camera where it has none. The user may replace
either when he loads the file: then they are no longer reported, and what was chosen to fit them
goes with them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from alight.formats.geometry.bounds import Bounds
from alight.formats.scenes.surroundings import STUDIO, is_floor, studio_rotation
from alight.scene.description import Node, Scene
from alight.scene.flatten import place_camera
from alight.scene.transform import look_at


def fitted(before: Scene, after: Scene, framed: Bounds | None) -> Scene:
    """Fit what was made up to a scene that was changed.

    Parameters
    ----------
    before, after : Scene
        As the file was read, and with all changes; valid.
    framed : Bounds, optional
        What the camera must see, where the file has none of its own.

    Returns
    -------
    Scene
        An automatic camera is placed for the size that the picture has now; the studio is turned
        to the camera that was chosen; another picture in its place stands as it is. The studio's
        floor goes with the studio, and where lights are hidden: who does not want to see the
        studio wants the model alone. Remarks that no longer hold are gone.
    """
    source = _without_what_is_gone(before, after)
    replaced = _value(before, "environment.file") == STUDIO != _value(after, "environment.file")
    if replaced or _value(after, "integrator.hide_emitters"):
        after = without_floor(after)
    if framed is not None and before.camera == after.camera:
        assert isinstance(after.camera, Node)
        look = look_at(*framed.viewpoint(after.film.size))
        after = after.replaced(camera=after.camera.replaced(transform=look))
    return _turned(before, after).from_source(source)


def as_made_up_for(first: Scene, later: Scene) -> Scene:
    """Keep what was made up for the first frame of an animation: it would jump with each pose.

    Whether there is light enough is that frame's to say, too.

    Parameters
    ----------
    first, later : Scene
        Of one file, at two times.
    """
    held = _made_up(first) | _made_up(later)
    parts: dict[str, Any] = {}
    if "camera.transform" in held:
        parts["camera"] = first.camera
    if "environment.file" in held:
        floors = {name: node for name, node in first.nodes.items() if is_floor(node.bsdf)}
        parts["environment"] = first.environment
        parts["nodes"] = {**without_floor(later).nodes, **floors}
    remarks, gone = later.source.remarks, set(_made_up(later).values())
    warnings = (*_made_up(first).values(), *(t for t in remarks.warnings if t not in gone))
    remarks = replace(remarks, warnings=warnings, assumed=first.source.remarks.assumed)
    return later.replaced(**parts).from_source(replace(later.source, remarks=remarks))


def _made_up(scene: Scene) -> dict[str, str]:
    """Key path -> warning, of what is still as the reader chose it."""
    remarks = scene.source.remarks
    return {key: text for key, text in remarks.assumed if text in remarks.warnings}


def without_floor(scene: Scene) -> Scene:
    """The scene without the studio's floor, which is no part of a model."""
    nodes = {name: node for name, node in scene.nodes.items() if not is_floor(node.bsdf)}
    if len(nodes) == len(scene.nodes):
        return scene
    return scene.replaced(nodes=nodes).from_source(scene.source)


def _without_what_is_gone(before: Scene, after: Scene) -> Any:
    remarks = after.source.remarks
    gone = {text for key, text in remarks.assumed if _value(before, key) != _value(after, key)}
    warnings = tuple(text for text in remarks.warnings if text not in gone)
    return replace(after.source, remarks=replace(remarks, warnings=warnings))


def _value(scene: Scene, key: str) -> Any:
    value: Any = scene
    for name in key.split("."):
        value = getattr(value, name, None)
    return value


def _turned(before: Scene, after: Scene) -> Scene:
    """The rotation of the surroundings, unless the user has chosen it."""
    light, was = after.environment, before.environment
    if light is None or _value(before, "environment.file") != STUDIO:
        return after
    rotate = getattr(light, "rotate", None)
    if rotate is None or rotate != getattr(was, "rotate", None):
        return after
    if getattr(light, "file", None) != STUDIO:
        return after.replaced(environment=light.replaced(rotate=0.0))
    if after.camera == before.camera or not isinstance(after.camera, str):
        return after
    rotate = studio_rotation(place_camera(after).to_world)
    return after.replaced(environment=light.replaced(rotate=rotate))
