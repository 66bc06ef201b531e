"""The main loop of light paths: a tile says which of them start, they find their pixels themselves.

Sample i of a pixel is a light path like any other, named by that pixel and i; it counts there, and
may add light anywhere in the window. With as many paths a pixel as the picture has samples, the sum
of a pixel over its count is its mean over all paths, once each path adds its light over the number
of pixels: so films of light paths are summed, resumed and merged as any others are.
"""

from __future__ import annotations

from alight.films.fixed_point import put_limbs
from alight.integrators.model import model_of
from alight.integrators.moments import at_times_of
from alight.integrators.queue import NO_HIT, empty_queue, put, take
from alight.integrators.walk import count_lanes, empty_paths
from alight.rendering.tiles.tile_kernel import (
    INVALID,
    RAYS,
    SATURATED,
    Cursor,
    count_cells,
    next_pixel,
    next_samples,
)
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    LANES,
    as_float,
    as_int,
    is_finite,
    lanes_vec3,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    to_uint,
    trailing_zeros,
    where,
)


@specialised
def begin(program):
    """``begin(scene, settings, new, sampler) -> (path, splat)`` of the program's integrator."""
    own = model_of(program).begin
    assert own is not None
    return own(program)


@specialised
def extend(program):
    """``extend(scene, settings, path) -> (path, splat)`` of the program's integrator."""
    own = model_of(program).extend
    assert own is not None
    return own(program)


@kernel(strict=True)
def add_splats(settings, window, film, scramble, splat):
    """Add splats to the sums of the window, exactly; those beside it are lost."""
    limbs = local_floats(16 * 6)
    pixels, replicates = local_uints(16), local_uints(16)
    width, height = window.x1 - window.x0, window.y1 - window.y0
    x, y = splat.x - as_float(window.x0), splat.y - as_float(window.y0)
    lit = splat.lit & (x >= 0.0) & (x < as_float(width)) & (y >= 0.0) & (y < as_float(height))
    value = splat.value * (1.0 / as_float(width * height))
    valid = is_finite(value.x) & is_finite(value.y) & is_finite(value.z)
    value = where(valid, value, lanes_vec3(0.0))
    saturated = put_limbs(limbs, 0, value.x)
    saturated = saturated | put_limbs(limbs, 1, value.y)
    saturated = saturated | put_limbs(limbs, 2, value.z)
    film.tally[INVALID] += count_lanes(lit & ~valid)
    film.tally[SATURATED] += count_lanes(lit & saturated)
    store_lanes(pixels, 0, to_uint(where(lit, y, 0.0)) * width + to_uint(where(lit, x, 0.0)))
    store_lanes(replicates, 0, scramble)
    bits = mask_bits(lit)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = as_int(pixels[lane]) * settings.replicates + as_int(replicates[lane])
        for i in range(6):
            film.sums[at * 6 + i] += as_int(limbs[i * LANES + lane])


@kernel
def count_paths(settings, window, film, new, sampler):
    """Count the paths that start, each at the pixel that names it."""
    pixels, replicates = local_uints(16), local_uints(16)
    x, y = sampler.x - window.x0, sampler.y - window.y0
    store_lanes(pixels, 0, y * (window.x1 - window.x0) + x)
    store_lanes(replicates, 0, sampler.scramble)
    bits = mask_bits(new)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = as_int(pixels[lane]) * settings.replicates + as_int(replicates[lane])
        film.counts[at] += 1


@kernel
def render_light_tile(scene, settings, places, ranges, film):
    """Trace the light paths `ranges` of a tile into `film`, that of a window.

    places: (tile, window), both of `Tile`.
    """
    tile, window = places
    path, queue = empty_paths(), empty_queue(NO_HIT)
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    waiting, rays = 0, 0
    while True:
        if mask_bits(~path.active) != 0:
            rays += path.rays
            waiting = put(queue, waiting, path, NO_HIT)
            if waiting >= LANES:
                waiting -= LANES
                path, _ = take(settings, queue, waiting, LANES, NO_HIT)
            elif cursor.cell < cells:
                cursor, new, sampler = next_samples(settings, tile, ranges, cursor)
                count_paths(settings, window, film, new, sampler)
                path, splat = begin(at_times_of(scene, sampler), settings, new, sampler)
                add_splats(settings, window, film, sampler.scramble, splat)
            elif waiting > 0:
                path, _ = take(settings, queue, 0, waiting, NO_HIT)
                waiting = 0
            else:
                break
        scramble = path.sampler.scramble
        path, splat = extend(at_times_of(scene, path.sampler), settings, path)
        add_splats(settings, window, film, scramble, splat)
    film.tally[RAYS] += rays
