r"""Orthographic camera: parallel rays, no perspective.

.. math::
    o = \tfrac{h}{2} (a x, y, 0), \qquad d = -w, \qquad (x, y) \in [-1, 1]^2

with h = `height` and a = width / height of the picture. Axes as in `pinhole`.

Source: PBR4 section 5.2.1.
"""

from __future__ import annotations

from typing import Literal

from alight.cameras.basis import camera_table
from alight.cameras.connection import connect_parallel
from alight.cameras.table import (
    FORWARD,
    METRES_DOWN,
    METRES_RIGHT,
    ORIGIN,
    film_offset,
    vector,
)
from alight.core.field_types import Positive
from alight.core.spec import Camera
from lanewise.jit import kernel
from lanewise.simd import lanes_vec3


class Orthographic(Camera):
    """Camera without perspective.

    Parameters
    ----------
    height : float > 0, metres, default 2
        Height of the part of the scene that the picture shows.
    """

    type: Literal["orthographic"] = "orthographic"
    height: Positive = 2.0


EXAMPLES = (Orthographic(), Orthographic(height=0.01), Orthographic(height=100.0))


PERSPECTIVE = False


def half_extents(spec, width, height):
    """Half the film's sides in metres."""
    return 0.5 * spec.height * width / height, 0.5 * spec.height


def pack(spec, size, to_world):
    """Table of the kernel."""
    return camera_table(half_extents(spec, *size), size, to_world)


@kernel
def generate_ray(table, film_x, film_y, u_lens):
    """Origin and unit direction of the ray through a point of the film."""
    x, y = film_offset(table, film_x, film_y)
    o = vector(table, ORIGIN) + x * vector(table, METRES_RIGHT) + y * vector(table, METRES_DOWN)
    return o, lanes_vec3(0.0) + vector(table, FORWARD)


@kernel
def connect(table, p, u_lens):
    """How points p are seen; see `alight.cameras.connection`."""
    return connect_parallel(table, p)
