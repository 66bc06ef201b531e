"""What techniques aim at that look for a lamp and not for a point of it: spheres and disks.

`LightTables.targets` holds a distribution of all lights (`alight.core.distributions`), by the power
of those that can be aimed at, and then for each light the middle and the radius of a sphere around
its shape as it rests, metres; the radius is 0 of lights that are no targets. Of what is around the
scene one disk is, the brightest: in the place of the sphere are the unit direction to its middle,
and the sine of its half angle, negated. Then follow the row of that light, the number of boxes
around shapes that are mirrors or clear glass, and of each two corners as it rests and the number of
its motion, as of `alight.core.motion.Motions`. `alight.lights.photons` tells the rest. Where lights
and casters move, they are aimed at where they are at the time of the path.

Delta lights have no size. From wherever they are seen they are taken for a disk of one small angle,
with the irradiance that they have there: `FINE` is its sine, and stands in the table in the place
of a radius. Walks then end at a density of directions, as at any other lamp. Of what the light
depends on, nothing but its mean over this disk is ever used, so the error is of the order of
the square of `FINE`.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_PI
from alight.core.distributions import sample_discrete
from alight.core.motion import matrix_at, moved_along, placed, turned
from alight.core.vec import Vec3, dot, gather_vec3, length_squared
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.lights.model import LIGHTS
from alight.lights.moving import moving_sample
from alight.lights.sampling import has_delta_lights, sample_by_kind
from alight.lights.tables import INFO, STRIDE
from alight.shapes.hit import shadow_length
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    absolute,
    any_lane,
    as_int,
    gather,
    gather_row,
    lanes,
    lanes_mask,
    lanes_u32,
    minimum,
    minimum_u32,
    to_uint,
    where,
)

#: Numbers of a sphere.
SPHERE = 4
#: Numbers of a box.
BOX = 7

#: Sine of the half angle of the disk that a delta light is taken for.
FINE = 2e-4
#: Radius of the part of that disk which shines. Within it the walk from a direction that leads
#: there ends at a solution that holds it, unless the last ray is far from linear in the first.
SHINING = 0.9

#: A light that is aimed at. light: u32, its row; c, radius: Vec3 and float, the middle and the
#: radius of its sphere, metres, or the direction to its disk and the sine of its half angle; far:
#: mask, it is infinitely far; delta: mask, it is a delta light, and the radius is `FINE`.
Target = namedtuple("Target", "light c radius far delta")


def has_far_target(program) -> bool:
    """Whether there may be a disk."""
    return any(LIGHTS[name].disk_of is not None for name in environments_of(program))


def has_targets(program) -> bool:
    """Whether there is anything to aim at."""
    return bool(on_shapes(program)) or has_far_target(program) or has_delta_lights(program)


def _delta_kinds(program):
    return tuple(name for name, m in LIGHTS.items() if name in program.lights and m.DELTA)


def _may_be_far(program) -> bool:
    """Whether there is a target that has no place."""
    return has_far_target(program) or any(LIGHTS[n].INFINITELY_FAR for n in _delta_kinds(program))


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
    return as_int(scene.lights.targets[_boxes(scene) - 2])


@kernel
def _boxes(scene):
    """Where the boxes of casters begin; uniform."""
    return (scene.lights.info.size // INFO) * (1 + SPHERE) + 3


@kernel
def _count_of_boxes(scene):
    """How many there are; uniform."""
    return as_int(scene.lights.targets[_boxes(scene) - 1])


@kernel
def end_of_boxes(scene):
    """Where the photons begin; uniform."""
    return _boxes(scene) + BOX * _count_of_boxes(scene)


@kernel
def way_to_caster(scene, p, u, u3):
    """(mask: there is one, vector from p to a point in the box of one).

    The box is chosen by u, the point by a triple of numbers, all uniform in [0, 1).
    """
    first = _boxes(scene)
    count = _count_of_boxes(scene)
    # One too many by rounding is the last one.
    number = minimum_u32(to_uint(u * (1.0 * count)), lanes_u32(0) + max(count, 1) - 1)
    # Without any, what is read is another table's.
    row = number * BOX + (first if count > 0 else 0)
    ax, ay, az, _ = gather_row(scene.lights.targets, row, 4)
    bx, by, bz, motion = gather_row(scene.lights.targets, row + 3, 4)
    x, y, z = u3
    point = Vec3(ax + x * (bx - ax), ay + y * (by - ay), az + z * (bz - az))
    there = lanes_mask(count > 0)
    return there, moved_along(scene, to_uint(where(there, motion, 0.0)), point) - p


@specialised
def target_at(program):
    """``target_at(scene, index)``: the `Target` in a row; the radius is 0 if it is none."""
    if "lights" not in program.motion:
        return target_at_rest

    @kernel
    def target_now(scene, index):
        target = target_at_rest(scene, index)
        number, c = lanes_u32(0) + gather(scene.motions.of_light, index), target.c
        moving = number != 0
        if any_lane(moving):
            m = matrix_at(scene.motions, where(moving, number - 1, 0), scene.time)
            c = where(moving, where(target.far, turned(m, c), placed(m, c)), c)
        return replace(target, c=c)

    return target_now


@kernel
def target_at_rest(scene, index):
    """The same before anything has moved."""
    start = scene.lights.info.size // INFO + 1
    x, y, z, radius = gather_row(scene.lights.targets, start + index * SPHERE, 4)
    delta = _is_delta(scene, index)
    return Target(index, Vec3(x, y, z), absolute(radius), radius < 0.0, delta)


@specialised
def _is_delta(program):
    """``(scene, index)``: mask of delta lights."""
    numbers = tuple(LIGHTS[name].number for name in _delta_kinds(program))

    @kernel
    def is_one_of_them(scene, index):
        kind, found = gather(scene.lights.info, index * INFO), lanes_mask(False)
        for number in numbers:
            found = found | (kind == number)
        return found

    return is_one_of_them if numbers else _never


@kernel
def _never(scene, index):
    return lanes_mask(False)


@specialised
def radius_at(program):
    """``radius_at(target, distance)``: of the target as seen from so far, in the same units."""
    if not has_delta_lights(program):

        @kernel
        def fixed(target, distance):
            return target.radius

        return fixed

    @kernel
    def by_angle(target, distance):
        return where(target.delta, target.radius * distance, target.radius)

    return by_angle


@specialised
def way_to(program):
    """``way_to(target, o)``: from places to the middle; of a disk, a unit vector."""
    if not _may_be_far(program):

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
    target = target_at(scene, lanes_u32(0) + far_light(scene))
    return target.far & ~target.delta & _is_within(target, d)


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
        inside = left & target.far & ~target.delta & _is_within(target, d)
        if any_lane(inside):
            found = where(inside, environment_radiance(scene, where(inside, d, 0.0)), found)
        return found

    return of_the_sky


@specialised
def end_at_point(program):
    """``(scene, target, o, d, t, last) -> (t, found)``: last rays of chains to delta lights.

    They meet nothing for t metres along unit directions; those of the mask `last` end at the light,
    if that is nearer. found: radiance of the disk that the light is taken for.
    """
    if not has_delta_lights(program):

        @kernel
        def without_them(scene, target, o, d, t, last):
            return t, target.c * 0.0

        return without_them

    own = sample_by_kind(_delta_kinds(program))
    if "lights" in program.motion:
        own = moving_sample(own)

    @kernel
    def of_the_disk(scene, target, o, d, t, last):
        found = target.c * 0.0
        last = last & target.delta
        if any_lane(last):
            half = lanes(0.5)
            s = own(scene, target.light, o, half, (half, half))
            along = dot(s.wi, d)
            across = length_squared(s.wi - along * d)
            size = SHINING * FINE
            inside = last & (along > 0.0) & (across <= size * size)
            free = t >= shadow_length(s.distance, s.cosine, s.error, 0.0)
            radiance = s.radiance * gather_vec3(scene.lights.data, target.light * STRIDE)
            found = where(inside & free, radiance * (INV_PI / (size * size)), found)
            t = where(inside & free, minimum(t, s.distance), t)
        return t, found

    return of_the_disk
