r"""Volumetric path tracing: surfaces as `path`, and media between them that absorb and scatter.

.. math::
    L(x, \omega) = \int_0^{s} T(t)\, \sigma_s(t) \int p(\omega, \omega')\, L(\omega')\, d\omega'\,
    dt + T(s)\, L_o(s)

Distances are chosen by the media, directions in them by their phase functions. Lights are sampled
at surfaces and in media alike; shadow rays go through surfaces that are not there (`null`) and are
dimmed by the media on their way. Directions and light sampling are combined by the balance
heuristic, together with the three channels (`alight.integrators.interiors.volume_walk`). A guide
mixes its directions with those of phase functions as with those of BSDFs
(`alight.integrators.guided`).

Source: PBR4 section 14.2.3 (VolPathIntegrator); Miller, Georgiev and Jarosz, SIGGRAPH 2019.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import concentration, has_null, is_null, refracts
from alight.core.constants import INFINITY
from alight.core.vec import absolute_vec3, max_component
from alight.integrators.guided import (
    NOWHERE,
    Vertex,
    guide_at,
    is_guided,
    mixed_density,
    write_guided_scatter,
)
from alight.integrators.interiors.body_walk import begin_walks, enters_body, lit_side, walk_through
from alight.integrators.interiors.collisions import (
    Turn,
    evaluate_anywhere,
    pass_media,
    phase_towards_light,
    sample_anywhere,
    turn_in_medium,
)
from alight.integrators.interiors.dispersed import at_wavelength_of, meet_dispersion
from alight.integrators.interiors.enclosing import begin_inside, bodies_beyond, come_to, dimmed
from alight.integrators.interiors.volume_walk import empty_paths as empty_paths
from alight.integrators.interiors.volume_walk import (
    mean,
    medium_beyond,
)
from alight.integrators.interiors.volume_walk import start_paths as start_paths
from alight.integrators.mis_weights import BY_BSDF, BY_LIGHT, MIS, STRATEGIES
from alight.integrators.options import PathTracing
from alight.integrators.reach import NO_LISTENERS, write_reach_environment, write_reach_lamp
from alight.integrators.roulette import play_beside_guide, play_roulette
from alight.integrators.shadow_rays import shadow_transmittance
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    UNLIMITED,
    count_lanes,
    gather_light,
    gather_unguided,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.hits import on_shapes
from alight.lights.misses import environments_of
from alight.lights.sampling import has_delta_lights, sample_light, shadow_ray
from alight.media.tables import Segment, stream_of
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import shadow_length, spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_vec3,
    maximum,
    where,
)


class VolPath(PathTracing):
    """Volumetric path tracer.

    Parameters
    ----------
    light_sampling : {"mis", "bsdf", "emitter"}, default "mis"
        How direct light is found: by sampling BSDFs and phase functions, by light sampling, or by
        both combined. All compute the same picture.
    max_depth : int >= 1, optional
        Longest path, counted in edges after the camera; scattering in a medium ends an edge,
        passing a `null` surface or a hole does not. Unlimited by default, which needs roulette.
    """

    sees_media: ClassVar[bool] = True
    walks_inside: ClassVar[bool] = True
    sees_dispersion: ClassVar[bool] = True
    transports: ClassVar[bool] = True
    type: Literal["volpath"] = "volpath"


EXAMPLES = (
    VolPath(),
    VolPath(max_depth=8, rr_depth=5),
    VolPath(light_sampling="bsdf", russian_roulette="none", max_depth=4),
    VolPath(light_sampling="emitter", light_choice="uniform"),
    VolPath(hide_emitters=True, guiding="on"),
)


def step(program):
    """The kernel that carries paths on to the next surface or collision."""
    strategy = STRATEGIES[program.option("light_sampling")]
    by_light = strategy in (BY_LIGHT, MIS) and bool(program.lights)
    samples_lights = by_light or has_delta_lights(program)
    found_weight, chosen_weight = _weights_of(strategy)
    area_lights, nulls = bool(on_shapes(program)), has_null(program)
    environment = bool(environments_of(program))
    roulette = program.option("russian_roulette") == "throughput"
    guided = is_guided(program)
    without = _without_guide if guided else None
    reach_environment = write_reach_environment(found_weight, NO_LISTENERS, without)
    reach_lamp = write_reach_lamp(found_weight, nulls, NO_LISTENERS, without)
    add_direct_light = _write_add_direct_light(chosen_weight, by_light, guided)
    guided_scatter = write_guided_scatter(roulette, sample_anywhere, evaluate_anywhere)
    end_dim_paths = _write_end_dim_paths(refracts(program), guided)
    hides = program.option("hide_emitters", False)

    @kernel
    def volpath_step(scene, settings, path):
        """One more surface or collision of each path."""
        path = begin_inside(scene, path, path.active & (path.steps == 0))
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        path = replace(path, rays=path.rays + count_lanes(path.active))
        # The media on the way: a collision comes before the surface, or none does.
        path, scattered, t = pass_media(scene, path, hit.t)
        depth = path.depth + 1
        missed = path.active & ~scattered & (hit.t == INFINITY)
        met = path.active & ~scattered & (hit.t < INFINITY)
        if hides:
            missed = missed & (path.depth > 0)
        if environment:
            path = reach_environment(scene, path, missed)
        surface = make_surface(scene, hit, path.o, path.d, met)
        surface = at_wavelength_of(surface, path.sampler)

        # Surfaces that are not there are no vertices, nor lights that the camera looks through.
        passing, shining = lanes_mask(False), met
        if nulls:
            passing = met & is_null(scene, surface.bsdf)
        if hides:
            hidden = met & (path.depth == 0) & (surface.light != 0)
            passing, shining = passing | hidden, met & ~hidden
        # Dimmed by the body that the ray crossed.
        path = come_to(scene, path, surface, t, shining, met | scattered)
        if area_lights:
            path = reach_lamp(scene, path, hit, surface, shining)
        active = (met | scattered) & ~passing & (depth < settings.max_depth)
        path = meet_dispersion(scene, surface, path, met & ~passing)
        p = where(scattered, path.o + t * path.d, surface.p)
        wo = to_local(surface, -path.d)
        dimension = vertex_dimension(path.steps)
        place = Vertex(p, surface, wo, dimension, scattered)
        here = guide_at(settings, p) if guided else NOWHERE
        if samples_lights:
            path = add_direct_light(scene, settings, path, here, place, active)

        # Where the path continues.
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        u = get_1d(path.sampler, dimension + BSDF_CHOICE)
        turning = active & ~scattered
        if nulls:
            # The last surface may be a hole, behind which the last edge continues.
            turning = met & ~passing
        unguided = path.unguided
        if guided:
            drawing = replace(
                path, beta=path.beta * (1.0 / mean(path.ours)), active=turning | active
            )
            drawn, w, unguided = guided_scatter(scene, settings, drawing, here, place, active)
            wi, weight, pdf, flags = drawn
            turn = Turn(w, weight, pdf, (flags & DELTA) != 0)
            # Roulette was played at holes too.
            turning = turning & (max_component(weight) > 0.0)
        else:
            wi, weight, pdf, flags = sample_bsdf(scene, surface, wo, u, u2, turning)
            turn = Turn(to_world(surface, wi), weight, pdf, (flags & DELTA) != 0)
        if nulls:
            # Holes in a surface are no vertices either.
            hole = turning & ((flags & NULL) != 0)
            passing, active = passing | hole, active & ~hole
            if guided:
                # A guide never leads there.
                path = replace(path, beta=where(hole, path.beta * weight, path.beta))
        if not guided:
            turn = turn_in_medium(scene, path, u2, active & scattered, turn)
        beta = path.beta * turn.weight
        # Filters with negative lobes weigh some paths negatively.
        largest = max_component(absolute_vec3(beta))
        # Not "largest > 0": a NaN must live on and be counted by the film.
        active = active & ~(largest <= 0.0)
        d = where(passing, path.d, turn.d)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        medium = medium_beyond(scene, surface, d, path.medium)
        bodies = bodies_beyond(scene, path.bodies, surface, path.d, d)
        on = replace(
            path, o=where(scattered, p, o), d=d, medium=where(scattered, path.medium, medium),
            unguided=unguided, bodies=where(shining, bodies, path.bodies),
        )  # fmt: skip
        lights = where(turn.delta, lanes_vec3(0.0), path.ours * (1.0 / maximum(turn.pdf, 1e-30)))
        vertex = replace(
            on, p=p, beta=beta, pdf=turn.pdf, delta=turn.delta, depth=depth, lights=lights,
            active=active,
        )  # fmt: skip
        if roulette:
            # The weight of a channel alone may be large.
            brightness = largest / mean(path.ours)
            vertex = end_dim_paths(scene, settings, vertex, place, wi, brightness, here)
        walk = begin_walks(scene, vertex, surface, met)
        vertex = walk_through(scene, vertex, walk)
        going = vertex.active | passing
        path = where(passing, on, vertex)
        return replace(path, sampler=on.sampler, active=going, rays=vertex.rays)

    return volpath_step


# ---------------------------------------------------------------- roulette


def _write_end_dim_paths(refracting, guided):
    """``(scene, settings, path, vertex, wi, brightness, here) -> path``: roulette."""

    @kernel
    def end_dim_paths(scene, settings, path, vertex, wi, brightness, here):
        if refracting:
            # A path in glass is not dim: it regains on the way out what it lost on the way in.
            gathered = concentration(scene, vertex.surface, wi)
            brightness = brightness * where(vertex.collided, 1.0, gathered)
        if guided:
            path = play_beside_guide(settings, path, vertex.dimension, brightness, here.gain)
        else:
            path = play_roulette(settings, path, vertex.dimension, brightness)
        return path

    return end_dim_paths


# ---------------------------------------------------------------- light


def _write_add_direct_light(chosen_weight, by_light, guided):
    """Light sampling at surfaces and in media.

    ``(scene, settings, path, here, vertex, active) -> path``. Only delta lights count unless
    `by_light`.
    """

    @kernel
    def add_direct_light(scene, settings, path, here, vertex, active):
        p, surface, wo, dimension, scattered = vertex
        rays = path.rays
        # Media have no normal.
        n = where(scattered, lanes_vec3(0.0), lit_side(scene, surface, wo))
        light = sample_light(
            scene, p, n, get_1d(path.sampler, dimension + LIGHT_CHOICE),
            get_2d(path.sampler, dimension + LIGHT_POINT), active,
        )  # fmt: skip
        lit = active & (light.pdf > 0.0)
        if not by_light:
            lit = lit & light.delta
        lit = lit & (scattered | ~enters_body(scene, surface, light.wi))
        if any_lane(lit):
            wi = to_local(surface, light.wi)
            f_cos, pdf = evaluate_bsdf(scene, surface, wo, wi, lit & ~scattered)
            f_cos, pdf = phase_towards_light(scene, path, light.wi, lit & scattered, f_cos, pdf)
            of_bsdf = pdf
            if guided:
                pdf = mixed_density(settings, here, light.wi, pdf, lit)
            lit = lit & ~(max_component(f_cos) <= 0.0)
            o, end = shadow_ray(surface, light)
            o = where(scattered, p, o)
            free = shadow_length(light.distance, light.cosine, light.error, 0.0)
            end = where(scattered, free, end)
            medium = medium_beyond(scene, surface, light.wi, path.medium)
            medium = where(scattered, path.medium, medium)
            stream = stream_of(path.sampler, 2 * path.steps + 1)
            segment = Segment(o, light.wi, end, medium, path.channel, stream)
            around = bodies_beyond(scene, path.bodies, surface, path.d, light.wi)
            around = where(scattered, path.bodies, around)
            crossing, left, _, rays = shadow_transmittance(
                scene, segment, around, UNLIMITED, lit, rays
            )
            Le = dimmed(light.radiance, left)
            lit = lit & (max_component(crossing.passed) > 0.0)
            w = chosen_weight(path, light, pdf, crossing) * crossing.weight
            Ld = path.beta * f_cos * Le * crossing.passed * w
            path = gather_light(path, Ld, lit, path.depth == 0)
            if guided:
                w = chosen_weight(path, light, of_bsdf, crossing) * crossing.weight
                found = path.beta * f_cos * Le * crossing.passed * w
                path = gather_unguided(path, found, lit)
        return replace(path, rays=rays)

    return add_direct_light


@kernel
def _without_guide(path):
    """A path whose last direction has the density of the BSDF or the phase function."""
    more = path.pdf / maximum(path.unguided.pdf, 1e-30)
    return replace(path, lights=path.lights * more)


def _weights_of(strategy):
    """The kernels (found_weight, chosen_weight) of a strategy.

    Both are 1 over the mean density over the channels: of the path that hit a light, and of
    one that light sampling chose.
    """

    @kernel
    def found_weight(path, light_density):
        alone = 1.0 / mean(path.ours)
        if strategy == BY_BSDF:
            return alone
        if strategy == MIS:
            both = path.ours + path.lights * light_density
            return where(path.delta, alone, 1.0 / mean(both))
        return where(path.delta, alone, 0.0)

    @kernel
    def chosen_weight(path, light, density, crossing):
        chosen = path.ours * crossing.light * light.pdf
        alone = 1.0 / mean(chosen)
        if strategy == MIS:
            both = chosen + path.ours * crossing.passed * density
            return where(light.delta, alone, 1.0 / mean(both))
        return alone

    return found_weight, chosen_weight
