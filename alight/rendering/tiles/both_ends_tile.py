"""The main loop of paths from both ends: whole samples, packet by packet.

Each lane traces its light path to the end and keeps the vertices in memory of the packet, then its
camera path, each vertex of which is joined to all of them. What light paths add to the picture goes
the way of `alight.rendering.tiles.light_tile`; what camera paths find belongs to their own pixel.
"""

from __future__ import annotations

from alight.integrators.both_ends.light_subpath import LONGEST, joined_up_to, no_light_vertex
from alight.integrators.model import model_of
from alight.integrators.moments import at_times_of
from alight.rendering.tiles.light_tile import add_splats, render_light_tile
from alight.rendering.tiles.tile_kernel import (
    RAYS,
    Cursor,
    add_finished,
    camera_rays,
    count_cells,
    next_pixel,
)
from lanewise.jit import kernel, specialised
from lanewise.records import local_records, put_records, records_at, replace
from lanewise.simd import LANES, any_lane, as_float, lane_index

#: Light vertices of a packet; the widest has 16 lanes.
ROOM = 16 * (LONGEST - 1)


@specialised
def splatting_tile_kernel(program):
    """``(scene, settings, places, ranges, film)``, for integrators that splat."""
    return render_light_tile if model_of(program).both_ends is None else render_both_ends


@specialised
def render_both_ends(program):
    """As `alight.rendering.tiles.light_tile.render_light_tile`, with camera paths besides."""
    ends = model_of(program).both_ends
    assert ends is not None
    begin_light, extend_light, begin_camera, extend_camera, join = ends(program)

    @kernel
    def render_both_ends(scene, settings, places, ranges, film):
        tile, window = places
        short = joined_up_to(settings)
        # As many light paths as pixels, whatever has been traced of either.
        paths = as_float((window.x1 - window.x0) * (window.y1 - window.y0))
        memory = local_records(ROOM, no_light_vertex(scene))
        cursor = next_pixel(settings, tile, ranges, Cursor(-1, 0, 0, 0, 0, 0))
        _, cells = count_cells(tile)
        rays = 0
        while cursor.cell < cells:
            cursor, seen = camera_rays(scene, settings, tile, ranges, cursor)
            now = at_times_of(scene, seen.sampler)
            walk, emission = begin_light(now, short, seen.new, seen.sampler)
            count = 0
            while count < LONGEST - 1 and any_lane(walk.path.active):
                walk, vertex, splat = extend_light(now, short, walk, emission, paths)
                put_records(memory, ROOM, count * LANES, lane_index(), vertex)
                add_splats(settings, window, film, seen.sampler.scramble, splat)
                count += 1
            rays += walk.path.rays
            walk = begin_camera(seen)
            while any_lane(walk.path.active):
                walk, vertex = extend_camera(now, settings, walk, paths)
                path = walk.path
                for i in range(count):
                    other = records_at(memory, ROOM, i * LANES, no_light_vertex(now))
                    path = join(now, short, path, vertex, other)
                walk = replace(walk, path=path)
            rays += walk.path.rays
            add_finished(settings, window, film, walk.path, seen.new)
        film.tally[RAYS] += rays

    return render_both_ends
