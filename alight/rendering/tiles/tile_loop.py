"""The main loop inside a tile: start paths, extend them, add the finished ones to the film.

A packet's samples take their first step together. Where some paths end, the others wait in a queue,
from which the next packet is taken as soon as they fill one; so packets stay full although paths
differ in length, and hold paths of the same pixel and depth, whose rays go the same way (the
regeneration and compaction of paths of Wald 2011, Active thread compaction for GPU path tracing).

Where a step has two halves, paths wait a second time, for others whose rays met a surface: many
rays of an open scene meet none. The packets that meet one are full again, and so are those of
shadow rays.

Where there are bodies, paths wait in them too: one walk has a single scattering, another a
thousand. A packet of walks goes on together until a quarter of them have ended; the rest wait
again, until they fill a packet with those of other paths.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from alight.bsdfs.switch import has_bodies
from alight.integrators.interiors.body_walk import walk_on
from alight.integrators.queue import (
    NO_HIT,
    empty_queue,
    no_walks_wait,
    put,
    put_walks,
    take,
    take_walks,
)
from alight.integrators.walk import empty_paths, is_staged, shade, step, trace
from alight.rendering.tiles.tile_kernel import RAYS, Cursor, count_cells, finish, next_pixel, start
from alight.shapes.hit import no_hit
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import LANES, mask_bits


@specialised
def render_tile_kernel(program):
    """Render the samples `ranges` of one tile into `film` (sums counts direct tally).

    ``render_tile_kernel(scene, settings, tile, ranges, film)``
    """
    staged = is_staged(program)
    return tile_loop(staged, staged and has_bodies(program))


@specialised
def render_step_by_step(program):
    """As `render_tile_kernel`, with steps in one piece for any integrator."""
    return tile_loop(staged=False, bodies=False)


@cache
def tile_loop(staged, bodies):
    """The loop as a kernel; `staged` if a step has two halves, `bodies` if paths wait in some.

    When new paths start, less than two packets of paths and walks wait, and no step makes two of
    one: so walks never fill more than three packets.
    """
    # What is named here is written for the program, and some programs have no halves, or no bodies.
    halves: Any = (trace, shade) if staged else (None, None)
    first_half, second_half = halves
    whole: Any = None if staged else step
    walk_inside: Any = walk_on if bodies else None
    nothing: Any = ()

    @kernel
    def render_samples(scene, settings, tile, ranges, film):
        path, hit = empty_paths(), no_hit()
        queue = empty_queue(NO_HIT)
        met = empty_queue(hit) if staged else nothing
        walks = no_walks_wait() if bodies else nothing
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
            if bodies and walking > 0:
                inside -= walking
                path, walk = take_walks(settings, walks, inside, walking)
                before = path.active
                enough = 3 * LANES // 4 if walking == LANES else 0
                path, walk = walk_inside(scene, path, walk, enough)
                finish(settings, tile, film, path, before)
                inside = put_walks(walks, inside, path, walk)
                path = replace(path, active=path.active & ~walk.going)
                continue
            count = LANES
            before = path.active
            if staged:
                if rest:
                    path, hit = take(settings, met, 0, held, hit)
                    count, held = held, 0
                else:
                    path, hit = first_half(scene, settings, path)
                    finish(settings, tile, film, path, before)
                    if mask_bits(~path.active) != 0:
                        rays += path.rays
                        held = put(met, held, path, hit)
                        count = 0
                        if held >= LANES:
                            held, count = held - LANES, LANES
                        path, hit = take(settings, met, held, count, hit)
                before = path.active
            if count > 0:
                if staged:
                    path, walk = second_half(scene, settings, path, hit)
                else:
                    path, walk = whole(scene, settings, path), nothing
                finish(settings, tile, film, path, before)
                if bodies:
                    inside = put_walks(walks, inside, path, walk)
                    path = replace(path, active=path.active & ~walk.going)
        film.tally[RAYS] += rays

    return render_samples
