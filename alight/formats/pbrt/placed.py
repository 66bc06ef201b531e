"""A shape of pbrt on its way to a mesh of ours.

pbrt takes the side of a surface from the numbers of its parameters: surfaces with a formula are
turned inside out by a mirror, meshes are not; ``ReverseOrientation`` turns both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.parameters import Parameters
from alight.meshes import surfaces
from alight.meshes.triangles import MeshArrays
from alight.scene.meshes import Geometry, checked
from alight.shapes.mesh import Mesh


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
    moves : bool
        Whether it moves while the shutter is open.
    """

    context: Context
    p: Parameters
    matrix: np.ndarray
    reverse: bool
    mirrored: bool
    textured: bool
    moves: bool = False
    extra: Data = field(default_factory=dict)

    @property
    def turned(self) -> bool:
        """Whether a shape with a formula is inside out."""
        return self.reverse != self.mirrored

    def fail(self, message: str) -> None:
        """Report a problem of the shape."""
        self.p.report.error(self.p.directive, message)


def mesh_of(placed: Placed, keys: dict[str, np.ndarray], flip: bool) -> Mesh | None:
    """A mesh of arrays that may be wrong."""
    normals, uvs = keys.get("normals"), keys.get("uvs")
    with np.errstate(over="ignore", invalid="ignore"):
        arrays = MeshArrays(
            np.asarray(keys["vertices"], np.float32),
            np.asarray(keys["faces"], np.int32),
            None if normals is None else np.asarray(normals, np.float32),
            None if uvs is None else np.asarray(uvs, np.float32),
        )
    return described(placed, checked(arrays), flip)


def described(placed: Placed, arrays: Geometry, flip: bool) -> Mesh:
    """A mesh of arrays that are right, with pbrt's sides and texture coordinates."""
    keys = {"vertices": arrays.vertices, "faces": arrays.faces}
    if arrays.normals is not None:
        keys["normals"] = arrays.normals
        keys["faces"] = surfaces.facing_normals(arrays.vertices, arrays.faces, arrays.normals)
    if arrays.uvs is not None:
        keys["uvs"] = arrays.uvs
    elif placed.textured:
        keys = surfaces.own_corners(keys)
    return Mesh(**keys, flip_normals=flip)


def angle_of(p: Parameters) -> float:
    """Ask for the part of a full turn that is there, in radians."""
    degrees = p.number("phimax", 360.0)
    if not 0.0 < degrees <= 360.0:
        found = p.named["phimax"]
        p.report.error(found, f"must be in (0, 360], got {degrees:g}")
        return 2.0 * math.pi
    return math.radians(degrees)


def cut(placed: Placed, keys: dict[str, np.ndarray], why: str) -> Mesh | None:
    """A mesh in the place of a surface with a formula."""
    count = len(keys["faces"])
    placed.p.report.warn(placed.p.directive, f"{why}: {count} triangles are taken")
    return mesh_of(placed, keys, placed.turned)
