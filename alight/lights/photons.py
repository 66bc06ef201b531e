"""Photons: where light of a target has met a matte surface, after mirrors and clear glass.

Each remembers the last mirror or piece of glass on its way. Seen from a place near by, that is a
good direction to begin a search for the same lamp with (`alight.integrators.caustics`): the more
light comes by some way, the more photons tell of it. They are found by the cell of a grid that they
lie in, and by their light; cells share buckets, by a hash. What a photon says is a guess, so
neither a collision nor a cell at the edge of a caustic does any harm.

`LightTables.targets` ends with them, where there are any: 1 / edge of a cell, per metre; for each
bucket the number of its first photon, and how many there are; then a point a photon, metres.

Source: Jensen, Global illumination using photon maps, EGWR 1996; Weber et al., Efficient caustic
rendering with lightweight photon mapping, 2018, for photons that only guide.
"""

from __future__ import annotations

from alight.core.rng import mix
from alight.core.vec import gather_vec3
from alight.lights.targets import end_of_boxes
from lanewise.jit import kernel
from lanewise.simd import floor, gather, lanes_mask, lanes_u32, minimum, to_uint, where

#: Buckets of cells, a power of two.
BUCKETS = 1 << 15

#: Cells are counted from so far below the origin.
_BELOW = 32768.0


@kernel
def _cell(x, per_edge):
    return to_uint(floor(x * per_edge) + _BELOW)


@kernel
def bucket_of(p, light, per_edge):
    """Number of the bucket of photons of a light (u32, its row) about the points p."""
    along = mix(_cell(p.x, per_edge) ^ (light << 16))
    return mix(mix(along + _cell(p.y, per_edge)) + _cell(p.z, per_edge)) & (BUCKETS - 1)


@kernel
def way_of_photon(scene, p, light, u):
    """(mask: there is one, vector from p to where its light has come from).

    It is chosen by u, uniform in [0, 1), among those of a light (u32, its row) about p.
    """
    first = end_of_boxes(scene)
    there = lanes_mask(scene.lights.targets.size > first)
    # Without any, what is read is another table's.
    row = first if scene.lights.targets.size > first else 0
    bucket = where(there, bucket_of(p, light, scene.lights.targets[row]), lanes_u32(0))
    begin = gather(scene.lights.targets, bucket + (row + 1))
    count = gather(scene.lights.targets, bucket + (row + 2)) - begin
    there = there & (count > 0.0)
    number = begin + minimum(floor(u * count), count - 1.0)
    place = (row + BUCKETS + 2) + to_uint(where(there, number, 0.0)) * 3
    point = gather_vec3(scene.lights.targets, where(there, place, lanes_u32(0)))
    return there, point - p
