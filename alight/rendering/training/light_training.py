"""Light paths that train a guide: what arrives where, in place of a picture.

Where there are media, light paths collide in them too. They start in the medium of the camera,
until they cross the first border: a guide may know less of what is about a lamp that stands in
another one, but it leaves nothing out.
"""

from __future__ import annotations

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import is_mixed
from alight.bsdfs.flags import DELTA, NULL
from alight.core.constants import INFINITY
from alight.core.vec import length, luminance, max_component
from alight.guiding.light_records import record_arrivals
from alight.integrators.both_ends.light_walk import set_out, write_arrive, write_leave
from alight.integrators.caustics.chain_types import follows_chains
from alight.integrators.interiors.collisions import Turn, pass_media, turn_in_medium
from alight.integrators.interiors.enclosing import dimmed, left_along
from alight.integrators.interiors.volume_walk import first_channel, mean, medium_beyond
from alight.integrators.moments import at_times_of
from alight.integrators.queue import NO_HIT, empty_queue, put, take
from alight.integrators.roulette import play_roulette
from alight.integrators.walk import BSDF_DIRECTION, empty_paths, to_world, vertex_dimension
from alight.lights.emission.sampling import is_around
from alight.lights.misses import environments_of
from alight.rendering.tiles.tile_kernel import Cursor, count_cells, next_pixel, next_samples
from alight.samplers.sampling import get_2d
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import LANES, lanes, lanes_mask, lanes_vec3, mask_bits, maximum, where

#: Shortest way, metres.
SMALLEST = 1e-30


@specialised
def start_recorded(program):
    """``(scene, settings, new, sampler) -> path``: light paths in the lanes `new`.

    Their `delta` says that light sampling finds what they bring to the next surface. They gather no
    light: L.x is the length of their way since they were last scattered, from infinity on for
    lights that are there.
    """
    by_light = program.option("light_sampling") in ("mis", "emitter")
    count = max(len(program.environments), 1)
    around, media = bool(environments_of(program)), bool(program.media)

    @kernel
    def start(scene, settings, new, sampler):
        path, e = set_out(scene, settings, new, sampler)
        alone = e.delta_position | e.delta_direction
        far = e.delta_direction
        if around:
            far = far | is_around(scene, e.light, count)
        way = lanes_vec3(1.0) * where(far, INFINITY, 0.0)
        path = replace(path, L=way, delta=new if by_light else new & alone)
        if media:
            path = replace(path, channel=first_channel(sampler))
        return path

    return start


@specialised
def extend_recorded(program):
    """``(scene, settings, log, path) -> path``: one more vertex, and a record of it.

    There is none of vertices where only delta lobes scatter light, which ask no guide, and of light
    that light sampling finds.
    """
    if program.media:
        return _write_extend_in_media(program)
    arrive, leave = write_arrive(program), write_leave(program)
    # Light sampling looks straight through holes, and walks through mirrors and glass.
    found_through = NULL | DELTA if follows_chains(program) else NULL

    @kernel
    def extend(scene, settings, log, path):
        path, arrival = arrive(scene, path)
        p = arrival.surface.p
        way = path.L.x + length(p - path.o)
        # Active paths have an edge left for the way from here to the camera.
        seen = path.active
        on, flags = leave(scene, settings, path, arrival)
        delta = (flags & DELTA) != 0
        recorded = seen & ~path.delta & (~delta | is_mixed(scene, arrival.surface))
        near = 1.0 / maximum(way, SMALLEST)
        w = to_world(arrival.surface, arrival.wl)
        record_arrivals(log, p, w, luminance(path.beta), near, recorded)
        way = lanes_vec3(1.0) * where(delta, way, 0.0)
        return replace(on, L=way, delta=path.delta & ((flags & found_through) != 0))

    return extend


def _write_extend_in_media(program):
    """`extend_recorded` for paths that may collide before the next surface."""
    arrive, leave = write_arrive(program), write_leave(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def extend(scene, settings, log, path):
        way, depth = path.L.x, path.depth + 1
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        path, collided, t = pass_media(scene, path, hit.t)
        # Media that shine light no path from a lamp.
        path = replace(path, L=lanes_vec3(0.0))
        met, arrival = arrive(scene, replace(path, active=path.active & ~collided))
        path = replace(path, beta=dimmed(path.beta, left_along(path.bodies, t, collided)))
        surface = arrival.surface
        p = where(collided, path.o + t * path.d, surface.p)
        way = way + length(p - path.o)
        seen = met.active | collided
        on, flags = leave(scene, settings, met, arrival)
        on = replace(on, medium=medium_beyond(scene, surface, on.d, path.medium))
        delta = ~collided & ((flags & DELTA) != 0)
        recorded = seen & ~path.delta & (~delta | is_mixed(scene, surface))
        flux = luminance(where(collided, path.beta, met.beta)) / mean(path.ours)
        w = where(collided, -path.d, to_world(surface, arrival.wl))
        record_arrivals(log, p, w, flux, 1.0 / maximum(way, SMALLEST), recorded)

        dimension = vertex_dimension(depth + 1)
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        turn = Turn(path.d, lanes_vec3(1.0), lanes(1.0), lanes_mask(False))
        turn = turn_in_medium(scene, path, u2, collided, turn)
        going = collided & (depth + 1 < settings.max_depth)
        turned = replace(path, o=p, d=turn.d, p=p, depth=depth, active=going)
        if roulette:
            brightness = max_component(path.beta) / (mean(path.ours) * path.pdf)
            turned = play_roulette(settings, turned, dimension, brightness)
        on = where(collided, turned, on)
        way = lanes_vec3(1.0) * where(delta, way, 0.0)
        unseen = path.delta & ~collided & ((flags & NULL) != 0)
        return replace(on, L=way, delta=unseen, sampler=path.sampler, rays=met.rays)

    return extend


@kernel
def record_light_paths(scene, settings, tile, ranges, log):
    """Trace the light paths `ranges` of a tile of the small picture, and log where they arrive."""
    path, queue = empty_paths(), empty_queue(NO_HIT)
    cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
    _, cells = count_cells(tile)
    waiting = 0
    while True:
        if mask_bits(~path.active) != 0:
            waiting = put(queue, waiting, path, NO_HIT)
            if waiting >= LANES:
                waiting -= LANES
                path, _ = take(settings, queue, waiting, LANES, NO_HIT)
            elif cursor.cell < cells:
                cursor, new, sampler = next_samples(settings, tile, ranges, cursor)
                path = start_recorded(at_times_of(scene, sampler), settings, new, sampler)
            elif waiting > 0:
                path, _ = take(settings, queue, 0, waiting, NO_HIT)
                waiting = 0
            else:
                break
        path = extend_recorded(at_times_of(scene, path.sampler), settings, log, path)
