"""The light's half of bidirectional path tracing: vertices that camera paths are joined to.

Light paths go as `alight.integrators.both_ends.light_walk` says. They carry the quotients of
`alight.integrators.both_ends.connection_weights` along, and use the second half of the random
numbers of a vertex, beside those of the camera path.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from alight.accel import is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import has_null
from alight.cameras.rays import connect_camera
from alight.core.constants import INFINITY
from alight.core.vec import dot, length
from alight.integrators.both_ends.connection_weights import (
    Techniques,
    all_behind,
    techniques_at,
    techniques_beyond,
    weight_beside,
)
from alight.integrators.both_ends.light_walk import (
    set_out_by,
    write_arrive,
    write_follow,
    write_turn,
)
from alight.integrators.both_ends.splats import lens_numbers, write_show
from alight.integrators.interiors.enclosing import bodies_beyond
from alight.integrators.walk import (
    count_lanes,
    to_local,
    vertex_dimension,
)
from alight.lights.emission.density import direct_density, emission_density, is_kind
from alight.shapes.hit import Surface, no_hit, spawn_origin
from alight.shapes.model import SHAPES
from alight.shapes.surfaces import blank, chart_of, usual_bend, usual_wavelength
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    absolute,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    where,
)

#: Edges of the longest path that is joined: longer ones are left to the camera's half alone.
LONGEST = 32

#: First of the random numbers of light paths, among those of a vertex.
OTHER_HALF = 8

#: Paths on their way (`PathState`), and the `Techniques` behind them.
Walk = namedtuple("Walk", "path behind")

#: Where light paths have met surfaces. wl: local direction that they came from; beta: flux over its
#: cosine with the geometric normal, W; behind: `Techniques`; depth: u32, edges from the light;
#: active: mask.
LightVertex = namedtuple("LightVertex", "surface wl beta behind depth active")


@kernel
def nothing_behind():
    """`Techniques` of a path before its first vertex."""
    return Techniques(lanes(0.0), lanes(0.0))


@kernel
def no_light_vertex(scene):
    """A `LightVertex` of zeros in every lane."""
    g, hit, zero = blank(), no_hit(), lanes_u32(0)
    surface = Surface(
        p=g.p,
        error=g.error,
        ng=g.ng,
        ns=g.ns,
        s=g.s,
        t=g.t,
        u=g.u,
        v=g.v,
        shape=zero,
        prim=zero,
        bsdf=zero,
        light=zero,
        color=g.color,
        chart=chart_of(scene.shapes, hit),
        wavelength=usual_wavelength(),
        bend=usual_bend(),
    )
    black = lanes_vec3(0.0)
    return LightVertex(surface, black, black, nothing_behind(), zero, lanes_mask(False))


@kernel
def joined_up_to(settings):
    """The settings of paths that may be joined."""
    return replace(settings, max_depth=min(settings.max_depth, LONGEST))


def write_begin_light(program):
    """``(scene, settings, new, sampler) -> (Walk, Emission)``: light paths before their first ray.

    `path.delta` says that a path has no vertex beside the light yet.
    """
    may_be_stopped = any(not SHAPES[name].spec.finite for name in program.shapes)

    @kernel
    def begin_light(scene, settings, new, sampler):
        first = vertex_dimension(lanes_u32(1)) + OTHER_HALF
        path, e = set_out_by(scene, settings, new, sampler, first)
        if may_be_stopped:
            # Shapes without bounds may stop light from infinity before it comes to the ball.
            on_shape, near, _ = is_kind(scene, e.light)
            far = path.active & ~on_shape & ~near
            stopped = far & is_occluded(scene, e.o, -e.d, lanes(INFINITY), far)
            path = replace(path, active=path.active & ~stopped, rays=count_lanes(far))
        return Walk(replace(path, delta=new), nothing_behind()), e

    return begin_light


@kernel
def behind_first(scene, e, p, d, per_cos):
    """(`Techniques` at the first vertex p of light paths that start as `e` says, mask).

    They arrive along d; per_cos: as in `Arrival`. The mask: light paths have a density there.
    """
    distance = length(p - e.p)
    density = emission_density(scene, e.light, p, d, distance)
    known = density > 0.0
    per_density = per_cos / where(known, density, 1.0)
    on_shape, _, around = is_kind(scene, e.light)
    near = direct_density(scene, e, p, d, distance) * per_density
    return Techniques(near, where(on_shape | around, per_density, 0.0)), known


def write_extend_light(program, tell: Any = None):
    """``(scene, settings, walk, e, paths) -> (Walk, LightVertex, Splat)``: one more vertex.

    e: `Emission` that the paths began with; paths: how many light paths there are for each pixel,
    as weights count them. The settings are those of `joined_up_to`.
    """
    arrive, turn, follow = write_arrive(program), write_turn(program), write_follow(program)
    show, holes, told = write_show(program), has_null(program), tell is not None

    @kernel
    def extend_light(scene, settings, walk, e, paths):
        before, last = walk.behind, walk.path.p
        path, arrival = arrive(scene, walk.path)
        surface, per_cos = arrival.surface, arrival.per_cos
        sampler, depth = path.sampler, path.depth + 1
        first, known = behind_first(scene, e, surface.p, path.d, per_cos)
        later = techniques_at(before, length(surface.p - last), per_cos)
        behind = where(path.delta, first, later)
        path = replace(path, active=path.active & (known | ~path.delta))
        vertex = LightVertex(surface, arrival.wl, path.beta * per_cos, behind, depth, path.active)

        # The camera sees the point: t = 1.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = path.active & (depth < settings.max_depth)
        wc = to_local(surface, c.w)
        f_cos, reverse = evaluate_bsdf(scene, surface, wc, arrival.wl, seen)
        geometry = absolute(dot(surface.ng, c.w)) * c.importance
        w = weight_beside(geometry / paths * all_behind(behind, reverse))
        around = bodies_beyond(scene, path.bodies, surface, path.d, c.w)
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w), around)
        value = vertex.beta * f_cos * (geometry * w)
        splat, more = show(scene, settings, at, c.distance, seen, value)
        if told:
            place, technique = (splat.x, splat.y), (depth + 1, depth + 1)
            tell(scene, place, technique, splat.lit, splat.value * (1.0 / paths), w)

        # Where the path continues.
        path = replace(path, active=path.active & (depth + 1 < settings.max_depth))
        dimension = vertex_dimension(depth + 1) + OTHER_HALF
        way = turn(scene, path, arrival, dimension)
        on = follow(scene, settings, path, surface, way, dimension)
        delta = (way.flags & DELTA) != 0
        pdf = where(delta | ~(way.pdf > 0.0), 1.0, way.pdf)
        after = techniques_beyond(behind, absolute(dot(surface.ng, way.d)), pdf, way.reverse, delta)
        started = lanes_mask(False)
        if holes:
            straight = (way.flags & NULL) != 0
            after, started = where(straight, before, after), straight & path.delta
        return Walk(replace(on, delta=started, rays=path.rays + more), after), vertex, splat

    return extend_light
