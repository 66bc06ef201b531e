"""The light's half of bidirectional path tracing: vertices that camera paths are joined to.

Light paths go as `alight.integrators.light_walk` says. They carry the quotients of
`alight.integrators.connection_weights` along, and use the second half of the random numbers of a
vertex, beside those of the camera path.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.switch import has_null
from alight.cameras.rays import connect_camera
from alight.core.constants import INFINITY
from alight.core.vec import dot, length, max_component
from alight.integrators.connection_weights import (
    Techniques,
    all_behind,
    techniques_at,
    techniques_beyond,
    weight_beside,
)
from alight.integrators.light_walk import lens_numbers, write_arrive, write_meet, write_turn
from alight.integrators.roulette import play_roulette
from alight.integrators.walk import (
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    count_lanes,
    no_paths,
    to_local,
    vertex_dimension,
)
from alight.lights.emission_density import direct_density, emission_density, is_kind
from alight.lights.emission_sampling import sample_emission
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import Surface, no_hit, spawn_origin
from alight.shapes.model import SHAPES
from alight.shapes.surfaces import blank, chart_of
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
        u, u2 = get_1d(sampler, first + LIGHT_CHOICE), get_2d(sampler, first + LIGHT_POINT)
        e = sample_emission(scene, u, u2, get_2d(sampler, first + BSDF_DIRECTION))
        brightness = max_component(e.flux)
        active, rays = new & ~(brightness <= 0.0) & (lanes_u32(1) < settings.max_depth), 0
        if may_be_stopped:
            # Shapes without bounds may stop light from infinity before it comes to the ball.
            on_shape, near, _ = is_kind(scene, e.light)
            far = active & ~on_shape & ~near
            rays += count_lanes(far)
            active = active & ~(far & is_occluded(scene, e.o, -e.d, lanes(INFINITY), far))
        path = replace(
            no_paths(),
            o=e.o,
            d=e.d,
            p=e.p,
            beta=e.flux,
            pdf=brightness,
            delta=new,
            sampler=sampler,
            active=active,
            rays=rays,
        )
        return Walk(path, nothing_behind()), e

    return begin_light


@kernel
def behind_first(scene, e, p, d, cosine):
    """(`Techniques` at the first vertex p of light paths that start as `e` says, mask).

    The mask: the density of the light path is known there.
    """
    distance = length(p - e.p)
    density = emission_density(scene, e.light, p, d, distance)
    known = density > 0.0
    per_density = 1.0 / where(known, density * cosine, 1.0)
    on_shape, _, around = is_kind(scene, e.light)
    near = direct_density(scene, e, p, d, distance) * per_density
    return Techniques(near, where(on_shape | around, per_density, 0.0)), known


def write_extend_light(program):
    """``(scene, settings, walk, e, paths) -> (Walk, LightVertex, Splat)``: one more vertex.

    e: `Emission` that the paths began with; paths: how many light paths there are for each pixel,
    as weights count them. The settings are those of `joined_up_to`.
    """
    arrive, holes = write_arrive(program), has_null(program)
    meet, turn = write_meet(program), write_turn(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def extend_light(scene, settings, walk, e, paths):
        path, before = walk.path, walk.behind
        v = meet(scene, path)
        surface, depth, sampler = v.surface, path.depth + 1, path.sampler
        cosine = where(v.active, v.cosine, 1.0)
        first, known = behind_first(scene, e, surface.p, path.d, cosine)
        later = techniques_at(before, length(surface.p - path.p), cosine)
        behind = where(path.delta, first, later)
        active = v.active & (known | ~path.delta)
        vertex = LightVertex(surface, v.wl, v.beta * (1.0 / cosine), behind, depth, active)

        # The camera sees the point: t = 1.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = active & (depth < settings.max_depth)
        f_cos, reverse = evaluate_bsdf(scene, surface, to_local(surface, c.w), v.wl, seen)
        geometry = absolute(dot(surface.ng, c.w)) * c.importance
        w = weight_beside(geometry / paths * all_behind(behind, reverse))
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w))
        value = vertex.beta * f_cos * (geometry * w)
        splat, more = arrive(scene, settings, at, c.distance, seen, value)

        # Where the path continues.
        active = active & (depth + 1 < settings.max_depth)
        dimension = vertex_dimension(depth + 1) + OTHER_HALF
        t = turn(scene, sampler, dimension, v, active)
        beta = where(active, v.beta * t.weight, v.beta)
        brightness = max_component(beta)
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0)
        o = spawn_origin(surface.p, surface.error, surface.ng, t.d)
        on = replace(
            path, o=o, d=t.d, p=surface.p, beta=beta, delta=lanes_mask(False), depth=depth,
            active=active,
        )  # fmt: skip
        if roulette:
            # Of the flux that the path began with.
            on = play_roulette(settings, on, dimension, brightness / path.pdf)
        pdf = where(t.delta | ~(t.pdf > 0.0), 1.0, t.pdf)
        after = techniques_beyond(behind, t.cosine, pdf, t.reverse, t.delta)
        if holes:
            beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
            unseen = replace(path, o=beyond, beta=beta, depth=depth, active=active)
            on, after = where(t.straight, unseen, on), where(t.straight, before, after)
        on = replace(on, sampler=sampler, rays=v.rays + more)
        return Walk(on, after), vertex, splat

    return extend_light
