"""Mesh descriptions -> checked arrays, read from files where the description names one."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.meshes import obj, ply, stl
from alight.meshes.triangles import MeshArrays
from alight.shapes.arrays import TriangleShape

FORMATS = {".ply": ply.read, ".obj": obj.read, ".stl": stl.read}


@dataclass(frozen=True, eq=False)
class Geometry:
    """Arrays of one mesh, ready for the compiler; read-only.

    Attributes
    ----------
    vertices : (n, 3) float32, metres
    faces : (m, 3) int32
    normals : (n, 3) float32 or None
        None also where the mesh asks for face normals.
    uvs : (n, 2) float32 or None
    colors : (n, 3) float32 or None
    more_uvs : (k, n, 2) float32 or None
    digest : str
        SHA-256 of all the arrays; equal meshes have equal digests.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None
    uvs: NDArray[np.float32] | None
    colors: NDArray[np.float32] | None
    more_uvs: NDArray[np.float32] | None
    digest: str


@dataclass
class MeshStore:
    """Reads every mesh once.

    Parameters
    ----------
    folder : Path, optional
        Where relative names are looked up; the current folder by default.
    """

    folder: Path | None = None
    _files: dict[Path, MeshArrays | SceneError] = field(default_factory=dict)
    _geometries: dict[object, Geometry] = field(default_factory=dict)
    _kept: list[TriangleShape] = field(default_factory=list)

    def geometry(self, mesh: TriangleShape) -> Geometry:
        """Return the checked arrays of a mesh.

        Raises
        ------
        SceneError
            If the file is missing or broken, or the arrays make no mesh; paths are relative to
            the shape.
        """
        # The address is a safe key only while the object lives, hence `_kept`.
        key = (mesh.file, mesh.face_normals) if mesh.file is not None else id(mesh)
        if key not in self._geometries:
            self._kept.append(mesh)
            arrays = self._read(mesh.file) if mesh.file is not None else _from_arrays(mesh)
            self._geometries[key] = _geometry(arrays, mesh)
        return self._geometries[key]

    def _read(self, name: str) -> MeshArrays:
        path = (self.folder or Path()) / name
        if path not in self._files:
            try:
                self._files[path] = read_file(path, name)
            except SceneError as error:
                self._files[path] = error
        result = self._files[path]
        if isinstance(result, SceneError):
            raise result
        return result


def read_file(path: Path, name: str = "") -> MeshArrays:
    """Read a PLY, OBJ or STL file.

    Parameters
    ----------
    path : Path
        The file.
    name : str, optional
        How messages call it.

    Raises
    ------
    SceneError
        If it is missing, of an unknown kind, or broken.
    """
    name = name or str(path)
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


def _from_arrays(mesh: TriangleShape) -> MeshArrays:
    assert mesh.vertices is not None
    assert mesh.faces is not None
    return MeshArrays(*(getattr(mesh, name) for name in MeshArrays._fields))


def _geometry(arrays: MeshArrays, mesh: TriangleShape) -> Geometry:
    problem = mesh_problem(arrays)
    if problem:
        path, message = problem
        where = f"{quote(mesh.file)}: {path} " if mesh.file is not None else ""
        raise _error(where + message, "file" if mesh.file is not None else path)
    normals = None if mesh.face_normals else arrays.normals
    kept = arrays._replace(normals=normals)
    parts = tuple(kept)
    digest = hashlib.sha256()
    # Most meshes have no further sets; their digests are what they were before there were any.
    for part in parts if arrays.more_uvs is not None else parts[:-1]:
        digest.update(b"-" if part is None else f"{part.dtype}{part.shape}".encode())
        digest.update(b"" if part is None else np.ascontiguousarray(part).data)
    for part in parts:
        if part is not None:
            part.setflags(write=False)
    return Geometry(**kept._asdict(), digest=digest.hexdigest())


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


def surface_area(geometry: Geometry, to_world: NDArray[np.float64]) -> float:
    """Sum up the areas of all triangles in world space, m^2."""
    points = geometry.vertices.astype(np.float64) @ to_world[:3, :3].T
    a, b, c = (points[geometry.faces[:, corner]] for corner in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _error(message: str, path: str = "file") -> SceneError:
    return SceneError([Issue(path, message)])
