"""Photons: where light of a target has met a matte surface, after mirrors and clear glass.

Each remembers the last mirror or piece of glass on its way. Seen from a place near by, that is a
good direction to begin a search for the same lamp with (`alight.integrators.caustics`): the more
light comes by some way, the more photons tell of it. They are found by the cell of a grid that they
lie in, and by their light; cells share buckets, by a hash. What a photon says is a guess, so
neither a collision nor a cell at the edge of a caustic does any harm.

Where shapes or lights move, each also has a time, of which its bucket knows the slot, and the point
that it remembers goes along with its mirror or glass.

`LightTables.targets` ends with them, where there are any: 1 / edge of a cell, per metre; for each
bucket the number of its first photon, and how many there are; then a point a photon, metres, in
scenes where something moves at rest, with the number of its motion (`alight.core.motion.Motions`).

Source: Jensen, Global illumination using photon maps, EGWR 1996; Weber et al., Efficient caustic
rendering with lightweight photon mapping, 2018, for photons that only guide.
"""

from __future__ import annotations

from alight.core.motion import moved_along
from alight.core.rng import mix
from alight.core.vec import Vec3, gather_vec3
from alight.lights.targets import end_of_boxes
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    floor,
    gather,
    gather_row,
    lanes_mask,
    lanes_u32,
    minimum,
    minimum_u32,
    to_uint,
    where,
)

#: Buckets of cells, a power of two.
BUCKETS = 1 << 15

#: Parts of the shutter's time, a power of two.
SLOTS = 8

#: Cells are counted from so far below the origin.
_BELOW = 32768.0


@kernel
def _cell(x, per_edge):
    return to_uint(floor(x * per_edge) + _BELOW)


@kernel
def bucket_of(p, key, per_edge):
    """Number of the bucket of photons of a `key_of` about the points p."""
    along = mix(_cell(p.x, per_edge) ^ (key << 16))
    return mix(mix(along + _cell(p.y, per_edge)) + _cell(p.z, per_edge)) & (BUCKETS - 1)


def are_in_motion(program) -> bool:
    """Whether photons of one time are of no use at others."""
    return "shapes" in program.motion or "lights" in program.motion


@specialised
def key_of(program):
    """``key_of(scene, light)``: of photons of a light (u32, its row) at the time of the path."""
    if not are_in_motion(program):
        return _of_any_time

    @kernel
    def by_slot(scene, light):
        return light * SLOTS + minimum_u32(to_uint(scene.time * SLOTS), lanes_u32(SLOTS - 1))

    return by_slot


@kernel
def _of_any_time(scene, light):
    return light


@specialised
def _point_of(program):
    """``(scene, start, number, there)``: the points of photons (float), the first is at start."""
    if not are_in_motion(program):

        @kernel
        def at_rest(scene, start, number, there):
            place = start + to_uint(where(there, number, 0.0)) * 3
            return gather_vec3(scene.lights.targets, where(there, place, lanes_u32(0)))

        return at_rest

    @kernel
    def where_it_is_now(scene, start, number, there):
        place = start + to_uint(where(there, number, 0.0)) * 4
        table, place = scene.lights.targets, where(there, place, lanes_u32(0))
        x, y, z, motion = gather_row(table, place, 4)
        return moved_along(scene, to_uint(where(there, motion, 0.0)), Vec3(x, y, z))

    return where_it_is_now


@kernel
def way_of_photon(scene, p, light, u):
    """(mask: there is one, vector from p to where its light has come from).

    It is chosen by u, uniform in [0, 1), among those of a light (u32, its row) about p.
    """
    first = end_of_boxes(scene)
    there = lanes_mask(scene.lights.targets.size > first)
    # Without any, what is read is another table's.
    row = first if scene.lights.targets.size > first else 0
    bucket = bucket_of(p, key_of(scene, light), scene.lights.targets[row])
    bucket = where(there, bucket, lanes_u32(0))
    begin = gather(scene.lights.targets, bucket + (row + 1))
    count = gather(scene.lights.targets, bucket + (row + 2)) - begin
    there = there & (count > 0.0)
    number = begin + minimum(floor(u * count), count - 1.0)
    return there, _point_of(scene, row + (BUCKETS + 2), number, there) - p
