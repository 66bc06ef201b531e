"""The camera subpath of bidirectional path tracing, and its connections to the light subpath.

Where a path comes upon light, where it samples light, and where its vertices are joined to those of
a light path: techniques s = 0, s = 1 and the others of `alight.integrators.bidirectional`.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import concentration, has_null, refracts
from alight.cameras.rays import connect_camera
from alight.core.constants import INFINITY
from alight.core.vec import absolute_vec3, dot, length, length_squared, max_component
from alight.integrators.both_ends.connection_weights import (
    Techniques,
    all_behind,
    techniques_at,
    techniques_beyond,
    together,
    weight_beside,
)
from alight.integrators.both_ends.light_subpath import LONGEST, Walk, nothing_behind
from alight.integrators.interiors.enclosing import (
    begin_inside,
    bodies_beyond,
    come_to,
    dimmed,
    left_along,
    left_between,
)
from alight.integrators.roulette import play_roulette
from alight.integrators.shadow_rays import transmittance_through_holes
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LENS,
    LIGHT_CHOICE,
    LIGHT_POINT,
    begin_paths,
    count_lanes,
    empty_paths,
    gather_light,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.choice import light_index, lit_normal
from alight.lights.emission.density import direct_density_of_sample, emission_density
from alight.lights.hits import emitted, light_pdf, on_shapes
from alight.lights.misses import environment_pdf, environment_radiance, environments_of
from alight.lights.sampling import sample_known_light, shadow_ray
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import shadow_length, spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, any_lane, lanes, lanes_mask, lanes_u32, sqrt, to_float, where

#: Where camera paths have met surfaces. wo: local direction that they came from; beta: throughput;
#: behind: `Techniques`; depth: u32, edges from the camera; bodies: `Bodies` in which they came,
#: along d; active: mask.
CameraVertex = namedtuple("CameraVertex", "surface wo beta behind depth bodies d active")


@kernel
def begin_camera(rays):
    """Camera paths before their first ray, from `CameraRays`.

    `path.delta` says that a path has no vertex beside the camera yet.
    """
    path = begin_paths(rays.new, rays.o, rays.d, rays.weight, rays.sampler, empty_paths())
    return Walk(path, nothing_behind())


@kernel
def place_of(path):
    """Where a camera path adds to the picture, for `alight.integrators.strategies`."""
    return to_float(path.sampler.x), to_float(path.sampler.y)


# ---------------------------------------------------------------- light


@kernel
def weight_of_hit(behind, direct, emission, depth):
    """Of light that a camera path has come upon after `depth` edges: s = 0."""
    by_light_paths = where(depth <= LONGEST, emission * behind.far, 0.0)
    return weight_beside(together(direct * behind.near, by_light_paths))


def write_leave(program, tell: Any):
    """``(scene, walk, missed) -> PathState``: light of the environment, where rays left."""
    if not environments_of(program):

        @kernel
        def into_the_dark(scene, walk, missed):
            return walk.path

        return into_the_dark
    told = tell is not None

    @kernel
    def leave(scene, walk, missed):
        path, depth = walk.path, walk.path.depth + 1
        if any_lane(missed):
            d = where(missed, path.d, 0.0)
            last = lanes_u32(scene.lights.starts.size - 1)
            emission = emission_density(scene, last, path.p, -d, lanes(1.0))
            w = weight_of_hit(walk.behind, environment_pdf(scene, path.p, d), emission, depth)
            found = path.beta * environment_radiance(scene, d) * w
            path = gather_light(path, found, missed, lanes_mask(False))
            if told:
                tell(scene, place_of(path), (lanes_u32(0), depth), missed, found, w)
        return path

    return leave


def write_reach(program, tell: Any):
    """``(scene, walk, surface, active) -> PathState``: light of surfaces that rays hit."""
    if not on_shapes(program):

        @kernel
        def all_dark(scene, walk, surface, active):
            return walk.path

        return all_dark
    told = tell is not None

    @kernel
    def reach(scene, walk, surface, active):
        path, depth = walk.path, walk.path.depth + 1
        shining = active & (surface.light != 0)
        if any_lane(shining):
            # From the last vertex, not from a hole in between.
            distance = length(surface.p - path.p)
            direct = light_pdf(scene, surface.light, path.p, path.d, distance, surface)
            index = light_index(surface.light)
            emission = emission_density(scene, index, path.p, -path.d, distance)
            w = weight_of_hit(walk.behind, direct, emission, depth)
            found = path.beta * emitted(scene, surface, -path.d) * w
            path = gather_light(path, found, shining, lanes_mask(False))
            if told:
                tell(scene, place_of(path), (lanes_u32(0), depth), shining, found, w)
        return path

    return reach


def write_add_direct_light(program, tell: Any):
    """``(scene, settings, path, v) -> PathState``: light sampling at the vertices v, s = 1."""
    if not program.lights:

        @kernel
        def without_lights(scene, settings, path, v):
            return path

        return without_lights
    holes, told = has_null(program), tell is not None

    @kernel
    def add_direct_light(scene, settings, path, v):
        surface, rays, dimension = v.surface, path.rays, vertex_dimension(v.depth)
        light, index = sample_known_light(
            scene, surface.p, lit_normal(surface.ns, v.wo),
            get_1d(path.sampler, dimension + LIGHT_CHOICE),
            get_2d(path.sampler, dimension + LIGHT_POINT), v.active,
        )  # fmt: skip
        lit = v.active & (light.pdf > 0.0)
        if any_lane(lit):
            wi = to_local(surface, light.wi)
            f_cos, pdf = evaluate_bsdf(scene, surface, v.wo, wi, lit)
            lit = lit & ~(max_component(f_cos) <= 0.0)
            _, reverse = evaluate_bsdf(scene, surface, wi, v.wo, lit)
            o, end = shadow_ray(surface, light)
            around = bodies_beyond(scene, v.bodies, surface, v.d, light.wi)
            passed, share = lanes_u32(0), lanes(1.0)
            if holes:
                # A hole is the end of an edge, for paths and so for shadow rays too.
                most = passed + settings.max_depth - v.depth - 1
                ray = o, light.wi, end, around
                share, left, passed, rays = transmittance_through_holes(scene, ray, most, lit, rays)
                lit = lit & (share > 0.0)
            else:
                rays += count_lanes(lit)
                lit = lit & ~is_occluded(scene, o, light.wi, end, lit)
                left = left_along(around, end, lit)
            per_pdf = 1.0 / where(lit, light.pdf, 1.0)
            emission = emission_density(scene, index, surface.p, -light.wi, light.distance)
            emission = emission * absolute(dot(surface.ng, light.wi))
            # Where the other end cannot be hit, or is too far away to be joined.
            by_bsdf = where(light.delta, 0.0, pdf)
            emission = where(v.depth + passed + 1 <= LONGEST, emission, 0.0)
            others = together(by_bsdf, emission * all_behind(v.behind, reverse))
            direct = direct_density_of_sample(scene, light, index)
            others = others / where(direct > 0.0, direct, 1.0)
            w = weight_beside(others)
            found = v.beta * f_cos * dimmed(light.radiance, left) * (share * w * per_pdf)
            path = gather_light(path, found, lit, lanes_mask(False))
            if told:
                tell(scene, place_of(path), (lanes_u32(1), v.depth + 1), lit, found, w)
        return replace(path, rays=rays)

    return add_direct_light


# ---------------------------------------------------------------- paths


def write_extend_camera(program, tell: Any = None):
    """``(scene, settings, walk, paths) -> (Walk, CameraVertex)``: one more vertex of camera paths.

    Adds the light that is found without a light path; `paths` as for `write_extend_light`.
    """
    leave, reach, add_direct_light = (
        write(program, tell) for write in (write_leave, write_reach, write_add_direct_light)
    )
    refracting, holes = refracts(program), has_null(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def extend_camera(scene, settings, walk, paths):
        path, before = walk.path, walk.behind
        path = begin_inside(scene, path, path.active & (path.depth == 0))
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        path = replace(path, rays=path.rays + count_lanes(path.active))
        path = leave(scene, Walk(path, before), path.active & (hit.t == INFINITY))
        active, depth = path.active & (hit.t < INFINITY), path.depth + 1
        surface = make_surface(scene, hit, path.o, path.d, active)
        wo = to_local(surface, -path.d)
        path = come_to(scene, path, surface, hit.t, active, active)
        path = reach(scene, Walk(path, before), surface, active)
        active = active & (depth < settings.max_depth)

        # The camera's density of its first vertex is the importance there.
        cosine = absolute(dot(surface.ng, path.d))
        per_cos = 1.0 / where(cosine > 0.0, cosine, 1.0)
        later = techniques_at(before, length(surface.p - path.p), per_cos)
        c = connect_camera(scene, surface.p, get_2d(path.sampler, LENS))
        importance = where(c.importance > 0.0, c.importance, 1.0)
        first = Techniques(paths * per_cos / importance, lanes(0.0))
        behind = where(path.delta, first, later)
        vertex = CameraVertex(
            surface=surface, wo=wo, beta=path.beta, behind=behind, depth=depth,
            bodies=path.bodies, d=path.d, active=active,
        )  # fmt: skip
        path = add_direct_light(scene, settings, path, vertex)

        dimension = vertex_dimension(depth)
        wi, weight, pdf, flags = sample_bsdf(
            scene, surface, wo, get_1d(path.sampler, dimension + BSDF_CHOICE),
            get_2d(path.sampler, dimension + BSDF_DIRECTION), active,
        )  # fmt: skip
        beta = path.beta * weight
        # Filters with negative lobes weigh some paths negatively.
        brightness = max_component(absolute_vec3(beta))
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0)
        d = to_world(surface, wi)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        bodies = bodies_beyond(scene, path.bodies, surface, path.d, d)
        on = replace(path, o=o, d=d, beta=beta, depth=depth, active=active, bodies=bodies)
        if roulette:
            if refracting:
                # A path in glass is not dim: it regains on the way out what it lost on the way in.
                brightness = brightness * concentration(scene, surface, wi)
            on = play_roulette(settings, on, dimension, brightness)
        delta = (flags & DELTA) != 0
        smooth, reverse = on.active & ~delta & (pdf > 0.0), lanes(0.0)
        if any_lane(smooth):
            _, reverse = evaluate_bsdf(scene, surface, wi, wo, smooth)
        pdf = where(smooth, pdf, 1.0)
        after = techniques_beyond(behind, absolute(dot(surface.ng, d)), pdf, reverse, delta)
        turned = replace(on, p=surface.p, delta=lanes_mask(False))
        if holes:
            # Straight on, as if nothing were there: the vertex before still looks for light.
            straight = (flags & NULL) != 0
            turned, after = where(straight, on, turned), where(straight, before, after)
        turned = replace(turned, sampler=path.sampler, rays=path.rays)
        return Walk(turned, after), vertex

    return extend_camera


def write_join(program, tell: Any = None):
    """``(scene, settings, path, z, y) -> PathState``: with what comes to z from y.

    z is a `CameraVertex`, y a `LightVertex`; the settings are those of `joined_up_to`.
    """
    holes, told = has_null(program), tell is not None

    @kernel
    def join(scene, settings, path, z, y):
        rays, edges = path.rays, z.depth + y.depth + 1
        across = y.surface.p - z.surface.p
        squared = length_squared(across)
        lit = z.active & y.active & (edges <= settings.max_depth) & (squared > 0.0)
        if any_lane(lit):
            per_squared = 1.0 / where(lit, squared, 1.0)
            distance = sqrt(squared)
            w = across * (distance * per_squared)
            cos_y, cos_z = absolute(dot(y.surface.ng, w)), absolute(dot(z.surface.ng, w))
            wi, wc = to_local(z.surface, w), to_local(y.surface, -w)
            f_z, pdf_z = evaluate_bsdf(scene, z.surface, z.wo, wi, lit)
            f_y, back_y = evaluate_bsdf(scene, y.surface, wc, y.wl, lit)
            f = f_z * f_y * (cos_y * per_squared)
            lit = lit & ~(max_component(f) <= 0.0)
            passed = lanes_u32(0)
            o = spawn_origin(z.surface.p, z.surface.error, z.surface.ng, w)
            end = shadow_length(distance, cos_y, y.surface.error, z.surface.error)
            share, around = lanes(1.0), bodies_beyond(scene, z.bodies, z.surface, z.d, w)
            if holes:
                most = passed + settings.max_depth - edges
                ray = o, w, end, around
                share, left, passed, rays = transmittance_through_holes(scene, ray, most, lit, rays)
                lit = lit & (share > 0.0)
            else:
                rays += count_lanes(lit)
                lit = lit & ~is_occluded(scene, o, w, end, lit)
                left = left_between(scene, around, y.surface, w, end, lit)
            if any_lane(lit):
                _, back_z = evaluate_bsdf(scene, z.surface, wi, z.wo, lit)
                _, pdf_y = evaluate_bsdf(scene, y.surface, y.wl, wc, lit)
                # Densities of y from z, and of z from y, per square metre.
                by_camera = pdf_z * cos_y * per_squared * all_behind(y.behind, back_y)
                by_light = pdf_y * cos_z * per_squared * all_behind(z.behind, back_z)
                weight = weight_beside(together(by_camera, by_light))
                found = z.beta * y.beta * dimmed(f, left) * (share * weight)
                path = gather_light(path, found, lit, lanes_mask(False))
                if told:
                    tell(scene, place_of(path), (y.depth + 1, edges), lit, found, weight)
        return replace(path, rays=rays)

    return join
