"""What the main loop inside a tile does with samples and pixels.

It takes samples along the rows of cells, starts their camera rays, and adds what they have found to
the sums of the tile.
"""

from __future__ import annotations

from collections import namedtuple

from alight.cameras.rays import generate_ray
from alight.films.fixed_point import put_limbs
from alight.films.sample_ranges import CELL_SIZE
from alight.filters.importance import sample_filter
from alight.guiding.records import record_ends
from alight.integrators.aov import LayerFilm, add_layers
from alight.integrators.coverage import weigh
from alight.integrators.guided import is_guided
from alight.integrators.moments import at_times_of
from alight.integrators.shadow_catcher import ShadowFilm, catch_shadows
from alight.integrators.walk import (
    FILTER,
    LENS,
    begin_paths,
    count_lanes,
    empty_paths,
    no_paths,
    start_paths,
)
from alight.samplers.sampling import get_2d, sampler_state
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    LANES,
    WIDEST,
    any_lane,
    as_int,
    as_uint,
    is_finite,
    lane_index,
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

#: A tile: the pixels [x0, x1) x [y0, y1) of the full film.
Tile = namedtuple("Tile", "x0 y0 x1 y1")

#: Which sample a lane takes next: pixel, sample (index * replicates + scramble), how many samples
#: of the pixel are left, and the 8x8 cell that the pixel is in.
Cursor = namedtuple("Cursor", "x y index scramble left cell")

#: Lanes that start a path, their rays, the weight of the pixel filter, and the sampler.
CameraRays = namedtuple("CameraRays", "new o d weight sampler")

#: Memory for x, y, index and scramble of each lane's sample.
TAKEN = 4 * WIDEST

INVALID, SATURATED, RAYS = 0, 1, 2


@kernel
def count_cells(tile):
    """Columns and total of the 8x8 cells of the full film that a tile touches."""
    columns = (tile.x1 + CELL_SIZE - 1) // CELL_SIZE - tile.x0 // CELL_SIZE
    return columns, columns * ((tile.y1 + CELL_SIZE - 1) // CELL_SIZE - tile.y0 // CELL_SIZE)


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

    A cursor with x < 0 is before the first pixel of its cell.
    """
    x, y, cell = cursor.x, cursor.y, cursor.cell
    columns, cells = count_cells(tile)
    first, count = 0, 0
    while cell < cells:
        left = (tile.x0 // CELL_SIZE + cell % columns) * CELL_SIZE
        top = (tile.y0 // CELL_SIZE + cell // columns) * CELL_SIZE
        cx0, cy0 = max(left, tile.x0), max(top, tile.y0)
        cx1, cy1 = min(left + CELL_SIZE, tile.x1), min(top + CELL_SIZE, tile.y1)
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
def next_samples(settings, tile, ranges, cursor):
    """The next packet of samples: (cursor, mask of the lanes that have one, `SamplerState`)."""
    _, cells = count_cells(tile)
    taken = local_uints(TAKEN)
    count = 0
    while count < LANES and cursor.cell < cells:
        taken[count] = as_uint(cursor.x)
        taken[LANES + count] = as_uint(cursor.y)
        taken[2 * LANES + count] = as_uint(cursor.index)
        taken[3 * LANES + count] = as_uint(cursor.scramble)
        count += 1
        if cursor.left > 1:
            cursor = next_sample(settings, cursor)
        else:
            cursor = next_pixel(settings, tile, ranges, cursor)
    for i in range(count, LANES):
        # Nobody sees what lanes without a sample do, but they do it with numbers of their own.
        taken[i], taken[LANES + i], taken[3 * LANES + i] = as_uint(0), as_uint(0), as_uint(0)
        taken[2 * LANES + i] = as_uint(-1 - i)
    x, y = load_lanes(taken, 0), load_lanes(taken, LANES)
    sampler = sampler_state(
        x, y, load_lanes(taken, 2 * LANES), load_lanes(taken, 3 * LANES), lanes_u32(settings.seed)
    )
    return cursor, lane_index() < count, sampler


@kernel
def camera_rays(scene, settings, tile, ranges, cursor):
    """The next packet of samples, as `CameraRays`; returns the cursor too.

    All lanes start together, on one pixel or its neighbours, so that their first steps look at
    the same things.
    """
    cursor, new, sampler = next_samples(settings, tile, ranges, cursor)
    x, y = sampler.x, sampler.y
    # Filter importance sampling: the sample belongs to this pixel alone, at an offset that has
    # the filter's density (Ernst, Stamminger and Greiner 2006).
    dx, dy, weight = sample_filter(scene, get_2d(sampler, FILTER))
    seen = at_times_of(scene, sampler)
    o, d = generate_ray(seen, to_float(x) + 0.5 + dx, to_float(y) + 0.5 + dy, get_2d(sampler, LENS))
    return cursor, CameraRays(new, o, d, weight, sampler)


@kernel
def start(scene, settings, tile, ranges, cursor):
    """The next packet of samples as paths before their first step; returns the cursor too."""
    cursor, rays = camera_rays(scene, settings, tile, ranges, cursor)
    paths = start_paths(rays.new, rays.o, rays.d, rays.weight, rays.sampler, empty_paths())
    return cursor, paths


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


@specialised
def finish(program):
    """Add the paths that have ended since they were active in the lanes of `before`.

    ``finish(settings, tile, film, path, before)``
    """
    guided = is_guided(program)

    @kernel
    def finish(settings, tile, film, path, before):
        finished = before & ~path.active
        if any_lane(finished):
            add_finished(settings, tile, film, path, finished)
            if guided and settings.log.ends.size > 0:
                record_ends(settings.log, path, finished)

    return finish


@kernel
def render_layers(scene, settings, tile, ranges, wanted, sums):
    """Render layers (`alight.integrators.aov`) of the samples `ranges` of one tile."""
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    film = LayerFilm(tile, wanted, sums)
    while cursor.cell < cells:
        cursor, rays = camera_rays(scene, settings, tile, ranges, cursor)
        path = begin_paths(rays.new, rays.o, rays.d, rays.weight, rays.sampler, no_paths())
        add_layers(scene, settings, film, path)


@kernel
def render_coverage(scene, settings, tile, ranges, table):
    """Weigh the surfaces that the samples `ranges` of one tile meet (`WeightTable`)."""
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    while cursor.cell < cells:
        cursor, rays = camera_rays(scene, settings, tile, ranges, cursor)
        path = begin_paths(rays.new, rays.o, rays.d, rays.weight, rays.sampler, no_paths())
        weigh(scene, table, path)


@kernel
def render_shadows(scene, settings, tile, ranges, ground, sums):
    """Render the shadows on the `Ground` of the samples `ranges` of one tile."""
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    film = ShadowFilm(tile, 1, sums, ground)
    while cursor.cell < cells:
        cursor, rays = camera_rays(scene, settings, tile, ranges, cursor)
        path = begin_paths(rays.new, rays.o, rays.d, rays.weight, rays.sampler, no_paths())
        catch_shadows(scene, film, path)
