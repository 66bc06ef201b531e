"""Shapes that shine: their area, and a second surface for those that shine from both sides."""

from __future__ import annotations

import numpy as np

from alight.formats.pbrt.context import Data
from alight.formats.pbrt.transforms import steps, translation
from alight.formats.scenes.lamps import area_across, area_of_ball, area_of_mantle, area_of_mesh
from alight.meshes.normals import vertex_normals
from alight.shapes.mesh import Mesh
from alight.shapes.strand_rows import area as area_of_rows
from alight.shapes.strand_rows import rows_of
from alight.shapes.strands import StrandShape

#: Distance between the two surfaces of a light with two sides, of its size.
GAP = 1e-5


def area_of(shape: Data | Mesh | StrandShape, matrix: np.ndarray) -> float:
    """Area in m^2 of a shape that a matrix moves."""
    if isinstance(shape, Mesh):
        return area_of_mesh(shape, matrix)
    if isinstance(shape, StrandShape):
        return area_of_rows(rows_of(shape, matrix))
    if shape["type"] == "sphere":
        return area_of_ball(matrix, shape["radius"])
    if shape["type"] == "disk":
        return np.pi * area_across(matrix)
    return area_of_mantle(matrix, shape["radius"], shape["p1"][2] - shape["p0"][2])


def has_one_side(shape: Data | Mesh | StrandShape) -> bool:
    """Whether only one side can be seen from outside."""
    if isinstance(shape, Mesh):
        return False
    return isinstance(shape, StrandShape) or shape["type"] == "sphere"


def back_of(node: Data, matrix: np.ndarray) -> Data:
    """A node with the same surface, just behind itself and turned around."""
    shape = node["shape"]
    if isinstance(shape, Mesh):
        return {**node, "shape": _mesh_behind(shape)}
    turned = {key: value for key, value in shape.items() if key != "flip_normals"}
    sign = -1.0 if "flip_normals" in shape else 1.0
    if sign > 0.0:
        turned["flip_normals"] = True
    if shape["type"] == "cylinder":
        turned["radius"] = shape["radius"] * (1.0 - sign * GAP)
        return {**node, "shape": turned}
    # A disk, of radius 1 before its matrix.
    size = float(np.linalg.norm(matrix[:3, 0]) / np.linalg.norm(matrix[:3, 2]))
    moved = matrix @ translation(0.0, 0.0, -sign * GAP * size)
    return {**node, "shape": turned, "transform": steps(moved)}


def _mesh_behind(shape: Mesh) -> Mesh:
    vertices, faces = _arrays(shape)
    normals = vertex_normals(vertices, faces) if shape.normals is None else shape.normals
    sign = -1.0 if shape.flip_normals else 1.0
    moved = vertices - np.float32(sign * GAP * np.ptp(vertices, axis=0).max()) * normals
    return shape.replaced(vertices=moved, flip_normals=not shape.flip_normals)


def _arrays(shape: Mesh) -> tuple[np.ndarray, np.ndarray]:
    assert shape.vertices is not None
    assert shape.faces is not None
    return shape.vertices, shape.faces
