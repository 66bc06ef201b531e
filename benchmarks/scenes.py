"""The scenes of the render benchmarks, for alight and for Mitsuba 3.

cornell             the Cornell box, rectangles as rectangles (Mitsuba: ``mi.cornell_box()``)
cornell-triangles   the same box, every rectangle given as a mesh of two triangles
blob                the box without its blocks, with a displaced icosphere of 1.3 M triangles

All have a box filter and the path integrator with depth 8 and roulette from depth 5.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import gettempdir
from typing import TYPE_CHECKING, Any

import meshes
import numpy as np

if TYPE_CHECKING:
    from alight import Scene
    from alight.scene.description import Node

NAMES = ("cornell", "cornell-triangles", "blob")


def alight_scene(name: str, size: int, sampler: str | None = None, subdivisions: int = 8) -> Scene:
    """Build a scene for alight.

    Parameters
    ----------
    name : str
        One of `NAMES`.
    size : int, pixels
        Width and height.
    sampler : str, optional
        Type of the sampler; alight's default otherwise.
    subdivisions : int
        Of the icosphere of ``blob``; each quadruples its triangles.
    """
    import alight
    from alight.core.registry import specs
    from alight.scene.description import Node
    from alight.shapes.mesh import Mesh

    scene = alight.load("cornell-box")
    nodes = dict(scene.nodes)
    if name == "cornell-triangles":
        nodes = {key: _as_triangles(node) for key, node in nodes.items()}
    if name == "blob":
        nodes = {key: node for key, node in nodes.items() if "-box" not in key}
        vertices, faces = meshes.blob(subdivisions)
        nodes["blob"] = Node(shape=Mesh(vertices=vertices, faces=faces), bsdf="white")
    changes: dict[str, Any] = {"nodes": nodes, "film": scene.film.replaced(size=(size, size))}
    if sampler is not None:
        changes["sampler"] = specs("samplers")[sampler]()
    return scene.replaced(**changes)


def _as_triangles(node: Node) -> Node:
    """Replace a rectangle by two triangles with the same corners and normal."""
    from alight.shapes.mesh import Mesh

    corners = node.transform.apply_point([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    mesh = Mesh(vertices=np.asarray(corners, np.float32), faces=[(0, 1, 2), (0, 2, 3)])
    return type(node)(shape=mesh, bsdf=node.bsdf, light=node.light)


def mitsuba_scene(mi: Any, name: str, size: int, sampler: str, subdivisions: int = 8) -> Any:
    """Build a scene for Mitsuba; ``cornell-triangles`` is its ``cornell``."""
    contents = mi.cornell_box()
    contents["sensor"]["film"] = {
        "type": "hdrfilm",
        "width": size,
        "height": size,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    contents["sensor"]["sampler"] = {"type": sampler, "sample_count": 64}
    contents["integrator"] = {"type": "path", "max_depth": 8, "rr_depth": 5}
    if name == "blob":
        del contents["small-box"], contents["large-box"]
        contents["blob"] = {
            "type": "ply",
            "filename": str(_blob_file(mi, subdivisions)),
            "face_normals": True,
            "bsdf": {"type": "ref", "id": "white"},
        }
    return mi.load_dict(contents)


def _blob_file(mi: Any, subdivisions: int) -> Path:
    """Write the blob as PLY, once."""
    path = Path(gettempdir()) / f"alight-benchmark-blob-{subdivisions}.ply"
    if not path.exists():
        vertices, faces = meshes.blob(subdivisions)
        mesh = mi.Mesh("blob", len(vertices), len(faces))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = vertices.ravel()
        parameters["faces"] = faces.astype(np.uint32).ravel()
        parameters.update()
        mesh.write_ply(str(path))
    return path
