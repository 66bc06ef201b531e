"""PLY and STL files opened by themselves: one mesh, with light and a camera around it.

STL files come from machines whose z is up, so they are turned; PLY files are taken as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.formats.glow import Glow
from alight.formats.model_scene import model_scene
from alight.formats.parsed import Parsed
from alight.formats.reach import Reach
from alight.formats.report import Report
from alight.formats.surfaces import plain_surface
from alight.formats.surroundings import Bounds
from alight.meshes import ply, stl
from alight.meshes.triangles import MeshArrays
from alight.scene import transform
from alight.scene.meshes import mesh_of

_UPRIGHT = {"rotate": {"axis": "x", "angle": -90.0}}


def parse_ply(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read a PLY file as a scene; see `alight.formats.obj_scene.parse`."""
    return _parse(ply.read, data, name, reach or Reach(), z_is_up=False)


def parse_stl(data: bytes, name: str, reach: Reach | None = None) -> Parsed:
    """Read an STL file as a scene; see `alight.formats.obj_scene.parse`."""
    return _parse(stl.read, data, name, reach or Reach(), z_is_up=True)


def _parse(
    read: Callable[[bytes], MeshArrays], data: bytes, name: str, reach: Reach, *, z_is_up: bool
) -> Parsed:
    try:
        mesh = mesh_of(read(data))
    except SceneError as error:
        raise SceneError([Issue("", issue.sentence, name) for issue in error.issues]) from None
    report, bounds = Report(), Bounds()
    report.count("meshes")
    to_world = transform.rotate("x", -90.0).matrix if z_is_up else np.eye(4)
    bounds.add(mesh.vertices, to_world)
    node: dict[str, Any] = {"shape": mesh, "bsdf": "surface"}
    if z_is_up:
        node["transform"] = _UPRIGHT
        report.approximate("STL files do not say which way is up: z is taken")
    surface = plain_surface(mesh.colors is not None)
    tables = {"bsdfs": {"surface": surface.bsdf}, "nodes": {"mesh": node}}
    return model_scene(tables, {"": name}, report, bounds, Glow(reach.files))
