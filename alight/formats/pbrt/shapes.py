"""``Shape`` -> shapes of the native format."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from alight.core.errors import SceneError, quote
from alight.formats.pbrt.context import Data
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.placed import Placed, angle_of, cut, described, mesh_of
from alight.formats.pbrt.shapes_of_3 import OF_3
from alight.formats.pbrt.strands import curve
from alight.formats.reading.packed import content_of
from alight.formats.reading.reach import OutOfReachError
from alight.meshes import ply, surfaces
from alight.meshes.loop import MOST_LEVELS, MOST_TRIANGLES, NotManifoldError, subdivide
from alight.scene.meshes import Geometry, checked
from alight.shapes.mesh import Mesh
from alight.shapes.strands import StrandShape

MOST_BYTES = 2**30
_LAYING = np.diag([1.0, 1.0, -1.0, 1.0])


def convert(placed: Placed) -> Data | Mesh | StrandShape | None:
    """Convert a shape; None after a problem."""
    kind = placed.p.directive.type
    if kind not in COVERED:
        placed.p.report.unknown(placed.p.directive, "shape", kind, COVERED, "left out")
        placed.p.forget()
        return None
    placed.p.ignore("hits do not depend on it", "shadowalpha", "discarddegenerateUVs")
    try:
        return COVERED[kind](placed)
    except SceneError as error:
        placed.p.report.errors_of(placed.p.directive, error)
        return None


def _flipped(is_flipped: bool) -> Data:
    return {"flip_normals": True} if is_flipped else {}


def _triangle_mesh(placed: Placed) -> Mesh | None:
    p = placed.p
    points, indices = p.table("P", "point"), p.indices("indices")
    normals, uvs = p.table("N", "normal"), _texture_coordinates(p)
    p.ignore("tangents follow the texture coordinates", "S")
    p.ignore("there are no textures by triangle", "faceIndices")
    _alpha(p)
    if points is None:
        placed.fail('needs "point3 P"')
        return None
    if indices is None and len(points) == 3:
        indices = np.arange(3)
    if indices is None or len(indices) % 3:
        placed.fail(f'needs "integer indices", three a triangle, got {_count(indices)}')
        return None
    keys = {"vertices": points, "faces": indices.reshape(-1, 3)}
    for name, table in (("normals", normals), ("uvs", uvs)):
        if table is not None and len(table) != len(points):
            placed.fail(f"must have as many {name} as points, {len(points)}, got {len(table)}")
        elif table is not None:
            keys[name] = table
    return mesh_of(placed, keys, placed.reverse)


def _texture_coordinates(p: Parameters) -> np.ndarray | None:
    for name in ("uv", "st"):
        if p.has(name):
            return p.table(name, "point2", "float", "vector2")
    return p.table("uv", "point2")


def _count(indices: np.ndarray | None) -> str:
    return "none" if indices is None else f"{len(indices)}"


def _alpha(p: Parameters) -> None:
    """The shape's opacity is read with its material."""
    p.find("alpha")


def _ply_mesh(placed: Placed) -> Mesh | None:
    p, context = placed.p, placed.context
    found = p.values("filename", "string", count=1)
    p.leave_out("meshes are not displaced", "displacement", "displacement.edgelength")
    p.ignore("meshes are not displaced", "edgelength", "displacement.uvscale")
    _alpha(p)
    if found is None:
        if not p.has("filename"):
            placed.fail('needs "string filename"')
        return None
    try:
        path = context.reach.find(found.values[0])
        key = (path, placed.reverse, placed.textured)
        if key not in context.loaded:
            arrays = context.meshes.read(_arrays_in, found.values[0], path)
            context.loaded[key] = described(placed, arrays, placed.reverse)
        return context.loaded[key]
    except OutOfReachError as error:
        p.report.lacks(found, error, "the shape is left out")
    except SceneError as error:
        for issue in error.issues:
            p.report.error(found, f"{quote(found.values[0])}: {issue.sentence}")
    return None


def _arrays_in(path: Path, name: str) -> Geometry:
    return checked(ply.read(content_of(path, MOST_BYTES))._replace(colors=None))


def _loop(placed: Placed) -> Mesh | None:
    p = placed.p
    points, indices = p.table("P", "point"), p.indices("indices")
    levels = p.integer("levels" if p.has("levels") else "nlevels", 3)
    p.text("scheme", "loop", ("loop",))
    _alpha(p)
    if points is None or indices is None or len(indices) % 3 or not len(indices):
        placed.fail(f'needs "point3 P" and "integer indices", three each, got {_count(indices)}')
        return None
    if not 0 <= levels <= MOST_LEVELS or len(indices) // 3 * 4**levels > MOST_TRIANGLES:
        text = f"levels must be in [0, {MOST_LEVELS}] and give at most {MOST_TRIANGLES} triangles"
        placed.fail(f"{text}, got {levels} of {len(indices) // 3}")
        return None
    if indices.max() >= len(points):
        placed.fail(f"indices must be in [0, {len(points) - 1}], got {indices.max()}")
        return None
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            vertices, normals, faces = subdivide(points, indices.reshape(-1, 3), levels)
    except NotManifoldError as error:
        placed.fail(str(error))
        return None
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)
    keys = {"vertices": vertices, "faces": faces, "normals": normals}
    # pbrt goes around vertices clockwise and so has the normals of these surfaces inside.
    return mesh_of(placed, keys, not placed.reverse)


def _bilinear_mesh(placed: Placed) -> Mesh | None:
    p = placed.p
    points, indices = p.table("P", "point"), p.indices("indices")
    normals, uvs = p.table("N", "normal"), p.table("uv", "point2")
    p.ignore("there are no textures by patch", "faceIndices")
    p.leave_out("patches shine evenly", "emissionfilename")
    _alpha(p)
    if points is None:
        placed.fail('needs "point3 P"')
        return None
    if indices is None and len(points) == 4:
        indices = np.arange(4)
    if indices is None or len(indices) % 4 or not len(indices):
        placed.fail(f'needs "integer indices", four a patch, got {_count(indices)}')
        return None
    if indices.max() >= len(points):
        placed.fail(f"indices must be in [0, {len(points) - 1}], got {indices.max()}")
        return None
    if any(table is not None and len(table) != len(points) for table in (normals, uvs)):
        placed.fail(f"must have as many N and uv as points, {len(points)}")
        return None
    square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    made = [
        surfaces.patch(points[c], square if uvs is None else uvs[c], _rows(normals, c))
        for c in indices.reshape(-1, 4)
    ]
    if not all(is_exact for _, is_exact in made):
        count = 2 * surfaces.ACROSS**2
        p.report.warn(p.directive, f"is not flat: {count} triangles a patch are taken")
    parts = [keys for keys, _ in made]
    if not all("normals" in part for part in parts):
        parts = [_with_normals(part) for part in parts] if len(parts) > 1 else parts
    return mesh_of(placed, surfaces.joined(parts), placed.reverse)


def _rows(table: np.ndarray | None, rows: np.ndarray) -> np.ndarray | None:
    return None if table is None else table[rows]


def _with_normals(part: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    if "normals" in part:
        return part
    a, b, c = part["vertices"][part["faces"][0]]
    normal = np.cross(b - a, c - a)
    length = float(np.linalg.norm(normal))
    return part | {"normals": np.tile(normal / (length or 1.0), (len(part["vertices"]), 1))}


def _sphere(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius = p.positive("radius", 1.0)
    ends = sorted([p.number("zmin", -radius), p.number("zmax", radius)])
    low, high = (min(max(end, -radius), radius) for end in ends)
    phi = angle_of(p)
    _alpha(p)
    if low >= high:
        placed.fail(f"zmin and zmax must leave something of it, got {ends[0]:g} and {ends[1]:g}")
        return None
    if low > -radius or high < radius or phi < 2.0 * math.pi:
        return cut(placed, surfaces.sphere(radius, low, high, phi), "is a part of a sphere")
    if placed.textured:
        # pbrt's v runs up from the south pole, ours down from the north pole.
        placed.matrix = placed.matrix @ _LAYING
    return {"type": "sphere", "radius": radius, **_flipped(placed.turned)}


def _disk(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius, height = p.positive("radius", 1.0), p.number("height", 0.0)
    inner, phi = p.number("innerradius", 0.0), angle_of(p)
    _alpha(p)
    if not 0.0 <= inner < radius:
        p.report.error(p.named["innerradius"], f"must be in [0, {radius:g}), got {inner:g}")
        return None
    if inner > 0.0 or phi < 2.0 * math.pi:
        return cut(placed, surfaces.disk(radius, inner, height, phi), "is a part of a disk")
    if placed.textured:
        why = "has texture coordinates of pbrt's"
        return cut(placed, surfaces.disk(radius, 0.0, height, phi), why)
    lifted = np.diag([radius, radius, 1.0, 1.0])
    lifted[2, 3] = height
    placed.matrix = placed.matrix @ lifted
    return {"type": "disk", **_flipped(placed.turned)}


def _cylinder(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius = p.positive("radius", 1.0)
    low, high = sorted([p.number("zmin", -1.0), p.number("zmax", 1.0)])
    phi = angle_of(p)
    _alpha(p)
    if low == high:
        placed.fail(f"zmin and zmax must differ, got {low:g} for both")
        return None
    if phi < 2.0 * math.pi:
        return cut(placed, surfaces.cylinder(radius, low, high, phi), "is a part of a cylinder")
    ends = {"p0": [0.0, 0.0, low], "p1": [0.0, 0.0, high]}
    return {"type": "cylinder", **ends, "radius": radius, **_flipped(placed.turned)}


#: Shapes of pbrt that alight has models for.
COVERED: dict[str, Callable[[Placed], Data | Mesh | StrandShape | None]] = {
    "bilinearmesh": _bilinear_mesh,
    "curve": curve,
    "cylinder": _cylinder,
    "disk": _disk,
    "loopsubdiv": _loop,
    "plymesh": _ply_mesh,
    "sphere": _sphere,
    "trianglemesh": _triangle_mesh,
    **OF_3,
}
