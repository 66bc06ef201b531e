"""Displacement as files describe it -> that of meshes of the native format.

A file gives a height, s t + b of a picture t as a rule; ours moves a point by s (t - m), so that m
is -b / s. Meshes are cut into triangles fine enough for a picture, but no more than memory holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.fields import LARGEST
from alight.formats.geometry.bounds import Bounds
from alight.formats.reading.names import free_name
from alight.formats.reading.report import Report
from alight.scene.transform import Matrix
from alight.shapes.mesh import Mesh

#: Triangles that a mesh is cut into at most, and all meshes together, by and large.
MOST_OF_MESH, MOST_OF_ALL = 150_000, 3_000_000
#: Edges of the diagonal of a mesh's box, as the native format has them by default.
_FINEST = 256
_SHORTEST = 1e-12
#: Area of a triangle over the square of the longest edge allowed: edges have half of it at least.
_SHARE = 0.2


class Heights(NamedTuple):
    """How far a material lifts a surface along its normals.

    Attributes
    ----------
    value : number or texture
    scale : float
        Length of the mesh's own space for a value of 1.
    midlevel : float
        The value at which nothing moves.
    """

    value: Any
    scale: float
    midlevel: float = 0.0

    @classmethod
    def of(cls, value: Any, factor: float, offset: float) -> Heights:
        """Those of ``factor * value + offset``."""
        # A picture that changes a height by less than its rounding changes nothing.
        if factor == 0.0 or abs(offset) > 1e12 * abs(factor):
            return cls(1.0, offset)
        return cls(value, factor, -offset / factor)

    @property
    def reach(self) -> float:
        """How far a point moves at most, if values of textures are in [0, 1]."""
        ends = (0.0, 1.0) if isinstance(self.value, dict) else (float(self.value),)
        return max(abs(self.scale * (end - self.midlevel)) for end in ends)


@dataclass
class Lifting:
    """Displaces the meshes of a file.

    Attributes
    ----------
    report : Report
    textures : dict
        Named textures of the scene: heights are entered.
    count : float
        Triangles so far, by and large.
    """

    report: Report
    textures: dict[str, Any]
    count: float = 0.0

    def lift(self, shape: Any, heights: Heights | None, bounds: Bounds, to_world: Matrix) -> Any:
        """A displaced shape; as it is, with a remark, where it cannot be displaced.

        Parameters
        ----------
        shape : Mesh or dict
        heights : Heights or None
        bounds : Bounds
            Gets what it may cover.
        to_world : (4, 4) float64
        """
        if heights is None or heights.reach == 0.0:
            return shape
        if not heights.reach <= LARGEST:
            self.report.approximate("displacement is left out where it is no length of a world")
            return shape
        if not isinstance(shape, Mesh):
            self.report.approximate("displacement is left out of what is no mesh")
            return shape
        if isinstance(heights.value, dict) and shape.uvs is None:
            text = "displacement is left out of meshes without texture coordinates"
            self.report.approximate(text)
            return shape
        return self._lifted(shape, heights, bounds, to_world)

    def _lifted(self, mesh: Mesh, heights: Heights, bounds: Bounds, to_world: Matrix) -> Mesh:
        assert mesh.vertices is not None
        assert mesh.faces is not None
        points = mesh.vertices.astype(np.float64)
        low, high = points.min(axis=0), points.max(axis=0)
        corners = points[mesh.faces]
        edge = max(float(np.linalg.norm(high - low)) / _FINEST, _SHORTEST)
        while (count := _pieces(corners, edge)) > MOST_OF_MESH > len(mesh.faces):
            edge *= 1.25
        if len(mesh.faces) > MOST_OF_MESH or self.count + count > MOST_OF_ALL:
            text = f"displacement is left out of some meshes: {MOST_OF_ALL} triangles are too many"
            self.report.approximate(text)
            return mesh
        self.count += count
        bounds.add(np.stack([low - heights.reach, high + heights.reach]), to_world)
        return mesh.replaced(
            displacement=self._named(heights.value),
            displacement_scale=heights.scale,
            displacement_midlevel=heights.midlevel,
            displacement_edge=edge,
        )

    def _named(self, value: Any) -> Any:
        """The name of a texture, which is entered once; numbers as they are."""
        if not isinstance(value, dict):
            return float(value)
        name = next((name for name, other in self.textures.items() if other == value), None)
        if name is None:
            name = free_name("heights", self.textures, "heights")
            self.textures[name] = value
        return name


def _pieces(corners: NDArray[np.float64], edge: float) -> float:
    """About how many triangles there are when none of (t, 3, 3) has longer edges."""
    sides = np.roll(corners, -1, axis=1) - corners
    areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    # Needles have pieces along their length, however small they are.
    pieces = areas / (_SHARE * edge * edge) + np.where(longest > edge, 2.0 * longest / edge, 0.0)
    return float(pieces.sum()) + len(corners)
