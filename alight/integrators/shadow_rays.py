"""Shadow rays that are not simply stopped: by media, and through surfaces that are not there.

A surface lets a part of the light go straight on (`alight.bsdfs.dispatch.open_share`): all of it if
it is `null`, what its opacity leaves if it is a mask. Paths choose that way at random, shadow rays
are dimmed. Both find the same light, so that their MIS weights are those of the last vertex that
turned the path.

Source: PBR4 section 14.2.3 (SampleLd of VolPathIntegrator).
"""

from __future__ import annotations

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import open_share
from alight.bsdfs.switch import has_null
from alight.core.constants import INFINITY
from alight.core.vec import dot, max_component
from alight.integrators.interiors.enclosing import all_left, cross_straight, left_along
from alight.integrators.interiors.volume_walk import medium_beyond
from alight.integrators.walk import count_lanes
from alight.media.sampling import cross
from alight.media.tables import Crossing, Segment, Stream, segment_of
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, lanes, lanes_u32, lanes_vec3, where


@specialised
def shadow_transmittance(program):
    """What of the light comes through to the end of a `Segment`.

    ``(scene, segment, bodies, most, lit, rays) -> (Crossing, left, passed, rays)``. The segment's
    medium and the `Bodies` are what the rays start in; `left` is what those leave of the light, a
    Vec3 or (), see `alight.integrators.interiors.enclosing`; `passed` counts the surfaces that the
    rays went through. Nothing comes through more than `most` of them.
    """
    if has_null(program):
        return _through_borders
    return _along_one_segment if program.media else _through_empty_space


@kernel
def transmittance_through_holes(scene, ray, most, lit, rays):
    """`shadow_transmittance` without media: (part of the light, left, surfaces passed, rays).

    ray: origin, direction, length in metres and `Bodies`.
    """
    o, d, end, bodies = ray
    none = lanes_u32(0)
    segment = Segment(o, d, end, none, none, Stream(none, none, none))
    crossing, left, passed, rays = shadow_transmittance(scene, segment, bodies, most, lit, rays)
    return crossing.passed.x * crossing.weight, left, passed, rays


@kernel
def _through_empty_space(scene, segment, bodies, most, lit, rays):
    dark = is_occluded(scene, segment.o, segment.d, segment.length, lit)
    passed = where(dark, lanes_vec3(0.0), lanes_vec3(1.0))
    found = Crossing(passed, lanes_vec3(1.0), lanes(1.0))
    left = left_along(bodies, segment.length, lit)
    return found, left, lanes_u32(0), rays + count_lanes(lit)


@kernel
def _along_one_segment(scene, segment, bodies, most, lit, rays):
    dark = is_occluded(scene, segment.o, segment.d, segment.length, lit)
    found = cross(scene, segment, lit & ~dark)
    found = replace(found, passed=where(dark, lanes_vec3(0.0), found.passed))
    left = left_along(bodies, segment.length, lit)
    return found, left, lanes_u32(0), rays + count_lanes(lit)


@specialised
def _cross_segment(program):
    """`alight.media.sampling.cross`, or nothing to cross."""
    if program.media:
        return cross

    @kernel
    def empty(scene, segment, active):
        return Crossing(lanes_vec3(1.0), lanes_vec3(1.0), lanes(1.0))

    return empty


@kernel
def _through_borders(scene, segment, bodies, most, lit, rays):
    passed, light, weight = lanes_vec3(1.0), lanes_vec3(1.0), lanes(1.0)
    o, d, end, medium = segment.o, segment.d, segment.length, segment.medium
    going, number, left = lit, lanes_u32(0), all_left()
    while any_lane(going):
        rays += count_lanes(going)
        hit = intersect_closest(scene, o, d, end, going)
        met = going & (hit.t < INFINITY)
        t = where(met, hit.t, end)
        stream = segment_of(segment.stream, number)
        part = Segment(o, d, t, medium, segment.channel, stream)
        found = _cross_segment(scene, part, going)
        passed = where(going, passed * found.passed, passed)
        light = where(going, light * found.light, light)
        weight = where(going, weight * found.weight, weight)
        surface = make_surface(scene, hit, o, d, met)
        bodies, left = cross_straight(scene, bodies, left, surface, (d, t), (going, met))
        number = where(met, number + 1, number)
        share = where(number > most, 0.0, open_share(scene, surface, met))
        # Not a factor of `passed`, which is a density of paths too: theirs leaves the holes out.
        weight = where(met, weight * share, weight)
        passed = where(met & ~(share > 0.0), lanes_vec3(0.0), passed)
        through = met & (max_component(passed) > 0.0)
        beyond = spawn_origin(surface.p, surface.error, surface.ng, d)
        # The new origin lies beyond the border: measured from there, the end is nearer.
        end = where(through, end - dot(beyond - o, d), end)
        medium = where(through, medium_beyond(scene, surface, d, medium), medium)
        o = where(through, beyond, o)
        going = through
    return Crossing(passed, light, weight), left, number, rays
