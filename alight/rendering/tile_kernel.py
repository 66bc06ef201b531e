"""The main loop inside a tile: start paths, carry them on, add the finished ones to the film.

Lanes are *persistent*: a lane whose path has ended takes the next sample of the tile at once, so
that packets stay full although paths differ in length (Aila and Laine 2009 call it dynamic fetch).
"""

from __future__ import annotations

from collections import namedtuple

from alight.cameras.rays import generate_ray
from alight.core.jit import kernel, specialised
from alight.core.simd import (
    LANES,
    any_lane,
    as_int,
    as_uint,
    bits_mask,
    count_bits,
    expand_lanes,
    is_finite,
    lanes_u32,
    lanes_vec3,
    load_lanes,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    to_float,
    trailing_zeros,
    where,
)
from alight.core.vec import Vec3
from alight.films.fixed_point import split
from alight.filters.importance import sample_filter
from alight.integrators.walk import FILTER, LENS, count_lanes, empty_paths, start_paths, step
from alight.samplers.sampling import get_2d, sampler_state
from alight.samplers.state import SamplerState

#: A tile: the pixels [x0, x1) x [y0, y1) of the full film.
Tile = namedtuple("Tile", "x0 y0 x1 y1")

#: Which sample a lane takes next: pixel, sample (index * replicates + scramble), how many samples
#: of the pixel are left, and the 8x8 cell that the pixel is in.
Cursor = namedtuple("Cursor", "x y index scramble left cell")

#: Samples that wait: `floats` holds rows of o, d and the filter's weight, `uints` rows of x, y,
#: index, scramble and the keys a, b of the sampler. A row has room for two packets, so that a
#: packet's worth can be read from any place in the first.
Queue = namedtuple("Queue", "floats uints")
ROOM = 32
FLOATS, UINTS = 7 * ROOM, 6 * ROOM

CELL = 8
INVALID, SATURATED, RAYS = 0, 1, 2


@kernel
def count_cells(tile):
    """Columns and total of the 8x8 cells of the full film that a tile touches."""
    columns = (tile.x1 + CELL - 1) // CELL - tile.x0 // CELL
    return columns, columns * ((tile.y1 + CELL - 1) // CELL - tile.y0 // CELL)


@kernel
def next_sample(settings, cursor):
    """The next sample of the same pixel, without a division."""
    index, scramble = cursor.index, cursor.scramble + 1
    if scramble == settings.replicates:
        index, scramble = index + 1, 0
    return Cursor(cursor.x, cursor.y, index, scramble, cursor.left - 1, cursor.cell)


@kernel
def next_pixel(settings, tile, ranges, cursor):
    """The first sample of the next pixel: along the rows of a cell, then cell by cell.

    A cursor with x < 0 stands before the first pixel of its cell.
    """
    x, y, cell = cursor.x, cursor.y, cursor.cell
    columns, cells = count_cells(tile)
    first, count = 0, 0
    while cell < cells:
        left = (tile.x0 // CELL + cell % columns) * CELL
        top = (tile.y0 // CELL + cell // columns) * CELL
        cx0, cy0 = max(left, tile.x0), max(top, tile.y0)
        cx1, cy1 = min(left + CELL, tile.x1), min(top + CELL, tile.y1)
        first, count = ranges[2 * cell], ranges[2 * cell + 1]
        if count > 0:
            if x < 0:
                x, y = cx0, cy0
            else:
                x += 1
                if x >= cx1:
                    x, y = cx0, y + 1
            if y < cy1:
                break
        x = -1
        cell += 1
    replicates = settings.replicates
    return Cursor(x, y, first // replicates, first % replicates, count, cell)


@kernel
def fill(scene, settings, tile, ranges, cursor, queue):
    """Make camera rays for the next packet of samples; returns the cursor and how many there are.

    Lanes of the packet run empty a few at a time; making the rays for those few would keep the
    other lanes of the processor idle.
    """
    _, cells = count_cells(tile)
    floats, uints = queue.floats, queue.uints
    count = 0
    while count < LANES and cursor.cell < cells:
        uints[count] = as_uint(cursor.x)
        uints[ROOM + count] = as_uint(cursor.y)
        uints[2 * ROOM + count] = as_uint(cursor.index)
        uints[3 * ROOM + count] = as_uint(cursor.scramble)
        count += 1
        if cursor.left > 1:
            cursor = next_sample(settings, cursor)
        else:
            cursor = next_pixel(settings, tile, ranges, cursor)
    x, y = load_lanes(uints, 0), load_lanes(uints, ROOM)
    sampler = sampler_state(
        x, y, load_lanes(uints, 2 * ROOM), load_lanes(uints, 3 * ROOM), lanes_u32(settings.seed)
    )
    # Filter importance sampling: the sample belongs to this pixel alone, at an offset that has
    # the filter's density (Ernst, Stamminger and Greiner 2006).
    dx, dy, weight = sample_filter(scene, get_2d(sampler, FILTER))
    o, d = generate_ray(
        scene, to_float(x) + 0.5 + dx, to_float(y) + 0.5 + dy, get_2d(sampler, LENS)
    )
    store_lanes(uints, 4 * ROOM, sampler.a)
    store_lanes(uints, 5 * ROOM, sampler.b)
    store_lanes(floats, 0, o.x)
    store_lanes(floats, ROOM, o.y)
    store_lanes(floats, 2 * ROOM, o.z)
    store_lanes(floats, 3 * ROOM, d.x)
    store_lanes(floats, 4 * ROOM, d.y)
    store_lanes(floats, 5 * ROOM, d.z)
    store_lanes(floats, 6 * ROOM, weight)
    return cursor, count


@kernel
def first_bits(bits, count):
    """The lowest `count` of the bits that are set."""
    rest = bits
    for _ in range(count):
        rest &= rest - 1
    return bits & ~rest


@kernel
def deal(settings, queue, at, new, path):
    """Start paths in the lanes of `new` with the samples from number `at` of the queue."""
    floats, uints, old = queue.floats, queue.uints, path.sampler
    sampler = SamplerState(
        expand_lanes(uints, at, new, old.x),
        expand_lanes(uints, ROOM + at, new, old.y),
        expand_lanes(uints, 2 * ROOM + at, new, old.index),
        expand_lanes(uints, 3 * ROOM + at, new, old.scramble),
        lanes_u32(settings.seed),
        expand_lanes(uints, 4 * ROOM + at, new, old.a),
        expand_lanes(uints, 5 * ROOM + at, new, old.b),
    )
    o = Vec3(
        expand_lanes(floats, at, new, path.o.x),
        expand_lanes(floats, ROOM + at, new, path.o.y),
        expand_lanes(floats, 2 * ROOM + at, new, path.o.z),
    )
    d = Vec3(
        expand_lanes(floats, 3 * ROOM + at, new, path.d.x),
        expand_lanes(floats, 4 * ROOM + at, new, path.d.y),
        expand_lanes(floats, 5 * ROOM + at, new, path.d.z),
    )
    weight = expand_lanes(floats, 6 * ROOM + at, new, 0.0)
    return start_paths(new, o, d, weight, sampler, path)


@specialised
def add_finished(program):
    """Add the radiance of finished paths to the sums of the tile, exactly."""
    split_direct = "direct" in program.aovs

    @kernel(strict=True)
    def add_finished(settings, tile, film, path, finished):
        limbs = local_floats(16 * 12)
        pixels, replicates = local_uints(16), local_uints(16)
        # A sample with one channel that is not a number adds nothing to the others either.
        valid = is_finite(path.L.x) & is_finite(path.L.y) & is_finite(path.L.z)
        L = where(valid, path.L, lanes_vec3(0.0))
        saturated = put_limbs(limbs, 0, L.x)
        saturated = saturated | put_limbs(limbs, 1, L.y)
        saturated = saturated | put_limbs(limbs, 2, L.z)
        if split_direct:
            direct = where(valid, path.L_direct, lanes_vec3(0.0))
            put_limbs(limbs, 3, direct.x)
            put_limbs(limbs, 4, direct.y)
            put_limbs(limbs, 5, direct.z)
        film.tally[INVALID] += count_lanes(finished & ~valid)
        film.tally[SATURATED] += count_lanes(finished & saturated)
        x, y = path.sampler.x - tile.x0, path.sampler.y - tile.y0
        store_lanes(pixels, 0, y * (tile.x1 - tile.x0) + x)
        store_lanes(replicates, 0, path.sampler.scramble)
        bits = mask_bits(finished)
        while bits != 0:
            lane = trailing_zeros(bits)
            bits &= bits - 1
            pixel = as_int(pixels[lane])
            at = pixel * settings.replicates + as_int(replicates[lane])
            film.counts[at] += 1
            for i in range(6):
                film.sums[at * 6 + i] += as_int(limbs[i * LANES + lane])
            if split_direct:
                for i in range(6):
                    film.direct[pixel * 6 + i] += as_int(limbs[(6 + i) * LANES + lane])

    return add_finished


@kernel(strict=True)
def put_limbs(limbs, channel, value):
    """Store both limbs of one channel; returns where it was saturated."""
    parts = split(value)
    store_lanes(limbs, (2 * channel) * LANES, parts.hi)
    store_lanes(limbs, (2 * channel + 1) * LANES, parts.lo)
    return parts.saturated


@kernel
def render_tile_kernel(scene, settings, tile, ranges, film):
    """Render the samples `ranges` of one tile into `film` (sums counts direct tally)."""
    path = empty_paths()
    queue = Queue(local_floats(FLOATS), local_uints(UINTS))
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    taken, waiting = 0, 0
    while True:
        idle = mask_bits(~path.active)
        while idle != 0:
            if waiting == 0:
                if cursor.cell >= cells:
                    break
                cursor, waiting = fill(scene, settings, tile, ranges, cursor, queue)
                taken = 0
            count = min(count_bits(idle), waiting)
            new = first_bits(idle, count)
            path = deal(settings, queue, taken, bits_mask(new), path)
            idle &= ~new
            taken += count
            waiting -= count
        if not any_lane(path.active):
            break
        before = path.active
        path = step(scene, settings, path)
        finished = before & ~path.active
        if any_lane(finished):
            add_finished(settings, tile, film, path, finished)
    film.tally[RAYS] += path.rays
