"""`Scene` -> plain data, the inverse of `alight.scene.build`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from alight.bsdfs.measured.measurement import Measurement
from alight.core.errors import is_at_or_below
from alight.core.spec import Spec
from alight.media.volumes import Volume, holds_volume
from alight.scene.build import FORMAT_VERSION
from alight.scene.description import Node, Scene
from alight.scene.steps import dump_transform
from alight.scene.transform import Transform
from alight.shapes.arrays import ArrayShape
from alight.textures.images import Image, holds_image
from alight.textures.uv import UvTransform

#: Gives the description to write instead of one that holds arrays or names a file.
FileWriter = Callable[[Any, str], Any]


def dump_scene(
    scene: Scene, write_file: FileWriter | None = None, full: bool = False, edited: str = ""
) -> dict[str, Any]:
    """Write a scene as plain data.

    Parameters
    ----------
    scene : Scene
        What to write.
    write_file : callable, optional
        Receives each mesh, and each description that holds a picture, with its key path; returns
        what to write in its place, for instance one that names a file.
    full : bool, default False
        Write fields at their defaults too, and leave arrays of meshes and pictures as they are.
        Otherwise they become lists.
    edited : str, optional
        Key path of what is to be changed: descriptions that do not hold it, and dictionaries of
        them, stay as they are.

    Returns
    -------
    dict
        Dictionaries, lists, texts and numbers.
    """
    data: dict[str, Any] = {"alight": FORMAT_VERSION}
    writer = _Writer(write_file, full, edited)
    for name, value in scene:
        if isinstance(value, Node) and name == "camera":
            kept = edited and not is_at_or_below(edited, name)
            data[name] = value if kept else writer.camera(value)
        elif full or not (value is None or value == {}):
            data[name] = writer.value(value, name)
    if data["film"] == {}:
        del data["film"]
    return data


class _Writer:
    """Turns descriptions into plain data, one method per kind of value."""

    def __init__(self, write_file: FileWriter | None, full: bool, edited: str) -> None:
        self.write_file = write_file
        self.full = full
        self.edited = edited

    def value(self, value: Any, path: str) -> Any:
        # First: of a large scene nearly everything stays as it is.
        if self.edited and isinstance(value, Spec | dict) and not is_at_or_below(self.edited, path):
            return value
        if isinstance(value, Spec):
            holds_arrays = isinstance(value, ArrayShape)
            # Arrays that are written to files, and files that lie elsewhere.
            holds_file = holds_arrays or holds_image(value) or holds_volume(value)
            holds_file = holds_file or getattr(value, "file", None) is not None
            if self.write_file is not None and holds_file:
                value = self.write_file(value, path)
            return self.spec(value, path)
        if isinstance(value, Transform):
            return dump_transform(value)
        if isinstance(value, dict):
            return {name: self.value(item, f"{path}.{name}") for name, item in value.items()}
        if isinstance(value, Image | Measurement | UvTransform | Volume):
            return value if self.full else value.plain()
        if isinstance(value, np.ndarray):
            return value if self.full else dump_array(value)
        if isinstance(value, tuple):
            return [self.value(item, f"{path}[{i}]") for i, item in enumerate(value)]
        return value

    def spec(self, spec: Spec, path: str) -> dict[str, Any]:
        data: dict[str, Any] = {}
        for name, value in spec:
            default = type(spec).model_fields[name].default
            if self.full or name == "type" or not _equal(value, default):
                data[name] = self.value(value, f"{path}.{name}")
        # The type first: it decides what the other keys mean.
        return {"type": data.pop("type"), **data} if "type" in data else data

    def camera(self, node: Node) -> dict[str, Any]:
        assert node.camera is not None
        data = self.spec(node.camera, "camera")
        if self.full or node.transform != Transform():
            data["transform"] = dump_transform(node.transform)
        return data


def _equal(value: Any, default: Any) -> bool:
    if isinstance(value, np.ndarray) or isinstance(default, np.ndarray):
        return False
    # -0.0 == 0.0 and 1 == True: only what is written alike may be left out.
    return value == default and repr(value) == repr(default)


def dump_array(array: np.ndarray) -> list[Any]:
    """Write an array as lists, each float32 with the fewest digits that read back to it."""
    if np.issubdtype(array.dtype, np.integer):
        return array.tolist()
    if array.ndim == 1:
        return [float(str(number)) for number in array]
    if array.ndim == 3:
        return [dump_array(table) for table in array]
    return [[float(str(number)) for number in row] for row in array]
