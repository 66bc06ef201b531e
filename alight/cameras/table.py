"""Where the numbers of a camera are in ``scene.camera`` (float32), and how kernels read them."""

from __future__ import annotations

from alight.core.vec import Vec3
from lanewise.jit import kernel

#: Half the film's width and height in pixels; distance of the plane of focus.
HALF_WIDTH, HALF_HEIGHT, FOCUS = 0, 1, 2
#: Vectors in rendering space: viewpoint; unit viewing axis; a pixel to the right and one down on
#: the plane at distance 1 along it; the lens' two radii; a pixel to the right and down in metres.
ORIGIN, FORWARD, RIGHT, DOWN, LENS_X, LENS_Y, METRES_RIGHT, METRES_DOWN = range(3, 27, 3)


@kernel
def vector(table, slot):
    """The vector at `slot` (uniform)."""
    return Vec3(table[slot], table[slot + 1], table[slot + 2])


@kernel
def origin_in_world(table):
    """Where in the world the origin of rendering space is: the last vector (uniform)."""
    return vector(table, table.size - 3)


@kernel
def film_offset(table, film_x, film_y):
    """Pixels from the centre of the film: exact near it, where rounding would show most."""
    return film_x - table[HALF_WIDTH], film_y - table[HALF_HEIGHT]
