"""What was compiled of a scene, for its next render and for those of scenes made from it.

A scene and all that are made from it by `replaced`, `alight.changed` and `SceneManager` share one
memory, which holds the last compiled one. If the next scene differs by its camera alone, only the
table of the camera is made anew; trees of meshes are kept apart (`alight.accel.kept`). The memory
goes when the last of these scenes does, and is not copied to other processes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from alight.compiled.cameras import compile_camera, small_view
from alight.compiled.scene import CompiledScene, compile_scene
from alight.scene import FlatScene, Scene, flatten
from alight.scene.description import Node
from alight.scene.flatten import camera_part, content_parts, hash_of, place_camera


@dataclass(frozen=True)
class Compiled:
    """A scene that was compiled, and what it was compiled from.

    Attributes
    ----------
    scene : Scene
    layers : tuple of str
    flat : FlatScene
    compiled : CompiledScene
    parts : tuple of bytes
        What its hash is taken of, that of the camera among them.
    """

    scene: Scene
    layers: tuple[str, ...]
    flat: FlatScene
    compiled: CompiledScene
    parts: tuple[bytes, ...]


def compiled_of(
    scene: Scene, layers: tuple[str, ...], threads: int, lap: Callable[[str], None]
) -> tuple[FlatScene, CompiledScene]:
    """Flatten and compile a scene, or take what is known of it.

    Parameters
    ----------
    scene : Scene
    layers : tuple of str
        As of `compile_scene`.
    threads : int
    lap : callable
        Told the names of what has been done.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    last: Compiled | None = scene.memory.held
    found = None if last is None or last.layers != layers else _seen_anew(last, scene)
    if found is None:
        flat = flatten(scene)
        lap("load")
        parts = tuple(content_parts(flat))
        compiled = compile_scene(flat, hash_of(parts), aovs=layers, threads=threads)
        found = Compiled(scene, layers, flat, compiled, parts)
    lap("bvh" if found is not last else "load")
    scene.memory.held = found
    return found.flat, found.compiled


def _seen_anew(last: Compiled, scene: Scene) -> Compiled | None:
    """The last scene from the camera of another; None if more differs or something moves."""
    if not _differ_by_camera(last.scene, scene):
        return None
    if scene.camera == last.scene.camera:
        return last
    before = last.flat.camera
    if not isinstance(scene.camera, Node) or before.motion is not None:
        return None
    placed = place_camera(scene)
    # What moves is placed for the times of the shutter, and rays start in the camera's medium.
    alike = ("shutter", "medium", "type")
    if placed.motion is not None or any(
        getattr(placed.camera, name) != getattr(before.camera, name) for name in alike
    ):
        return None
    flat = replace(last.flat, camera=placed)
    number = last.parts.index(camera_part(before))
    parts = (*last.parts[:number], camera_part(placed), *last.parts[number + 1 :])
    camera = compile_camera(placed.camera, placed.to_world, flat.film.size)
    compiled = replace(
        last.compiled,
        tables=last.compiled.tables._replace(camera=camera),
        content_hash=hash_of(parts),
        small_view=last.compiled.small_view and small_view(placed, flat.film.size),
    )
    return Compiled(scene, last.layers, flat, compiled, parts)


def _differ_by_camera(a: Scene, b: Scene) -> bool:
    """Whether two scenes are the same but for their cameras; parts are compared as objects."""
    return a.source.folder == b.source.folder and all(
        _is_same(value, getattr(b, name)) for name, value in a if name != "camera"
    )


def _is_same(a: Any, b: Any) -> bool:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(value is b[name] for name, value in a.items())
    return a is b or (not isinstance(a, Mapping) and a == b)
