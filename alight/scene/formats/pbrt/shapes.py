"""``Shape`` -> shapes of the native format.

pbrt takes the side of a surface from the numbers of its parameters: spheres, disks and cylinders
are turned inside out by a mirror, meshes are not; ``ReverseOrientation`` turns both.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from alight.core.errors import Issue, SceneError, quote
from alight.scene.formats import ply, surfaces
from alight.scene.formats.loop import MOST_LEVELS, MOST_TRIANGLES, NotManifoldError, subdivide
from alight.scene.formats.packed import content_of
from alight.scene.formats.pbrt.context import Context, Data
from alight.scene.formats.pbrt.parameters import Parameters
from alight.scene.formats.reach import OutOfReachError
from alight.scene.formats.triangles import MeshArrays
from alight.scene.meshes import mesh_problem
from alight.shapes.mesh import Mesh

MOST_BYTES = 2**30
_LAYING = np.diag([1.0, 1.0, -1.0, 1.0])


@dataclass
class Placed:
    """Where a shape stands, and what decides its form.

    Attributes
    ----------
    context : Context
    p : Parameters
        Of the shape.
    matrix : (4, 4) float64
        To the world, or to the object that it is part of; changed by some shapes.
    reverse : bool
        Whether ``ReverseOrientation`` counts.
    mirrored : bool
        Whether the matrix turns a right hand into a left one.
    textured : bool
        Whether its material or light can tell texture coordinates.
    """

    context: Context
    p: Parameters
    matrix: np.ndarray
    reverse: bool
    mirrored: bool
    textured: bool
    extra: Data = field(default_factory=dict)

    @property
    def turned(self) -> bool:
        """Whether a shape with a formula is inside out."""
        return self.reverse != self.mirrored

    def fail(self, message: str) -> None:
        """Report a problem of the shape."""
        self.p.report.error(self.p.directive, message)


def convert(placed: Placed) -> Data | Mesh | None:
    """Convert a shape; None after a problem."""
    kind = placed.p.directive.type
    if kind not in COVERED:
        placed.p.report.unknown(placed.p.directive, "shape", kind, COVERED, "left out")
        placed.p.forget()
        return None
    placed.p.ignore("hits do not depend on it", "shadowalpha")
    try:
        return COVERED[kind](placed)
    except SceneError as error:
        placed.p.report.errors_of(placed.p.directive, error)
        return None


def _flipped(is_flipped: bool) -> Data:
    return {"flip_normals": True} if is_flipped else {}


def _mesh(placed: Placed, keys: dict[str, np.ndarray], flip: bool) -> Mesh | None:
    """A mesh of arrays that may be wrong."""
    normals, uvs = keys.get("normals"), keys.get("uvs")
    with np.errstate(over="ignore", invalid="ignore"):
        arrays = MeshArrays(
            np.asarray(keys["vertices"], np.float32),
            np.asarray(keys["faces"], np.int32),
            None if normals is None else np.asarray(normals, np.float32),
            None if uvs is None else np.asarray(uvs, np.float32),
        )
    problem = mesh_problem(arrays)
    if problem:
        raise SceneError([Issue(*problem)])
    return _described(placed, arrays, flip)


def _described(placed: Placed, arrays: MeshArrays, flip: bool) -> Mesh:
    keys = {"vertices": arrays.vertices, "faces": arrays.faces}
    if arrays.normals is not None:
        keys["normals"] = arrays.normals
        keys["faces"] = surfaces.facing_normals(arrays.vertices, arrays.faces, arrays.normals)
    if arrays.uvs is not None:
        keys["uvs"] = arrays.uvs
    elif placed.textured:
        keys = surfaces.own_corners(keys)
    return Mesh(**keys, flip_normals=flip)


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
    return _mesh(placed, keys, placed.reverse)


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
            arrays = ply.read(content_of(path, MOST_BYTES))._replace(colors=None)
            problem = mesh_problem(arrays)
            if problem:
                raise SceneError([Issue(*problem)])
            context.loaded[key] = _described(placed, arrays, placed.reverse)
        return context.loaded[key]
    except OutOfReachError as error:
        p.report.error(found, str(error))
    except SceneError as error:
        for issue in error.issues:
            p.report.error(found, f"{quote(found.values[0])}: {issue.path} {issue.message}")
    return None


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
    return _mesh(placed, keys, not placed.reverse)


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
        p.report.approximated(p.directive, f"is not flat: {count} triangles a patch are taken")
    parts = [keys for keys, _ in made]
    if not all("normals" in part for part in parts):
        parts = [_with_normals(part) for part in parts] if len(parts) > 1 else parts
    return _mesh(placed, surfaces.joined(parts), placed.reverse)


def _rows(table: np.ndarray | None, rows: np.ndarray) -> np.ndarray | None:
    return None if table is None else table[rows]


def _with_normals(part: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    if "normals" in part:
        return part
    a, b, c = part["vertices"][part["faces"][0]]
    normal = np.cross(b - a, c - a)
    length = float(np.linalg.norm(normal))
    return part | {"normals": np.tile(normal / (length or 1.0), (len(part["vertices"]), 1))}


def _angle(p: Parameters) -> float:
    """The part of a full turn that is there, in radians."""
    degrees = p.number("phimax", 360.0)
    if not 0.0 < degrees <= 360.0:
        found = p.named["phimax"]
        p.report.error(found, f"must be in (0, 360], got {degrees:g}")
        return 2.0 * math.pi
    return math.radians(degrees)


def _cut(placed: Placed, keys: dict[str, np.ndarray], why: str) -> Mesh | None:
    count = len(keys["faces"])
    placed.p.report.approximated(placed.p.directive, f"{why}: {count} triangles are taken")
    return _mesh(placed, keys, placed.turned)


def _sphere(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius = p.positive("radius", 1.0)
    ends = sorted([p.number("zmin", -radius), p.number("zmax", radius)])
    low, high = (min(max(end, -radius), radius) for end in ends)
    phi = _angle(p)
    _alpha(p)
    if low >= high:
        placed.fail(f"zmin and zmax must leave something of it, got {ends[0]:g} and {ends[1]:g}")
        return None
    if low > -radius or high < radius or phi < 2.0 * math.pi:
        return _cut(placed, surfaces.sphere(radius, low, high, phi), "is a part of a sphere")
    if placed.textured:
        # pbrt's v runs up from the south pole, ours down from the north pole.
        placed.matrix = placed.matrix @ _LAYING
    return {"type": "sphere", "radius": radius, **_flipped(placed.turned)}


def _disk(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius, height = p.positive("radius", 1.0), p.number("height", 0.0)
    inner, phi = p.number("innerradius", 0.0), _angle(p)
    _alpha(p)
    if not 0.0 <= inner < radius:
        p.report.error(p.named["innerradius"], f"must be in [0, {radius:g}), got {inner:g}")
        return None
    if inner > 0.0 or phi < 2.0 * math.pi:
        return _cut(placed, surfaces.disk(radius, inner, height, phi), "is a part of a disk")
    if placed.textured:
        why = "has texture coordinates of pbrt's"
        return _cut(placed, surfaces.disk(radius, 0.0, height, phi), why)
    lifted = np.diag([radius, radius, 1.0, 1.0])
    lifted[2, 3] = height
    placed.matrix = placed.matrix @ lifted
    return {"type": "disk", **_flipped(placed.turned)}


def _cylinder(placed: Placed) -> Data | Mesh | None:
    p = placed.p
    radius = p.positive("radius", 1.0)
    low, high = sorted([p.number("zmin", -1.0), p.number("zmax", 1.0)])
    phi = _angle(p)
    _alpha(p)
    if low == high:
        placed.fail(f"zmin and zmax must differ, got {low:g} for both")
        return None
    if phi < 2.0 * math.pi:
        return _cut(placed, surfaces.cylinder(radius, low, high, phi), "is a part of a cylinder")
    ends = {"p0": [0.0, 0.0, low], "p1": [0.0, 0.0, high]}
    return {"type": "cylinder", **ends, "radius": radius, **_flipped(placed.turned)}


#: Shapes of pbrt that alight has models for.
COVERED: dict[str, Callable[[Placed], Data | Mesh | None]] = {
    "bilinearmesh": _bilinear_mesh,
    "cylinder": _cylinder,
    "disk": _disk,
    "loopsubdiv": _loop,
    "plymesh": _ply_mesh,
    "sphere": _sphere,
    "trianglemesh": _triangle_mesh,
}
