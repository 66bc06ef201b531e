"""Shapes that are formulas as meshes, for files that hold nothing else.

Each mesh has the texture coordinates of its shape, and stands where a matrix puts it, so that many
spheres share one.
"""

from __future__ import annotations

import numpy as np

from alight.core.spec import Shape
from alight.meshes.surfaces import grid
from alight.meshes.triangles import MeshArrays
from alight.shapes import cylinder, sphere

Array = np.ndarray
#: Steps around and from pole to pole, or from the centre of a disk to its edge. The edges of a
#: sphere are off by 1 - cos(pi / 128), 0.03 % of its radius.
AROUND, UP, OUT = 128, 64, 16
#: Shapes that triangles hold exactly.
EXACT = ("rectangle", "cube")
_TURN = 2.0 * np.pi


def tessellated(shape: Shape) -> tuple[MeshArrays, Array] | None:
    """A mesh for a shape.

    Returns
    -------
    MeshArrays
        Not flipped, whatever the shape says.
    (4, 4) float64
        From the space of the mesh to that of the shape.

    or None for shapes that have no mesh, as infinite planes and those of plug-ins.
    """
    kind = shape.type_name()
    if kind not in _MESHES:
        return None
    placed = np.eye(4)
    if isinstance(shape, sphere.Sphere | cylinder.Cylinder):
        # Of a tiny one, numbers that play no part here overflow.
        with np.errstate(over="ignore"):
            row = (sphere if isinstance(shape, sphere.Sphere) else cylinder).pack(shape, np.eye(4))
        placed[:3, 3] = row[:3]
        placed[:3, :3] = (
            row[17:26].reshape(3, 3) if kind == "cylinder" else shape.radius * np.eye(3)
        )
    return _MESHES[kind](), placed


def flipped(mesh: MeshArrays) -> MeshArrays:
    """The same surface with its outer side inside."""
    normals = None if mesh.normals is None else -mesh.normals
    return mesh._replace(faces=np.ascontiguousarray(mesh.faces[:, ::-1]), normals=normals)


def _rectangle() -> MeshArrays:
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return MeshArrays(corners, faces, uvs=0.5 * corners[:, :2] + np.float32(0.5))


def _cube() -> MeshArrays:
    """Six rectangles, in the order and with the parameters of `alight.compiled.shapes`."""
    face = _rectangle()
    assert face.uvs is not None
    points, faces = [], []
    for axis in range(3):
        for sign in (1.0, -1.0):
            # Columns: where the rectangle's x, y and z lead.
            first, normal = np.zeros(3), np.zeros(3)
            normal[axis], first[(axis + 1) % 3] = sign, 1.0
            across = np.stack([first, np.cross(normal, first), normal])
            faces.append(face.faces + 4 * len(points))
            points.append(face.vertices @ across + normal)
    return MeshArrays(
        np.concatenate(points).astype(np.float32),
        np.concatenate(faces).astype(np.int32),
        uvs=np.tile(face.uvs, (6, 1)),
    )


def _sphere() -> MeshArrays:
    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        sine = np.sin(v * np.pi)
        n = np.stack([sine * np.cos(u * _TURN), sine * np.sin(u * _TURN), np.cos(v * np.pi)], 1)
        return n, n

    # v runs downwards, so u and v turn the other way round than the normal says.
    mesh = _mesh(grid(formula, AROUND, UP))
    return mesh._replace(faces=np.ascontiguousarray(mesh.faces[:, ::-1]))


def _disk() -> MeshArrays:
    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        flat = np.zeros_like(u)
        points = np.stack([u * np.cos(v * _TURN), u * np.sin(v * _TURN), flat], axis=1)
        return points, np.stack([flat, flat, flat + 1.0], axis=1)

    return _mesh(grid(formula, OUT, AROUND))


def _cylinder() -> MeshArrays:
    def formula(u: Array, v: Array) -> tuple[Array, Array]:
        x, y = np.cos(u * _TURN), np.sin(u * _TURN)
        return np.stack([x, y, v], axis=1), np.stack([x, y, 0.0 * v], axis=1)

    return _mesh(grid(formula, AROUND, 1))


def _mesh(keys: dict[str, Array]) -> MeshArrays:
    """Arrays without the triangles that have no area, at poles and centres."""
    points, faces = keys["vertices"], keys["faces"]
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return MeshArrays(
        points.astype(np.float32),
        faces[area > 1e-12].astype(np.int32),
        keys["normals"].astype(np.float32),
        keys["uvs"].astype(np.float32),
    )


_MESHES = {
    "rectangle": _rectangle, "cube": _cube, "sphere": _sphere, "disk": _disk,
    "cylinder": _cylinder,
}  # fmt: skip
