"""Objects of other packages as scenes: what a program holds, without a file between.

An object is known by the module of its class, or of a class that it is derived from; no package is
imported to find out, and none but the object's own to read it. Each reader gives `Piece` after
`Piece` of surface, which `assembly` puts together with light and a camera.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from alight.core.errors import Issue, SceneError, show_value
from alight.formats.objects import arrays, open3d_objects, trimesh_objects, vtk_objects
from alight.formats.objects.assembly import assembled
from alight.formats.objects.pieces import Content, Look
from alight.formats.scenes.parsed import Parsed

#: Package -> its reader, and the axis that points up where the package has a convention.
READERS: dict[str, tuple[Callable[[Any, Look], Content], str]] = {
    "trimesh": (trimesh_objects.read, "y"),
    "pyvista": (vtk_objects.read, "z"),
    "vtkmodules": (vtk_objects.read, "z"),
    "open3d": (open3d_objects.read, "y"),
    "numpy": (arrays.read, "y"),
}


def parse_object(value: Any, look: Look) -> Parsed:
    """Read an object of another package.

    Parameters
    ----------
    value : object
        Of a package in `READERS`, or a tuple or list of arrays (`arrays`).
    look : Look
        How it shall be shown.

    Raises
    ------
    SceneError
        If nothing is known about such objects, or this one shows no surface.
    """
    name = name_of(value)
    package = package_of(value)
    if package is None:
        text = (
            f"cannot load {show_value(value)}: give a path, the name of a built-in scene, a "
            "dictionary of the native format, arrays (vertices, faces), or an object of "
            "trimesh, PyVista, VTK or Open3D"
        )
        raise SceneError([Issue("scene", text)])
    read, up = READERS[package]
    try:
        content = read(value, look)
    except SceneError as error:
        raise SceneError([Issue(i.path, i.message, name) for i in error.issues]) from None
    return assembled(content, look, name, look.up or up)


def package_of(value: Any) -> str | None:
    """The package of `READERS` that an object comes from; None if it is none of them."""
    if isinstance(value, tuple | list):
        return "numpy" if value and all(map(_is_table, value)) else None
    found = next((p for p in _packages(type(value)) if p in READERS), None)
    return None if found == "numpy" and not isinstance(value, np.ndarray) else found


def name_of(value: Any) -> str:
    """What messages call an object: its package and class."""
    if isinstance(value, tuple | list | np.ndarray):
        return "arrays"
    kind = type(value)
    return f"{kind.__module__.partition('.')[0]}.{kind.__name__}"


def _is_table(value: Any) -> bool:
    return "numpy" in _packages(type(value)) or isinstance(value, list | tuple)


def _packages(kind: type) -> Iterable[str]:
    return (base.__module__.partition(".")[0] for base in kind.__mro__)
