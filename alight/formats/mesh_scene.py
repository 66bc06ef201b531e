"""PLY and STL files opened by themselves: one mesh, with light and a camera around it.

STL files come from machines whose z is up, so they are turned; PLY files are taken as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.formats.materials.surfaces import plain_surface
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.formats.scenes.model_scene import Data, ModelScene
from alight.formats.scenes.parsed import Parsed
from alight.meshes import ply, stl
from alight.meshes.triangles import MeshArrays
from alight.scene import transform
from alight.scene.meshes import mesh_of

_UPRIGHT = {"rotate": {"axis": "x", "angle": -90.0}}
_COLORS = {"red", "green", "blue", "alpha", "r", "g", "b", "a"}
_LISTS = {"vertex_indices", "vertex_index"}
#: Columns that `ply.read` knows, of the elements that it knows.
_READ = {
    "vertex": {"x", "y", "z"}.union(*ply.MORE_UVS, *chain(*ply.NAMES.values())),
    "face": _LISTS,
    "tristrips": _LISTS,
}


def parse_ply(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read a PLY file as a scene; see `alight.formats.obj.scene.parse`."""
    return _parse(ply.read, data, name, reach or Reach(), z_is_up=False)


def parse_stl(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read an STL file as a scene; see `alight.formats.obj.scene.parse`."""
    return _parse(stl.read, data, name, reach or Reach(), z_is_up=True)


def _parse(
    read: Callable[[bytes], MeshArrays], data: bytes, name: str, reach: Reach, *, z_is_up: bool
) -> Parsed:
    try:
        mesh = mesh_of(read(data))
    except SceneError as error:
        raise SceneError([Issue("", issue.sentence, name) for issue in error.issues]) from None
    model = ModelScene(Report(), reach, {"": name})
    model.report.count("meshes")
    if read is ply.read:
        _say_what_is_left_out(data, model.report)
    surface = plain_surface(mesh.colors is not None)
    node: Data = {"shape": mesh, "bsdf": model.name_of("surface", surface, "surface")}
    to_world = np.eye(4)
    if z_is_up:
        to_world, node["transform"] = transform.rotate("x", -90.0).matrix, _UPRIGHT
        model.report.approximate("STL files do not say which way is up: z is taken")
    assert mesh.vertices is not None
    model.bounds.add(mesh.vertices, to_world)
    model.nodes["mesh"] = node
    return model.finish()


def _say_what_is_left_out(data: bytes, report: Report) -> None:
    """Name the columns of a PLY file that nothing is made of."""
    _, elements, _ = ply.parse_header(data)
    for element in elements:
        names = {column.name for column in element.properties if element.count}
        left = sorted(names - _READ.get(element.name, set()))
        colors = [name for name in left if name in _COLORS]
        if colors:
            shown = f"{', '.join(colors)} of element {element.name}"
            report.approximate(f"{shown}: left out; colours are read of vertices, without opacity")
        if rest := [name for name in left if name not in _COLORS]:
            report.drop(f"{', '.join(rest)} of element {element.name}: not read")
