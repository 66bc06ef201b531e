r"""Thin lens camera: perspective with depth of field.

.. math::
    o = (r \cos\phi, r \sin\phi, 0), \qquad
    p = \text{focus\_distance} \cdot d_\text{pinhole} / |d_{\text{pinhole}, z}|, \qquad
    d = \text{normalize}(p - o)

A point o of the lens (a disk) is joined with the point p where the pinhole's ray meets the plane
of focus. Axes and field of view as in `pinhole`.

Source: Cook, Porter and Carpenter, Distributed ray tracing (1984); PBR4 section 5.2.3.
"""

from __future__ import annotations

from typing import Literal

from alight.cameras.basis import camera_table, perspective_half_extents
from alight.cameras.connection import connect_far_point, connect_point
from alight.cameras.table import (
    DOWN,
    FOCUS,
    FORWARD,
    LENS_X,
    LENS_Y,
    ORIGIN,
    RIGHT,
    film_offset,
    vector,
)
from alight.core.field_types import FieldOfView, NonNegative, Positive
from alight.core.spec import Camera
from alight.core.vec import normalize
from alight.core.warps import square_to_disk_concentric
from lanewise.jit import kernel


class ThinLens(Camera):
    """Perspective camera with a round lens.

    Parameters
    ----------
    fov : float, degrees in (0, 180), default 45
        Full opening angle along `fov_axis`.
    fov_axis : {"y", "x", "smaller", "larger", "diagonal"}, default "y"
        Side of the picture that `fov` spans.
    aperture_radius : float >= 0, metres, default 0.1
        Radius of the lens; 0 is a pinhole.
    focus_distance : float > 0, metres, default 1
        Distance from the lens to the plane that is sharp, along the viewing axis.
    """

    type: Literal["thin_lens"] = "thin_lens"
    fov: FieldOfView = 45.0
    fov_axis: Literal["x", "y", "smaller", "larger", "diagonal"] = "y"
    aperture_radius: NonNegative = 0.1
    focus_distance: Positive = 1.0


EXAMPLES = (
    ThinLens(),
    ThinLens(fov=20.0, fov_axis="x", aperture_radius=0.0, focus_distance=10.0),
    ThinLens(fov=100.0, aperture_radius=1.0, focus_distance=0.5),
)


PERSPECTIVE = True


def half_extents(spec, width, height):
    """Half the film's sides at distance 1 from the centre of the lens."""
    return perspective_half_extents(spec.fov, spec.fov_axis, width, height)


def pack(spec, size, to_world):
    """Table of the kernel."""
    return camera_table(
        half_extents(spec, *size),
        size,
        to_world,
        lens_radius=spec.aperture_radius,
        focus_distance=spec.focus_distance,
    )


@kernel
def generate_ray(table, film_x, film_y, u_lens):
    """Origin on the lens and unit direction of a ray through a point of the film."""
    x, y = film_offset(table, film_x, film_y)
    axis = vector(table, FORWARD) + x * vector(table, RIGHT) + y * vector(table, DOWN)
    # Both ends are seen from the centre of the lens, which is added last: far from the world's
    # origin its rounding then moves the ray, but does not turn it.
    lens_x, lens_y = square_to_disk_concentric(u_lens)
    lens = lens_x * vector(table, LENS_X) + lens_y * vector(table, LENS_Y)
    return vector(table, ORIGIN) + lens, normalize(table[FOCUS] * axis - lens)


@kernel
def lens_of(table, u_lens):
    """A point of the lens, seen from its centre."""
    x, y = square_to_disk_concentric(u_lens)
    return x * vector(table, LENS_X) + y * vector(table, LENS_Y)


@kernel
def connect(table, p, u_lens):
    """How points p are seen; see `alight.cameras.connection`."""
    return connect_point(table, lens_of(table, u_lens), p)


@kernel
def connect_far(table, d, u_lens):
    """How what lies infinitely far along unit directions d is seen."""
    return connect_far_point(table, lens_of(table, u_lens), d)
