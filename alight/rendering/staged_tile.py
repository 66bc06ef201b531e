"""The main loop inside a tile where a step has two halves, between which paths wait for others.

Where there are bodies, paths wait in them too: one walk has a single scattering, another a
thousand. A packet of walks goes on together until a quarter of them have ended; the rest wait
again, until they fill a packet with those of other paths.
"""

from __future__ import annotations

from alight.bsdfs.switch import has_bodies
from alight.integrators.body_walk import walk_on
from alight.integrators.queue import (
    NO_HIT,
    empty_queue,
    no_walks_wait,
    put,
    put_walks,
    take,
    take_walks,
)
from alight.integrators.walk import empty_paths, is_staged, shade, trace
from alight.rendering.tile_kernel import (
    RAYS,
    Cursor,
    count_cells,
    finish,
    next_pixel,
    render_step_by_step,
    start,
)
from alight.shapes.hit import no_hit
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import LANES, mask_bits


@specialised
def render_tile_kernel(program):
    """Render the samples `ranges` of one tile into `film` (sums counts direct tally).

    ``render_tile_kernel(scene, settings, tile, ranges, film)``
    """
    if not is_staged(program):
        return render_step_by_step
    return render_bodies if has_bodies(program) else render_in_stages


@kernel
def render_in_stages(scene, settings, tile, ranges, film):
    """`render_step_by_step` where paths wait a second time, for others whose rays met a surface.

    Many rays of an open scene meet none. The packets that meet one are full again, and so are
    those of shadow rays.
    """
    path, hit = empty_paths(), no_hit()
    queue, met = empty_queue(NO_HIT), empty_queue(hit)
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    waiting, held, rays = 0, 0, 0
    while True:
        rest = False
        if mask_bits(~path.active) != 0:
            rays += path.rays
            waiting = put(queue, waiting, path, NO_HIT)
            if waiting >= LANES:
                waiting -= LANES
                path, _ = take(settings, queue, waiting, LANES, NO_HIT)
            elif cursor.cell < cells:
                cursor, path = start(scene, settings, tile, ranges, cursor)
            elif held > 0:
                rest = True
            elif waiting > 0:
                path, _ = take(settings, queue, 0, waiting, NO_HIT)
                waiting = 0
            else:
                break
        count = 0
        if rest:
            path, hit = take(settings, met, 0, held, hit)
            count, held = held, 0
        else:
            before = path.active
            path, hit = trace(scene, settings, path)
            finish(settings, tile, film, path, before)
            count = LANES
            if mask_bits(~path.active) != 0:
                rays += path.rays
                held = put(met, held, path, hit)
                count = 0
                if held >= LANES:
                    held, count = held - LANES, LANES
                path, hit = take(settings, met, held, count, hit)
        if count > 0:
            before = path.active
            path, _ = shade(scene, settings, path, hit)
            finish(settings, tile, film, path, before)
    film.tally[RAYS] += rays


@kernel
def render_bodies(scene, settings, tile, ranges, film):
    """`render_in_stages` where there are bodies, in which paths wait once more.

    When new paths start, less than two packets of paths and walks wait, and no step makes two of
    one: so walks never fill more than three packets.
    """
    path, hit = empty_paths(), no_hit()
    queue, met, walks = empty_queue(NO_HIT), empty_queue(hit), no_walks_wait()
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    waiting, held, inside, rays = 0, 0, 0, 0
    while True:
        rest, walking = False, 0
        if mask_bits(~path.active) != 0:
            rays += path.rays
            waiting = put(queue, waiting, path, NO_HIT)
            if waiting >= LANES:
                waiting -= LANES
                path, _ = take(settings, queue, waiting, LANES, NO_HIT)
            elif inside >= LANES:
                walking = LANES
            elif cursor.cell < cells:
                cursor, path = start(scene, settings, tile, ranges, cursor)
            elif held > 0:
                rest = True
            elif waiting > 0:
                path, _ = take(settings, queue, 0, waiting, NO_HIT)
                waiting = 0
            elif inside > 0:
                walking = inside
            else:
                break
        if walking > 0:
            inside -= walking
            path, walk = take_walks(settings, walks, inside, walking)
            before = path.active
            path, walk = walk_on(scene, path, walk, 3 * LANES // 4 if walking == LANES else 0)
            finish(settings, tile, film, path, before)
            inside = put_walks(walks, inside, path, walk)
            path = replace(path, active=path.active & ~walk.going)
            continue
        count = 0
        if rest:
            path, hit = take(settings, met, 0, held, hit)
            count, held = held, 0
        else:
            before = path.active
            path, hit = trace(scene, settings, path)
            finish(settings, tile, film, path, before)
            count = LANES
            if mask_bits(~path.active) != 0:
                rays += path.rays
                held = put(met, held, path, hit)
                count = 0
                if held >= LANES:
                    held, count = held - LANES, LANES
                path, hit = take(settings, met, held, count, hit)
        if count > 0:
            before = path.active
            path, walk = shade(scene, settings, path, hit)
            finish(settings, tile, film, path, before)
            inside = put_walks(walks, inside, path, walk)
            path = replace(path, active=path.active & ~walk.going)
    film.tally[RAYS] += rays
