"""Mesh descriptions -> checked arrays, read from files where the description names one."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.core.registry import specs_of
from alight.core.spec import Shape, Texture
from alight.meshes import obj, ply, stl
from alight.meshes.triangles import MeshArrays
from alight.scene.builtin.pictures import is_builtin
from alight.scene.builtin.waves import builtin_mesh
from alight.scene.files import Files
from alight.shapes.arrays import TriangleShape
from alight.textures.nesting import reads_uv

FORMATS = {".ply": ply.read, ".obj": obj.read, ".stl": stl.read}

#: Keys that say how a mesh is displaced.
ONLY_DISPLACED = ("displacement_scale", "displacement_midlevel", "displacement_edge")


@dataclass(frozen=True, eq=False)
class Geometry:
    """Arrays of one mesh, checked and ready for the compiler; read-only.

    Attributes
    ----------
    vertices : (n, 3) float32, metres
    faces : (m, 3) int32
    normals : (n, 3) float32 or None
        None also where the mesh asks for face normals.
    uvs : (n, 2) float32 or None
    colors : (n, 3) float32 or None
    more_uvs : (k, n, 2) float32 or None
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None
    uvs: NDArray[np.float32] | None
    colors: NDArray[np.float32] | None
    more_uvs: NDArray[np.float32] | None

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all the arrays; equal meshes have equal digests."""
        result = hashlib.sha256()
        # Most meshes have no further sets; their digests are what they were before there were any.
        for name in MeshArrays._fields[: None if self.more_uvs is not None else -1]:
            part = getattr(self, name)
            result.update(b"-" if part is None else f"{part.dtype}{part.shape}".encode())
            result.update(b"" if part is None else np.ascontiguousarray(part).data)
        return result.hexdigest()

    @cached_property
    def extent(self) -> tuple[float, float]:
        """Largest distance of a coordinate from 0, and longest side of the box, metres."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return float(max(-low.min(), high.max())), float((high - low).max())

    @cached_property
    def flat(self) -> Geometry:
        """The same without vertex normals."""
        return self if self.normals is None else replace(self, normals=None)


def geometry(mesh: TriangleShape, files: Files) -> Geometry:
    """Return the checked arrays of a mesh, the same ones each time.

    Raises
    ------
    SceneError
        If the file is missing or broken, or the arrays make no mesh; paths are relative to
        the shape.
    """
    found: Geometry | None = mesh.checked
    if mesh.file is not None:
        found = files.read(_geometry_in, mesh.file)
    elif found is None:
        found = checked(arrays_of(mesh))
        mesh.hand_on(found)
    return found.flat if mesh.face_normals else found


def mesh_of(arrays: MeshArrays, **options: bool) -> TriangleShape:
    """A mesh of arrays, which are checked here and not again.

    Raises
    ------
    SceneError
        If they make no mesh; the path is the array's name.
    """
    of_arrays = next(s for s in specs_of(Shape).values() if issubclass(s, TriangleShape))
    mesh = of_arrays(**vars(checked(arrays)), **options)
    mesh.hand_on(Geometry(*arrays_of(mesh)))
    return mesh


def arrays_of(mesh: TriangleShape) -> MeshArrays:
    """The arrays that a mesh without a file holds."""
    assert mesh.vertices is not None and mesh.faces is not None
    return MeshArrays(*(getattr(mesh, name) for name in MeshArrays._fields))


def read_file(path: Path, name: str = "") -> MeshArrays:
    """Read a PLY, OBJ or STL file.

    Parameters
    ----------
    path : Path
        The file.
    name : str, optional
        How messages call it; ``builtin:waves`` is a computed one.

    Raises
    ------
    SceneError
        If it is missing, of an unknown kind, or broken.
    """
    name = name or str(path)
    if is_builtin(name):
        try:
            return builtin_mesh(name)
        except ValueError as error:
            raise _error(f"{quote(name)}: {error}") from None
    reader = FORMATS.get(path.suffix.lower())
    if reader is None:
        raise _error(f"must be a .ply, .obj or .stl file, got {quote(name)}")
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise _error(unreadable(path, name, error, tuple(FORMATS))) from None
    try:
        return reader(data)
    except SceneError as error:
        raise SceneError(
            [Issue("file", f"{quote(name)}: {issue.message}") for issue in error.issues]
        ) from None


def unreadable(
    path: Path, name: str, error: OSError | ValueError, suffixes: tuple[str, ...]
) -> str:
    """Say why a file cannot be read; of a missing one, the nearest name with such a suffix."""
    if not isinstance(error, FileNotFoundError):
        reason = error.strerror if isinstance(error, OSError) else str(error)
        return f"cannot read {quote(name)}: {reason}"
    try:
        beside = [entry.name for entry in path.parent.iterdir() if entry.suffix in suffixes]
    except OSError:
        return f"no such file: {quote(name)} (there is no folder {quote(str(path.parent))})"
    near = nearest(path.name, beside)
    return f"no such file: {quote(name)}" + (f'; did you mean "{near}"?' if near else "")


def _geometry_in(path: Path, name: str) -> Geometry:
    arrays = read_file(path, name)
    try:
        return checked(arrays)
    except SceneError as error:
        raise SceneError(
            [Issue("file", f"{quote(name)}: {i.path} {i.message}") for i in error.issues]
        ) from None


def checked(arrays: MeshArrays) -> Geometry:
    """Check arrays, which then cannot be changed any more.

    Raises
    ------
    SceneError
        If they make no mesh; the path is the array's name.
    """
    problem = mesh_problem(arrays)
    if problem:
        raise SceneError([Issue(*problem)])
    for part in arrays:
        if part is not None:
            part.setflags(write=False)
    return Geometry(*arrays)


def mesh_problem(arrays: MeshArrays) -> tuple[str, str] | None:
    """Find what makes arrays no mesh: the array's name and a message, or None."""
    count = len(arrays.vertices)
    if count == 0:
        return "vertices", "must hold at least one vertex, got an empty mesh"
    if len(arrays.faces) == 0:
        return "faces", "must hold at least one triangle, got an empty mesh"
    for name in ("vertices", "normals", "uvs", "colors"):
        table = getattr(arrays, name)
        if table is None:
            continue
        if len(table) != count:
            return name, f"must have one row per vertex ({count}), got {len(table)}"
        # Squares of larger numbers would overflow in float32 kernels.
        if table.size == 0 or (table.min() >= -1e15 and table.max() <= 1e15):
            continue
        bad = ~(np.abs(table) <= 1e15).all(axis=1)
        if bad.any():
            row = int(bad.argmax())
            shown = ", ".join(str(x) for x in table[row])
            return name, f"must be finite and at most 1e+15 in size, got ({shown}) in row {row}"
    low, high = int(arrays.faces.min()), int(arrays.faces.max())
    if low < 0 or high >= count:
        bad_index = low if low < 0 else high
        row = int((arrays.faces == bad_index).any(axis=1).argmax())
        return "faces", f"must index vertices 0 to {count - 1}, got {bad_index} in row {row}"
    if arrays.more_uvs is not None:
        if arrays.uvs is None:
            return "more_uvs", "need uvs, the set 0, beside them"
        for number, table in enumerate(arrays.more_uvs, 1):
            problem = mesh_problem(arrays._replace(uvs=table, more_uvs=None))
            if problem:
                return f"more_uvs[{number - 1}]", problem[1]
    if arrays.colors is not None and not ((arrays.colors >= 0) & (arrays.colors <= 1)).all():
        return "colors", "must be in [0, 1]"
    return None


def displacement_problem(
    mesh: TriangleShape, found: Geometry, textures: Mapping[str, Texture]
) -> str | None:
    """Say why a mesh cannot be displaced; None if it can, or shall not be."""
    value = mesh.displacement
    if value is None:
        idle = [name for name, value in mesh if name in ONLY_DISPLACED and value != _default(name)]
        return f"is missing: without it, {idle[0]} does nothing" if idle else None
    texture = textures.get(value) if isinstance(value, str) else value
    if isinstance(texture, Texture) and found.uvs is None and reads_uv(texture, textures):
        name = texture.type_name()
        article = "an" if name[0] in "aeiou" else "a"
        return f"{article} {name} needs texture coordinates, and the mesh has no uvs"
    return None


def _default(name: str) -> float | None:
    return TriangleShape.model_fields[name].default


def surface_area(geometry: Geometry, to_world: NDArray[np.float64]) -> float:
    """Sum up the areas of all triangles in world space, m^2."""
    points = geometry.vertices.astype(np.float64) @ to_world[:3, :3].T
    a, b, c = (points[geometry.faces[:, corner]] for corner in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _error(message: str, path: str = "file") -> SceneError:
    return SceneError([Issue(path, message)])
