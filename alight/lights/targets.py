"""What techniques aim at that look for a lamp and not for a point of it: spheres, and one disk.

`LightTables.targets` holds a distribution of all lights (`alight.core.distributions`), by the power
of those that can be aimed at, and then for each light the middle and the radius of a sphere around
its shape as it rests, metres; the radius is 0 of lights that are no targets. Of what is around the
scene one disk is, the brightest: in the place of the sphere are the unit direction to its middle,
and the sine of its half angle, negated. The last number of the table is the row of that light.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.distributions import sample_discrete
from alight.core.vec import Vec3, dot, length_squared
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.lights.model import LIGHTS
from alight.lights.tables import INFO
from lanewise.jit import kernel, specialised
from lanewise.simd import absolute, any_lane, as_int, gather_row, lanes_u32, where

#: Numbers of a sphere.
SPHERE = 4

#: A light that is aimed at. light: u32, its row; c, radius: Vec3 and float, the middle and the
#: radius of its sphere, metres, or the direction to its disk and the sine of its half angle; far:
#: mask, it is the disk.
Target = namedtuple("Target", "light c radius far")


def has_far_target(program) -> bool:
    """Whether there may be a disk."""
    return any(LIGHTS[name].disk_of is not None for name in environments_of(program))


def has_targets(program) -> bool:
    """Whether there is anything to aim at."""
    return bool(on_shapes(program)) or has_far_target(program)


@kernel
def choose_target(scene, u):
    """(row of a light, its probability) for a number in [0, 1)."""
    index, probability, _ = sample_discrete(
        scene.lights.targets, 0, scene.lights.info.size // INFO, u
    )
    return index, probability


@kernel
def far_light(scene):
    """The row of the light whose disk is the target, where there is one; uniform."""
    return as_int(scene.lights.targets[scene.lights.targets.size - 1])


@kernel
def target_at(scene, index):
    """The `Target` in a row; of those that are none, the radius is 0."""
    start = scene.lights.info.size // INFO + 1
    x, y, z, radius = gather_row(scene.lights.targets, start + index * SPHERE, 4)
    return Target(index, Vec3(x, y, z), absolute(radius), radius < 0.0)


@specialised
def way_to(program):
    """``way_to(target, o)``: from places to the middle; of a disk, a unit vector."""
    if not has_far_target(program):

        @kernel
        def to_sphere(target, o):
            return target.c - o

        return to_sphere

    @kernel
    def to_sphere_or_disk(target, o):
        return where(target.far, target.c, target.c - o)

    return to_sphere_or_disk


@kernel
def _is_within(target, d):
    """Mask: unit directions lead to the disk."""
    along = dot(target.c, d)
    across = length_squared(target.c - along * d)
    return (along > 0.0) & (across <= target.radius * target.radius)


@kernel
def leads_to_disk(scene, d):
    """Mask: rays along unit directions, which leave the scene, meet the disk that is a target."""
    return _is_within(target_at(scene, lanes_u32(0) + far_light(scene)), d)


@specialised
def found_beyond(program):
    """``(scene, target, d, left)``: radiance of disks along unit directions that left the scene."""
    if not has_far_target(program):

        @kernel
        def nothing(scene, target, d, left):
            return target.c * 0.0

        return nothing

    @kernel
    def of_the_sky(scene, target, d, left):
        found = target.c * 0.0
        inside = left & target.far & _is_within(target, d)
        if any_lane(inside):
            found = where(inside, environment_radiance(scene, where(inside, d, 0.0)), found)
        return found

    return of_the_sky
