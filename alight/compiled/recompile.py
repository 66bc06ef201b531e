"""What was compiled of a scene, for its next render and for those of scenes made from it.

A scene and all that are made from it by `replaced`, `alight.changed` and `SceneManager` share one
memory, which holds the last compiled one. If the next scene differs by its camera alone, only the
table of the camera is made anew (`Compiled.seen_from`); else what costs most and has not changed is
taken from the last (`alight.compiled.kept`). Trees of meshes stay with their arrays
(`alight.accel.kept`). The memory goes when the last of these scenes does, and is not copied to
other processes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from alight.compiled.cameras import compile_camera, small_view
from alight.compiled.kept import Kept
from alight.compiled.rendering_space import origin_for, shifted
from alight.compiled.scene import CompiledScene, compile_scene
from alight.core.registry import versions
from alight.scene import FlatScene, Scene, flatten
from alight.scene.description import Node
from alight.scene.flatten import PlacedCamera, place_camera
from alight.scene.hashing import camera_part, content_parts, described, hash_of


@dataclass(frozen=True)
class Compiled:
    """A scene that was compiled, and what it was compiled from.

    Attributes
    ----------
    scene : Scene
    layers : tuple of str
        Further ones, as of `compile_scene`.
    flat : FlatScene
    compiled : CompiledScene
    parts : tuple of bytes
        What its hash is taken of, that of the camera among them.
    kept : Kept
        For the next compilation.
    """

    scene: Scene
    layers: tuple[str, ...]
    flat: FlatScene
    compiled: CompiledScene
    parts: tuple[bytes, ...]
    kept: Kept

    @classmethod
    def of(
        cls, scene: Scene, flat: FlatScene, layers: tuple[str, ...], threads: int, kept: Kept
    ) -> Compiled:
        """Compile a flat scene."""
        parts = tuple(content_parts(flat))
        compiled = compile_scene(flat, hash_of(parts), aovs=layers, threads=threads, kept=kept)
        return cls(scene, layers, flat, compiled, parts, kept)

    def seen_from(self, placed: PlacedCamera) -> Compiled:
        """The same with another camera, as it would be compiled.

        Neither camera may move, and both must be of one type and in one medium, with one shutter:
        the kernels are the same then, and so is the place of all that moves. A camera that changes
        the rendering space, far from where it was, has all shapes compiled anew.
        """
        flat = replace(self.flat, camera=placed)
        origin = origin_for(flat, self.compiled.ball)
        if not np.array_equal(origin, self.compiled.origin):
            return self.of(self.scene, flat, self.layers, 1, self.kept)
        number = self.parts.index(camera_part(self.flat.camera))
        parts = (*self.parts[:number], camera_part(placed), *self.parts[number + 1 :])
        near = shifted(placed, origin)
        camera = compile_camera(near.camera, near.to_world, flat.film.size, origin)
        compiled = replace(
            self.compiled,
            tables=self.compiled.tables._replace(camera=camera),
            content_hash=hash_of(parts),
            small_view=self.compiled.small_view and small_view(near, flat.film.size),
        )
        return replace(self, flat=flat, compiled=compiled, parts=parts)


def compiled_of(
    scene: Scene,
    layers: tuple[str, ...],
    threads: int,
    lap: Callable[[str], None] = lambda name: None,
) -> Compiled:
    """Flatten and compile a scene, or take what is known of it.

    Parameters
    ----------
    scene : Scene
    layers : tuple of str
        As of `compile_scene`.
    threads : int
    lap : callable, optional
        Told the names of what has been done.

    Raises
    ------
    SceneError
        With every problem of the scene.
    """
    memory = scene.memory
    # Renders of several threads take turns: what is kept belongs to the last compilation.
    with memory.lock:
        last: Compiled | None = memory.held
        found = None if last is None or last.layers != layers else _from_last(last, scene)
        if found is None:
            flat = flatten(scene, last.flat if last and _name_the_same(last.scene, scene) else None)
            lap("load")
            kept = Kept() if last is None else last.kept
            found = Compiled.of(scene, flat, layers, threads, kept)
        lap("bvh" if found is not last else "load")
        memory.held = found
    return found


def _from_last(last: Compiled, scene: Scene) -> Compiled | None:
    """The last scene from the camera of another; None if more differs or something moves."""
    # A model that a script has registered anew has other kernels under its name.
    known = last.compiled.program.registered
    if known != versions(described(last.flat)) or not _differ_by_camera(last.scene, scene):
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
    return replace(last.seen_from(placed), scene=scene)


def _name_the_same(a: Scene, b: Scene) -> bool:
    """Whether all that nodes name is the same in two scenes, but for materials."""
    names = ("prototypes", "textures", "media", "medium")
    same = all(_is_same(getattr(a, name), getattr(b, name)) for name in names)
    return same and a.source.folder == b.source.folder


def _differ_by_camera(a: Scene, b: Scene) -> bool:
    """Whether two scenes are the same but for their cameras; parts are compared as objects."""
    return a.source.folder == b.source.folder and all(
        _is_same(value, getattr(b, name)) for name, value in a if name != "camera"
    )


def _is_same(a: Any, b: Any) -> bool:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(value is b[name] for name, value in a.items())
    return a is b or (not isinstance(a, Mapping) and a == b)
