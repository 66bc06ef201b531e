r"""Infinite plane z = 0 with normal +z and parameters (u, v) = (x, y).

.. math:: t = -o_z / d_z

It has no bounds, so it is tested outside the acceleration structure and cannot be an area light.

Source: PBR4 section 6.1.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.spec import Shape
from alight.core.vec import gather_vec3
from alight.shapes.flat import E1, E2, flat_geometry, meet_plane, pack_flat, point_error
from lanewise.jit import kernel


class Plane(Shape):
    """Infinite plane z = 0.

    Parameters
    ----------
    flip_normals : bool, default False
        Point the normal to -z.
    """

    finite: ClassVar[bool] = False
    type: Literal["plane"] = "plane"


EXAMPLES = (Plane(), Plane(flip_normals=True))

#: Farther hits are none: their squared distances would overflow float32.
LARGEST = 1e15


def pack(spec: Plane, matrix: np.ndarray) -> np.ndarray:
    """The row of the table, see `alight.shapes.flat`."""
    return pack_flat(matrix, spec.flip_normals, extent=0.0)


@kernel(strict=True)
def intersect(data, k, o, d, t_max):
    """Meet one plane with rays; see `alight.shapes.rectangle.intersect`.

    A ray parallel to the plane or within it has an infinite or undefined t: no hit.
    """
    t, x, y = meet_plane(data, k, o, d)
    return t, x, y, (t > 0.0) & (t <= t_max) & (t < LARGEST)


@kernel
def surface(tables, k, hit, o, d):
    """The `Geometry` of hits; k: offsets of the rows, lanes."""
    error = point_error(tables.data, k, hit.u, hit.v)
    return flat_geometry(tables.data, k, hit.u, hit.v, error, hit.u, hit.v)


@kernel
def derivatives(tables, k, surface):
    """(dp/du, dp/dv) at points of the surface, in the world."""
    return gather_vec3(tables.data, k + E1), gather_vec3(tables.data, k + E2)
