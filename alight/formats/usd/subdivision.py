"""Subdivision surfaces of UsdGeom: by Catmull and Clark, or by Loop.

Source: Pixar, OpenUSD documentation, UsdGeomMesh, "Subdivision surface attributes".
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.stage import Stage
from alight.meshes.loop import NotManifoldError, subdivide
from alight.meshes.polygons import Polygons, subdivided, vertex_normals

#: Levels of subdivision, fewer for meshes that would have more faces than this.
LEVELS, MOST_FACES = 2, 1_000_000
_INFINITE = 10.0


def smoothed(stage: Stage, mesh: Any, polygons: Polygons) -> Polygons:
    """The mesh by its scheme: subdivided, or as it is.

    Parameters
    ----------
    stage : Stage
    mesh : UsdGeom.Mesh
    polygons : Polygons
        Its control mesh.
    """
    scheme = stage.value(mesh.GetSubdivisionSchemeAttr(), UsdGeom.Tokens.catmullClark)
    if scheme == UsdGeom.Tokens.catmullClark:
        return _refined(stage, mesh, polygons)
    if scheme == UsdGeom.Tokens.loop:
        return _by_loop(stage, mesh, polygons)
    return polygons


def _levels(polygons: Polygons) -> int:
    levels = LEVELS
    while levels and len(polygons.corners) * 4 ** (levels - 1) > MOST_FACES:
        levels -= 1
    return levels


def _say_how(stage: Stage, mesh: Any, levels: int, whose: str) -> None:
    if levels == LEVELS:
        text = f"subdivision surfaces are shown after {levels} steps of {whose}"
    else:
        text = f"{mesh.GetPath()}: so large that it is subdivided {levels} times only"
    stage.report.approximate(text)


def _by_loop(stage: Stage, mesh: Any, polygons: Polygons) -> Polygons:
    """Subdivide triangles, on to the limit surface, with its normals."""
    creases, _ = _creases(stage, mesh)
    corners = stage.value(mesh.GetCornerIndicesAttr(), [])
    problem = ""
    if (polygons.counts != 3).any():
        problem = "has faces that are no triangles"
    elif len(creases) or len(corners):
        problem = "has creases or corners"
    levels, found = _levels(polygons), None
    if not problem:
        try:
            found = subdivide(polygons.points, polygons.corners.reshape(-1, 3), levels)
        except NotManifoldError:
            # What it says is of a finer mesh, whose vertices the file does not have.
            problem = "is not the mesh of a surface, with at most two triangles at an edge"
    if found is None:
        text = f"Loop's scheme, and it {problem}: its control mesh is shown"
        stage.report.approximate(f"{mesh.GetPath()}: {text}")
        return polygons
    points, normals, faces = found
    _say_how(stage, mesh, levels, "Loop's, corners of borders rounded")
    values = {name: table for name, table in polygons.values.items() if name != "normals"}
    for _ in range(levels):
        values = {name: _quartered(table) for name, table in values.items()}
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    if (length[faces] > 0.0).all():
        values["normals"] = (normals / np.where(length > 0.0, length, 1.0))[faces.ravel()]
    counts = np.full(len(faces), 3, np.int64)
    return Polygons(points, counts, faces.ravel(), values, np.repeat(polygons.origin, 4**levels))


def _quartered(table: Any) -> Any:
    """Values of the corners of triangles -> those of their quarters, in the order of Loop's."""
    a, b, c = table.reshape(-1, 3, table.shape[1]).transpose(1, 0, 2)
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    quarters = np.stack([np.stack(part, axis=1) for part in parts], axis=1)
    return quarters.reshape(-1, table.shape[1])


def _refined(stage: Stage, mesh: Any, polygons: Polygons) -> Polygons:
    """Subdivide, with normals of the result; normals of the file are not those of the limit."""
    levels = _levels(polygons)
    creases, sharpness = _creases(stage, mesh)
    pinned = np.array(stage.value(mesh.GetCornerIndicesAttr(), []), np.int64)
    pinned = pinned[(pinned >= 0) & (pinned < len(polygons.points))]
    values = {name: table for name, table in polygons.values.items() if name != "normals"}
    start = Polygons(
        polygons.points, polygons.counts, polygons.corners, values, polygons.origin,
        creases, sharpness, pinned,
    )  # fmt: skip
    fine = subdivided(start, levels)
    _say_how(stage, mesh, levels, "Catmull and Clark's")
    smooth = not len(creases)
    if smooth:
        fine.values["normals"] = vertex_normals(fine)[fine.corners]
    return fine


def _creases(stage: Stage, mesh: Any) -> tuple[Any, Any]:
    """Edges of the chains of creases, and their sharpness."""
    lengths = np.array(stage.value(mesh.GetCreaseLengthsAttr(), []), np.int64)
    indices = np.array(stage.value(mesh.GetCreaseIndicesAttr(), []), np.int64)
    given = np.array(stage.value(mesh.GetCreaseSharpnessesAttr(), []), np.float64)
    edges, sharpness, start = [], [], 0
    by_edge = len(given) == int(np.maximum(lengths - 1, 0).sum()) != len(lengths)
    for chain, length in enumerate(lengths):
        part = indices[start : start + length]
        start += length
        for pair in itertools.pairwise(part):
            number = len(edges) if by_edge else chain
            edges.append(pair)
            sharpness.append(min(given[number], _INFINITE) if number < len(given) else _INFINITE)
    return np.array(edges, np.int64).reshape(-1, 2), np.array(sharpness, np.float64)
