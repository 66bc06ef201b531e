r"""Pinhole camera: perspective, everything sharp.

.. math::
    d = \text{normalize}(x\, u + y\, v - w), \qquad
    (x, y) \in [-a \tan\tfrac{fov}{2}, a \tan\tfrac{fov}{2}] \times
              [-\tan\tfrac{fov}{2}, \tan\tfrac{fov}{2}]

with a = width / height and `fov` along y. (u, v, w) is the basis of the camera: it looks along its
local -z (so w points backwards), +x is right, +y is up, as in OpenGL and Blender.

Source: Shirley and Morley, Realistic Ray Tracing (2003), chapter 3; PBR4 section 5.2.
"""

from __future__ import annotations

from typing import Literal

from alight.cameras.basis import camera_table, perspective_half_extents
from alight.cameras.connection import connect_far_point, connect_point
from alight.cameras.table import DOWN, FORWARD, ORIGIN, RIGHT, film_offset, vector
from alight.core.field_types import FieldOfView
from alight.core.spec import Camera
from alight.core.vec import normalize
from lanewise.jit import kernel
from lanewise.simd import lanes_vec3


class Pinhole(Camera):
    """Perspective camera without a lens.

    Parameters
    ----------
    fov : float, degrees in (0, 180), default 45
        Full opening angle along `fov_axis`.
    fov_axis : {"y", "x", "smaller", "larger", "diagonal"}, default "y"
        Side of the picture that `fov` spans; "y" is the vertical field of view.
    """

    type: Literal["pinhole"] = "pinhole"
    fov: FieldOfView = 45.0
    fov_axis: Literal["x", "y", "smaller", "larger", "diagonal"] = "y"


EXAMPLES = (
    Pinhole(),
    Pinhole(fov=90.0, fov_axis="x"),
    Pinhole(fov=5.0, fov_axis="smaller"),
    Pinhole(fov=120.0, fov_axis="diagonal"),
    Pinhole(fov=39.3077, fov_axis="larger"),
)


PERSPECTIVE = True


def half_extents(spec, width, height):
    """Half the film's sides at distance 1 from the viewpoint."""
    return perspective_half_extents(spec.fov, spec.fov_axis, width, height)


def pack(spec, size, to_world):
    """Table of the kernel."""
    return camera_table(half_extents(spec, *size), size, to_world)


@kernel
def generate_ray(table, film_x, film_y, u_lens):
    """Origin and unit direction of the ray through a point of the film."""
    x, y = film_offset(table, film_x, film_y)
    d = vector(table, FORWARD) + x * vector(table, RIGHT) + y * vector(table, DOWN)
    return lanes_vec3(0.0) + vector(table, ORIGIN), normalize(d)


@kernel
def connect(table, p, u_lens):
    """How points p are seen; see `alight.cameras.connection`."""
    return connect_point(table, lanes_vec3(0.0), p)


@kernel
def connect_far(table, d, u_lens):
    """How what lies infinitely far along unit directions d is seen."""
    return connect_far_point(table, lanes_vec3(0.0), d)
