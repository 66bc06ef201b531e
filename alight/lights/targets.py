"""Spheres around the shapes that shine, for techniques that aim at a lamp and not at a point of it.

`LightTables.targets` holds a distribution of all lights (`alight.core.distributions`), by the power
of those that are on shapes, and then for each light the middle and the radius of a sphere around
its shape as it rests, metres; the radius is 0 of lights without a shape.
"""

from __future__ import annotations

from alight.core.distributions import sample_discrete
from alight.core.vec import Vec3
from alight.lights.tables import INFO
from lanewise.jit import kernel
from lanewise.simd import gather_row

#: Numbers of a sphere.
SPHERE = 4


@kernel
def choose_target(scene, u):
    """(row of a light, its probability) for a number in [0, 1)."""
    index, probability, _ = sample_discrete(
        scene.lights.targets, 0, scene.lights.info.size // INFO, u
    )
    return index, probability


@kernel
def sphere_of(scene, index):
    """(middle, radius) of the sphere around a light."""
    start = scene.lights.info.size // INFO + 1
    x, y, z, radius = gather_row(scene.lights.targets, start + index * SPHERE, 4)
    return Vec3(x, y, z), radius
