"""Writes scenes in the native format, with files for what is large; `loading` reads them."""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from alight.core.arguments import expect, expect_path, known_words
from alight.core.errors import Issue, SceneError, quote
from alight.formats.scenes.made_up import without_floor
from alight.media.volumes import holds_volume
from alight.meshes import ply
from alight.meshes.triangles import MeshArrays
from alight.scene import plain_yaml
from alight.scene.builtin.pictures import is_builtin
from alight.scene.description import Scene
from alight.scene.dump import dump_scene
from alight.scene.flatten import flatten
from alight.scene.meshes import arrays_of
from alight.scene.strands import NAMES
from alight.shapes.mesh import Mesh
from alight.shapes.strands import StrandShape

SUFFIXES = (".yaml", ".yml", ".json")
#: What scenes can be written to.
WRITTEN = (*SUFFIXES, ".glb")
# Meshes with more vertices, and pictures with more texels, go into files beside a saved scene.
MOST_INLINE_VERTICES, MOST_INLINE_TEXELS = 100, 64


def dumps(scene: Scene) -> str:
    """Write a scene as text in the native format, meshes included.

    `loads` gives an equal scene back, bit for bit.
    """
    return plain_yaml.write(dump_scene(scene))


@known_words()
def save(scene: Scene, path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Write a scene to a file in the native format, or as far as glTF can hold it.

    Parameters
    ----------
    scene : Scene
        Mesh arrays of more than 100 vertices are written to PLY files beside it, pictures of more
        than 64 texels to NPY files. Files that it names are copied there, unless they lie there
        or below already: so the scene reads nothing outside of its own folder.
    path : str or path
        Where to; ends in ``.yaml``, ``.yml`` or ``.json``, or in ``.glb``.

    Returns
    -------
    tuple of str
        What a file of glTF does not hold, or not quite, a line each; empty for the native format.

    Raises
    ------
    SceneError
        If the name has another ending.
    OSError
        If a file cannot be written.
    """
    expect(scene, Scene, "scene", "a scene; film.save(path) writes a film")
    target = Path(expect_path(path))
    if target.suffix.lower() not in WRITTEN:
        kinds = ", ".join(WRITTEN)
        raise SceneError([Issue("", f"must end in {kinds}, got {quote(target.name)}", str(target))])
    if target.suffix.lower() == ".glb":
        from alight.formats.gltf.write import write

        return tuple(write(flatten(without_floor(scene)), target))
    writer = _FileWriter(target, scene.source.folder)
    data = dump_scene(scene, writer)
    is_json = target.suffix.lower() == ".json"
    text = json.dumps(data, indent=1) + "\n" if is_json else plain_yaml.write(data)
    # A reader never sees half a file: write beside, then rename.
    partial = target.with_name(target.name + ".partial")
    try:
        partial.write_text(text, "utf-8")
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
    return ()


class _FileWriter:
    """Writes large meshes and pictures to files, and keeps what is in files already."""

    def __init__(self, target: Path, folder: Path | None) -> None:
        self.target = target
        self.folder = folder or Path()
        self.names: dict[object, str] = {}

    def __call__(self, spec: Any, key_path: str) -> Any:
        if spec.file is not None:
            if is_builtin(spec.file):
                return spec
            return spec.replaced(file=self.kept(spec.file))
        if isinstance(spec, Mesh):
            return self.mesh(spec, key_path)
        if isinstance(spec, StrandShape):
            return self.strands(spec, key_path)
        return self.volume(spec, key_path) if holds_volume(spec) else self.picture(spec, key_path)

    def kept(self, file: str) -> str:
        """Name a file as seen from the target; one from elsewhere is copied beside it."""
        path, folder = (self.folder / file).resolve(), self.target.parent.resolve()
        if path.is_relative_to(folder):
            return path.relative_to(folder).as_posix()
        if path not in self.names:
            name = self.names[path] = self.new_name(path.stem, path.suffix)
            shutil.copyfile(path, self.target.with_name(name))
        return self.names[path]

    def volume(self, spec: Any, key_path: str) -> Any:
        volume = spec.values
        if volume is None or volume.cells <= MOST_INLINE_TEXELS:
            return spec
        if volume not in self.names:
            name = self.names[volume] = self.new_name(key_path, ".npy")
            np.save(self.target.with_name(name), volume.values[..., 0], allow_pickle=False)
        return spec.replaced(file=self.names[volume], values=None)

    def mesh(self, mesh: Mesh, key_path: str) -> Mesh:
        assert mesh.vertices is not None
        assert mesh.faces is not None
        if len(mesh.vertices) <= MOST_INLINE_VERTICES:
            return mesh
        if id(mesh) not in self.names:
            name = self.names[id(mesh)] = self.new_name(key_path, ".ply")
            ply.save(self.target.with_name(name), arrays_of(mesh))
        arrays_gone = dict.fromkeys(MeshArrays._fields)
        return mesh.replaced(file=self.names[id(mesh)], **arrays_gone)

    def strands(self, spec: StrandShape, key_path: str) -> StrandShape:
        assert spec.points is not None
        assert spec.radii is not None
        if len(spec.points) <= MOST_INLINE_VERTICES:
            return spec
        if id(spec) not in self.names:
            name = self.names[id(spec)] = self.new_name(key_path, ".npz")
            counts = {} if spec.counts is None else {"counts": spec.counts}
            place = self.target.with_name(name)
            np.savez_compressed(place, points=spec.points, radii=spec.radii, **counts)
        nothing = dict.fromkeys(NAMES)
        return spec.replaced(file=self.names[id(spec)], **nothing)

    def picture(self, spec: Any, key_path: str) -> Any:
        image = spec.pixels
        if image is None or image.width * image.height <= MOST_INLINE_TEXELS:
            return spec
        if image not in self.names:
            name = self.names[image] = self.new_name(key_path, ".npy")
            np.save(self.target.with_name(name), image.whole, allow_pickle=False)
        return spec.replaced(file=self.names[image], pixels=None)

    def new_name(self, key_path: str, suffix: str) -> str:
        """Name a file after the scene and the place in it, or what it was called."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", key_path).strip("-")
        return f"{self.target.stem}-{len(self.names)}-{plain[:60]}{suffix}"
