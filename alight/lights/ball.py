"""The ball around a scene, into which light from infinity goes.

Rays of one direction enter it through a disk of its radius.

Source: PBR4 section 12.3.
"""

from __future__ import annotations

from alight.core.constants import PI
from alight.core.frame import frame_from_normal
from alight.core.vec import dot, row_vec3
from alight.core.warps import square_to_disk_concentric
from alight.lights.tables import MIDDLE, RADIUS
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_vec3

#: How far behind the middle rays start, in radii: what touches the ball is met.
BEHIND = 1.0 + 2.0**-6


@kernel
def middle_of(scene):
    """Middle of the scene's ball, metres."""
    return lanes_vec3(0.0) + row_vec3(scene.lights.emission, MIDDLE)


@kernel
def radius_of(scene):
    """Radius of the scene's ball, metres."""
    return lanes(0.0) + scene.lights.emission[RADIUS]


@kernel
def disk_area(scene):
    """Area in m^2 of the disk through which rays of one direction enter."""
    radius = radius_of(scene)
    return PI * radius * radius


@kernel
def across_the_ball(scene, d, u2):
    """Where a ray along the unit vector d starts, all lines alike; and the area of their disk."""
    radius = radius_of(scene)
    s, t = frame_from_normal(d)
    x, y = square_to_disk_concentric(u2)
    across = (radius * x) * s + (radius * y) * t
    return middle_of(scene) + across - (BEHIND * radius) * d, disk_area(scene)


@kernel
def behind_the_ball(scene, p, d):
    """Where the line through p along d starts, and its squared distance from the middle."""
    to_p = p - middle_of(scene)
    across = to_p - dot(to_p, d) * d
    p = middle_of(scene) + across - (BEHIND * radius_of(scene)) * d
    return p, dot(across, across)
