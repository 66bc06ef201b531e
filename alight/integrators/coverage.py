"""Coverage: the surface that each sample of a pixel meets first.

Samples follow the picture's own paths through what the camera sees through, the holes of a mask
and, where `hide_emitters` says so, lights; so a sample counts here if and only if the picture's has
met a surface. A picture without its surroundings is premultiplied by the layer ``alpha``, which is
the sum of all weights; by surface they are what a Cryptomatte is made of (`alight.films.coverage`).

At the partly opaque places of a mask each sample chooses, by the very random numbers of the
picture, whether it is stopped: the mean is the opacity. Glass and mirrors are surfaces like others.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import sample_bsdf
from alight.bsdfs.flags import NULL
from alight.bsdfs.switch import has_null
from alight.core.constants import INFINITY
from alight.films.fixed_point import put_limbs
from alight.integrators.moments import at_times_of
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    LANES,
    any_lane,
    as_int,
    lanes,
    lanes_mask,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    trailing_zeros,
    where,
)

#: The weights of a tile, as a list for each pixel; int64. last: of each pixel the entry that was
#: made last, + 1, or 0. keys: of each entry its pixel, shifted up by `ROW_BITS`, and the row of its
#: shape. before: the entry before it, as in last. sums: two limbs an entry. used: their number.
WeightTable = namedtuple("WeightTable", "tile last keys before sums used")

#: Of a key that say the row.
ROW_BITS = 32


def write_cover(program, add, leave: Any = None):
    """``(scene, film, path)``: find what the samples of a packet meet.

    ``add(film, path, hit, mask)`` is called for the lanes whose paths have met a surface,
    ``leave(scene, film, path, mask)`` for those whose rays have left the scene; the filter's weight
    is ``path.beta``.
    """
    leaves = leave is not None
    hides, holes = program.option("hide_emitters", False), has_null(program)

    @kernel
    def cover(scene, film, path):
        while any_lane(path.active):
            hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
            active = path.active & (hit.t < INFINITY)
            if leaves:
                leave(scene, film, path, path.active & ~active)
            surface = make_surface(scene, hit, path.o, path.d, active)
            passes, o, d = lanes_mask(False), path.o, path.d
            if holes:
                # The very random numbers of the picture: the same holes.
                wo = to_local(surface, -path.d)
                dimension = vertex_dimension(path.depth + 1)
                u = get_1d(path.sampler, dimension + BSDF_CHOICE)
                u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
                wi, _, _, flags = sample_bsdf(scene, surface, wo, u, u2, active)
                passes = active & ((flags & NULL) != 0)
                d = to_world(surface, wi)
                o = spawn_origin(surface.p, surface.error, surface.ng, d)
            depth = path.depth + 1
            if hides:
                # A light is no vertex of the path.
                hidden = active & (surface.light != 0)
                beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
                o, d = where(hidden, beyond, o), where(hidden, path.d, d)
                depth = where(hidden, path.depth, depth)
                passes = passes | hidden
            add(film, path, hit, active & ~passes)
            path = replace(path, o=o, d=d, depth=depth, active=passes)

    return cover


@specialised
def weigh(program):
    """``weigh(scene, table, path)``: add the weights of a packet of camera rays to a table."""
    cover = write_cover(program, add_weight)

    @kernel
    def weigh(scene, table, path):
        cover(at_times_of(scene, path.sampler), table, path)

    return weigh


@kernel(strict=True)
def add_weight(table, path, hit, mask):
    """Add the weights of the samples in the lanes of the mask, exactly."""
    limbs, pixels, rows = local_floats(16 * 2), local_uints(16), local_uints(16)
    put_limbs(limbs, 0, path.beta.x)
    tile = table.tile
    width = tile.x1 - tile.x0
    store_lanes(pixels, 0, (path.sampler.y - tile.y0) * width + (path.sampler.x - tile.x0))
    store_lanes(rows, 0, hit.shape)
    bits = mask_bits(mask)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        pixel = as_int(pixels[lane])
        key = (pixel << ROW_BITS) | as_int(rows[lane])
        entry = table.last[pixel]
        while entry != 0 and table.keys[entry - 1] != key:
            entry = table.before[entry - 1]
        if entry == 0:
            entry = table.used[0] + 1
            table.used[0] = entry
            table.keys[entry - 1] = key
            table.before[entry - 1] = table.last[pixel]
            table.last[pixel] = entry
        table.sums[2 * entry - 2] += as_int(limbs[lane])
        table.sums[2 * entry - 1] += as_int(limbs[LANES + lane])
