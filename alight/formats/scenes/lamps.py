"""Lamps of other programs -> lights of the native format.

All programs know points, cones, parallel rays and surfaces that shine. They differ in what they
measure: power or radiance, an edge of the cone or its softness, +z or -z as the front. What is left
here is ours: intensities, radiances, degrees, and lights that shine along +z.

Areas are those of the images of simple shapes under a matrix, (4, 4) float64, whose linear part
alone counts: power is asked for per area, where a lamp stands.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.shapes.cylinder import mantle_area
from alight.shapes.mesh import Mesh
from alight.shapes.sphere import ellipsoid_area

Data = dict[str, Any]
#: Degrees: the narrowest cone of a spot.
_NARROWEST = 0.001


def point(intensity: list[float]) -> Data:
    """A light that shines alike to all sides, W/sr."""
    return {"type": "point", "intensity": intensity}


def parallel(irradiance: list[float]) -> Data:
    """Parallel rays, W/m^2 across them."""
    return {"type": "directional", "irradiance": irradiance}


def spot(intensity: list[float], cutoff: float, beam: float, falloff: str | None = None) -> Data:
    """A cone of light: W/sr along its axis, and half angles in degrees.

    Parameters
    ----------
    cutoff, beam : float
        Where it ends, and within which it is even.
    falloff : str, optional
        Between the two, as the native format names it.
    """
    light: Data = {"type": "spot", "intensity": intensity}
    light |= {"cutoff_angle": max(cutoff, _NARROWEST), "beam_width": beam}
    return light if falloff is None else light | {"falloff": falloff}


def turned(light: Data, axis: str) -> Data:
    """The node of a light whose file has it shine along -z; any axis across will do."""
    return {"light": light, "transform": [{"rotate": {"axis": axis, "angle": 180.0}}]}


def area_across(to_world: np.ndarray) -> float:
    """Area of the image of a square of 1 m in the plane z = 0."""
    return float(np.linalg.norm(np.cross(to_world[:3, 0], to_world[:3, 1])))


def area_of_ball(to_world: np.ndarray, radius: float) -> float:
    """Area of the ellipsoid that a matrix makes of a sphere; never of nothing."""
    sizes = np.linalg.svd(to_world[:3, :3], compute_uv=False)
    size = radius * float(sizes[0])
    form = np.maximum(sizes / max(sizes[0], 1e-30), 1e-6)
    # What is too large to be squared becomes infinite: ``**`` would raise an error.
    return size * size * ellipsoid_area(np.diag(form))


def area_of_mantle(to_world: np.ndarray, radius: float, length: float) -> float:
    """Area of the image of a cylinder along z without its ends."""
    return radius * length * mantle_area(to_world[:3, :3])


def area_of_mesh(mesh: Mesh, to_world: np.ndarray) -> float:
    """Area of the image of a mesh."""
    assert mesh.vertices is not None
    assert mesh.faces is not None
    moved = mesh.vertices.astype(np.float64) @ to_world[:3, :3].T
    a, b, c = (moved[mesh.faces[:, i]] for i in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
