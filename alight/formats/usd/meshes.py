"""Meshes of UsdGeom, and its simple solids, -> our shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from alight.core.errors import unknown_name
from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.skins import Pose
from alight.formats.usd.stage import Stage
from alight.formats.usd.subdivision import smoothed
from alight.meshes.polygons import Polygons, Triangles, triangulated
from alight.meshes.triangles import MeshArrays, joined_sets
from alight.shapes.mesh import Mesh

Data = dict[str, Any]
#: Before the names of texture coordinates among the values of a mesh.
_UVS = "uvs "
#: Rotation that takes +z to the axis of a solid.
_AXES: dict[str, list[Data]] = {
    "X": [{"rotate": {"axis": "y", "angle": 90}}],
    "Y": [{"rotate": {"axis": "x", "angle": -90}}],
    "Z": [],
}
_AROUND = 64
#: Solids that become meshes, as they are called in files; the newer ones have two radii.
_REVOLVED = ("Cylinder", "Cone", "Capsule", "Cylinder_1", "Capsule_1")


def read_mesh(
    stage: Stage, prim: Any, sets: Sequence[str], pose: Pose | None = None
) -> Triangles | None:
    """Read a mesh.

    Parameters
    ----------
    stage : Stage
    prim : Usd.Prim
        A UsdGeom.Mesh.
    sets : sequence of str
        Names of the texture coordinates that are wanted.
    pose : Pose, optional
        What moves it.

    Returns
    -------
    Triangles or None
        With the values "normals", "colors" and "uvs NAME" that there are; None after a problem, or
        without faces.
    """
    polygons = _polygons(stage, prim, sets)
    if polygons is None:
        return None
    if pose is not None:
        polygons = _posed(polygons, pose)
    mesh = UsdGeom.Mesh(prim)
    return triangulated(smoothed(stage, mesh, polygons))


def arrays_of(triangles: Triangles, sets: Sequence[str], chosen: Any = None) -> MeshArrays:
    """The arrays of all triangles, or of the chosen ones, with these texture coordinates."""
    faces = triangles.faces if chosen is None else triangles.faces[chosen]
    used, index = np.unique(faces, return_inverse=True)
    arrays = {name: table[used].astype(np.float32) for name, table in triangles.values.items()}
    uvs, more_uvs = joined_sets([arrays.get(_UVS + name) for name in sets])
    return MeshArrays(
        vertices=triangles.vertices[used].astype(np.float32),
        faces=index.reshape(-1, 3).astype(np.int32),
        normals=arrays.get("normals"),
        colors=arrays.get("colors"),
        uvs=uvs,
        more_uvs=more_uvs,
    )


def has_set(triangles: Triangles, name: str) -> bool:
    """Whether there are texture coordinates of this name."""
    return _UVS + name in triangles.values


def say_what_is_lacking(
    stage: Stage, prim: Any, asked: Sequence[str], triangles: Triangles
) -> None:
    """Tell which of the texture coordinates that a material asks for a mesh does not have."""
    lacking = [name for name in asked if not has_set(triangles, name)]
    if lacking:
        instead = "others" if len(lacking) < len(asked) else "barycentric ones"
        stage.report.approximate(
            f"{prim.GetPath()}: it lacks the coordinates {' and '.join(lacking)}, which its "
            f"material asks for; {instead} are taken"
        )


def _polygons(stage: Stage, prim: Any, sets: Sequence[str]) -> Polygons | None:
    mesh = UsdGeom.Mesh(prim)
    points = np.array(stage.value(mesh.GetPointsAttr(), []), np.float64).reshape(-1, 3)
    counts = np.array(stage.value(mesh.GetFaceVertexCountsAttr(), []), np.int64)
    corners = np.array(stage.value(mesh.GetFaceVertexIndicesAttr(), []), np.int64)
    problem = _problem_of(points, counts, corners)
    if problem:
        stage.problem(prim, problem)
        return None
    keep = counts >= 3
    holes = np.array(stage.value(mesh.GetHoleIndicesAttr(), []), np.int64)
    keep[holes[(holes >= 0) & (holes < len(keep))]] = False
    if not keep.any():
        stage.report.drop(f"{prim.GetPath()}: a mesh without faces")
        return None
    values = _values(stage, prim, sets, points, counts, corners)
    kept = np.repeat(keep, counts)
    origin = np.flatnonzero(keep)
    counts, corners = counts[keep], corners[kept]
    values = {name: table[kept] for name, table in values.items()}
    if stage.value(mesh.GetOrientationAttr()) == UsdGeom.Tokens.leftHanded:
        order = _reversed_corners(counts)
        corners, values = corners[order], {name: table[order] for name, table in values.items()}
    return Polygons(points, counts, corners, values, origin)


def _posed(polygons: Polygons, pose: Pose) -> Polygons:
    values = dict(polygons.values)
    if "normals" in values:
        values["normals"] = pose.turned(polygons.corners, values["normals"])
    return replace(polygons, points=pose.moved(polygons.points), values=values)


def _problem_of(points: Any, counts: Any, corners: Any) -> str | None:
    if (counts < 0).any():
        return f"faceVertexCounts must not be negative, got {int(counts.min())}"
    if int(counts.sum()) != len(corners):
        return f"faceVertexIndices must have {int(counts.sum())} numbers, got {len(corners)}"
    if len(corners) and (corners.min() < 0 or corners.max() >= len(points)):
        wrong = int(corners.min() if corners.min() < 0 else corners.max())
        return f"faceVertexIndices must be points, 0 to {len(points) - 1}, got {wrong}"
    if not (np.abs(points) <= 1e15).all():
        return "points must be finite and at most 1e15"
    return None


def _reversed_corners(counts: Any) -> Any:
    """Order of the corners with every face turned around, its first corner first."""
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    step = np.arange(int(counts.sum())) - starts
    return starts + (np.repeat(counts, counts) - step) % np.repeat(counts, counts)


def _values(
    stage: Stage, prim: Any, sets: Sequence[str], points: Any, counts: Any, corners: Any
) -> dict[str, Any]:
    """What the mesh says of its corners: normals, texture coordinates, colours."""
    api, values = UsdGeom.PrimvarsAPI(prim), {}
    wanted = {_UVS + name: (api.FindPrimvarWithInheritance(name), 2) for name in sets}
    wanted["colors"] = (api.FindPrimvarWithInheritance("displayColor"), 3)
    normals = api.FindPrimvarWithInheritance("normals")
    if normals and normals.HasValue():
        wanted["normals"] = (normals, 3)
    for name, (primvar, width) in wanted.items():
        if not primvar or not primvar.HasValue():
            continue
        table = stage.table(primvar)
        if table is None:
            continue
        rows = _by_corners(table, primvar.GetInterpolation(), len(points), counts, corners)
        if rows is None or rows.shape[1] != width:
            text = f"{primvar.GetName()} has {len(table)} values, which do not fit"
            stage.report.approximate(f"{prim.GetPath()}: {text}: left out")
            continue
        if name == "colors":
            if primvar.GetInterpolation() == UsdGeom.Tokens.constant:
                continue
            rows = np.clip(rows, 0.0, 1.0)
        values[name] = rows
    if "normals" not in values:
        mesh = UsdGeom.Mesh(prim)
        table = stage.value(mesh.GetNormalsAttr())
        if table is not None and len(table):
            how = mesh.GetNormalsInterpolation()
            rows = _by_corners(table, how, len(points), counts, corners)
            if rows is None:
                text = f"normals has {len(table)} values, which do not fit"
                stage.report.approximate(f"{prim.GetPath()}: {text}: left out")
            else:
                values["normals"] = rows
    return values


def _by_corners(table: Any, how: str, points: int, counts: Any, corners: Any) -> Any:
    """Rows for all corners, or None if there are too few or too many."""
    if table is None:
        return None
    rows = np.array(table, np.float64)
    if rows.ndim != 2 or not np.isfinite(rows).all():
        return None
    tokens = UsdGeom.Tokens
    if how == tokens.faceVarying and len(rows) == len(corners):
        return rows
    if how in (tokens.vertex, tokens.varying) and len(rows) == points:
        return rows[corners]
    if how == tokens.uniform and len(rows) == len(counts):
        return np.repeat(rows, counts, axis=0)
    if how == tokens.constant and len(rows) == 1:
        return np.repeat(rows, len(corners), axis=0)
    return None


def solid(stage: Stage, prim: Any) -> tuple[Data, list[Data]] | None:
    """Shape of a simple solid and the steps that place it; None for what is none."""
    if prim.IsA(UsdGeom.Sphere):
        radius = float(stage.value(UsdGeom.Sphere(prim).GetRadiusAttr(), 1.0))
        return {"type": "sphere", "radius": radius}, []
    if prim.IsA(UsdGeom.Cube):
        size = float(stage.value(UsdGeom.Cube(prim).GetSizeAttr(), 2.0))
        return {"type": "cube"}, [{"scale": 0.5 * size}]
    if prim.IsA(UsdGeom.Plane):
        plane = UsdGeom.Plane(prim)
        width = float(stage.value(plane.GetWidthAttr(), 2.0))
        length = float(stage.value(plane.GetLengthAttr(), 2.0))
        axis = _axis(stage, plane)
        return {"type": "rectangle"}, [{"scale": [width / 2, length / 2, 1.0]}, *_AXES[axis]]
    name = str(prim.GetTypeName())
    if name not in _REVOLVED:
        return None
    gprim, kind = getattr(UsdGeom, name)(prim), name.partition("_")[0]
    if kind == name:
        bottom = top = float(stage.value(gprim.GetRadiusAttr(), 1.0))
    else:
        bottom = float(stage.value(gprim.GetRadiusBottomAttr(), 1.0))
        top = float(stage.value(gprim.GetRadiusTopAttr(), 1.0))
    height = float(stage.value(gprim.GetHeightAttr(), 2.0))
    axis = _axis(stage, gprim)
    shape = _turned(*_profile(kind, bottom, top, height))
    stage.report.approximate(f"{prim.GetPath()}: a {kind.lower()} became a mesh")
    return {"__mesh__": shape}, list(_AXES[axis])


def _axis(stage: Stage, solid: Any) -> str:
    axis = stage.value(solid.GetAxisAttr(), "Z")
    if axis in _AXES:
        return axis
    stage.problem(solid.GetPrim(), unknown_name("axis", axis, _AXES, listed_as="axes"))
    return "Z"


def _profile(kind: str, bottom: float, top: float, height: float) -> tuple[Any, Any]:
    """Radii and heights of a solid of revolution, from the bottom to the top."""
    half = 0.5 * height
    if kind == "Cylinder":
        return [0.0, bottom, top, 0.0], [-half, -half, half, half]
    if kind == "Cone":
        return [0.0, bottom, 0.0], [-half, -half, half]
    # Caps are parts of balls that touch the sides, which lean by this.
    tilt = math.atan2(bottom - top, height) if height > 0.0 else 0.0
    radii, heights = [], []
    steps = _AROUND // 4 + 1
    for radius, middle, angles in (
        (bottom, -half, np.linspace(-0.5 * np.pi, tilt, steps)),
        (top, half, np.linspace(tilt, 0.5 * np.pi, steps)),
    ):
        ball = radius / math.cos(tilt)
        radii.append(ball * np.cos(angles))
        heights.append(middle + ball * (np.sin(angles) - math.sin(tilt)))
    # A cosine of a quarter of a turn is not quite 0.
    radii[0][0] = radii[1][-1] = 0.0
    return np.concatenate(radii), np.concatenate(heights)


def _turned(radii: Any, heights: Any) -> Mesh:
    """Mesh of a profile turned around +z."""
    rings = len(radii)
    angle = np.arange(_AROUND) * (2.0 * np.pi / _AROUND)
    points = np.stack(
        [
            np.outer(radii, np.cos(angle)),
            np.outer(radii, np.sin(angle)),
            np.repeat(np.asarray(heights)[:, None], _AROUND, axis=1),
        ],
        axis=-1,
    ).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(_AROUND), indexing="ij")
    a, b = i * _AROUND + j, i * _AROUND + (j + 1) % _AROUND
    quads = np.stack([a, b, b + _AROUND, a + _AROUND], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    corners = points[faces]
    sides = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return Mesh(vertices=points.astype(np.float32), faces=faces[area > 0.0].astype(np.int32))
