r"""Volumetric path tracing: surfaces as `path`, and media between them that absorb and scatter.

.. math::
    L(x, \omega) = \int_0^{s} T(t)\, \sigma_s(t) \int p(\omega, \omega')\, L(\omega')\, d\omega'\,
    dt + T(s)\, L_o(s)

Distances are chosen by the media, directions in them by their phase functions. Lights are sampled
at surfaces and in media alike; shadow rays go through surfaces that are not there (`null`) and are
dimmed by the media on their way. Directions and light sampling are combined by the balance
heuristic, together with the three channels (`alight.integrators.volume_walk`).

Source: PBR4 section 14.2.3 (VolPathIntegrator); Miller, Georgiev and Jarosz, SIGGRAPH 2019.
"""

from __future__ import annotations

from collections import namedtuple
from typing import ClassVar, Literal

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import concentration, has_null, is_null, refracts
from alight.core.constants import INFINITY
from alight.core.vec import absolute_vec3, max_component
from alight.integrators.mis_weights import BY_BSDF, BY_LIGHT, MIS, STRATEGIES
from alight.integrators.options import PathTracing
from alight.integrators.path import NO_LISTENERS
from alight.integrators.reach import write_reach_environment, write_reach_lamp
from alight.integrators.roulette import play_roulette
from alight.integrators.shadow_rays import come_through
from alight.integrators.volume_walk import (
    FREE_FLIGHT,
    mean,
    medium_beyond,
)
from alight.integrators.volume_walk import empty_paths as empty_paths
from alight.integrators.volume_walk import start_paths as start_paths
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    UNLIMITED,
    count_lanes,
    gather_light,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.choice import lit_normal
from alight.lights.hits import on_shapes
from alight.lights.misses import environments_of
from alight.lights.sampling import has_delta_lights, sample_light, shadow_ray
from alight.media.sampling import evaluate_phase, fly, sample_phase
from alight.media.tables import EMISSIVE, Segment, stream_of
from alight.media.voxels import emission
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import shadow_length, spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import (
    any_lane,
    lanes,
    lanes_mask,
    lanes_u32,
    lanes_vec3,
    maximum,
    where,
)

#: Where a path goes on: direction d (unit, in the world), weight of its throughput, density per
#: steradian, and whether a delta lobe chose it.
Turn = namedtuple("Turn", "d weight pdf delta")


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
    transports: ClassVar[bool] = True
    type: Literal["volpath"] = "volpath"


EXAMPLES = (
    VolPath(),
    VolPath(max_depth=8, rr_depth=5),
    VolPath(light_sampling="bsdf", russian_roulette="none", max_depth=4),
    VolPath(light_sampling="emitter", light_choice="uniform"),
    VolPath(hide_emitters=True),
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
    reach_environment = write_reach_environment(found_weight, NO_LISTENERS)
    reach_lamp = write_reach_lamp(found_weight, nulls, NO_LISTENERS)
    add_direct_light = _write_add_direct_light(chosen_weight, by_light)
    refracting = refracts(program)
    hides = program.option("hide_emitters", False)

    @kernel
    def volpath_step(scene, settings, path):
        """One more surface or collision of each path."""
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

        # Surfaces that are not there are no vertices, nor lights that the camera looks through.
        passing, shining = lanes_mask(False), met
        if nulls:
            passing = met & is_null(scene, surface.bsdf)
        if hides:
            hidden = met & (path.depth == 0) & (surface.light != 0)
            passing, shining = passing | hidden, met & ~hidden
        if area_lights:
            path = reach_lamp(scene, path, hit, surface, shining)
        active = (met | scattered) & ~passing & (depth < settings.max_depth)
        p = where(scattered, path.o + t * path.d, surface.p)
        wo = to_local(surface, -path.d)
        if samples_lights:
            path = add_direct_light(scene, path, surface, wo, p, scattered, active)

        # Where the path continues.
        dimension = vertex_dimension(path.steps)
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        u = get_1d(path.sampler, dimension + BSDF_CHOICE)
        turning = active & ~scattered
        if nulls:
            # The last surface may be a hole, behind which the last edge continues.
            turning = met & ~passing
        wi, weight, pdf, flags = sample_bsdf(scene, surface, wo, u, u2, turning)
        turn = Turn(to_world(surface, wi), weight, pdf, (flags & DELTA) != 0)
        if nulls:
            # Holes in a surface are no vertices either.
            hole = turning & ((flags & NULL) != 0)
            passing, active = passing | hole, active & ~hole
        turn = turn_in_medium(scene, path, u2, active & scattered, turn)
        beta = path.beta * turn.weight
        # Filters with negative lobes weigh some paths negatively.
        largest = max_component(absolute_vec3(beta))
        # Not "largest > 0": a NaN must live on and be counted by the film.
        active = active & ~(largest <= 0.0)
        d = where(passing, path.d, turn.d)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        medium = medium_beyond(scene, surface, d, path.medium)
        on = replace(
            path, o=where(scattered, p, o), d=d, medium=where(scattered, path.medium, medium)
        )
        lights = where(turn.delta, lanes_vec3(0.0), path.ours * (1.0 / maximum(turn.pdf, 1e-30)))
        vertex = replace(
            on, p=p, beta=beta, pdf=turn.pdf, delta=turn.delta, depth=depth, lights=lights,
            active=active,
        )  # fmt: skip
        if roulette:
            # The weight of a channel alone may be large.
            brightness = largest / mean(path.ours)
            if refracting:
                # A path in glass is not dim: it regains on the way out what it lost on the way in.
                gathered = concentration(scene, surface, wi)
                brightness = brightness * where(scattered, 1.0, gathered)
            vertex = play_roulette(settings, vertex, dimension, brightness)
        going = vertex.active | passing
        path = where(passing, on, vertex)
        return replace(path, sampler=on.sampler, active=going, rays=on.rays)

    return volpath_step


# ---------------------------------------------------------------- media


@specialised
def pass_media(program):
    """``(scene, path, t) -> (path, scattered, t)``: collide before the surface at t, or do not.

    The path that comes back is one step on, with its throughput and densities up to there.
    """
    return _fly if program.media else _pass_nothing


@kernel
def _pass_nothing(scene, path, t):
    return replace(path, steps=path.steps + 1), lanes_mask(False), t


@kernel
def _fly(scene, path, t):
    first = path.steps == 0
    medium = where(first, lanes_u32(0) + scene.media.start[0], path.medium)
    within = path.active & (medium != 0)
    path, scattered = replace(path, medium=medium), lanes_mask(False)
    if any_lane(within):
        u = get_1d(path.sampler, vertex_dimension(path.steps + 1) + FREE_FLIGHT)
        stream = stream_of(path.sampler, 2 * path.steps)
        segment = Segment(path.o, path.d, t, medium, path.channel, stream)
        flight = fly(scene, segment, u, within)
        scattered = within & flight.scattered
        t = where(scattered, flight.t, t)
        path = replace(
            path,
            beta=where(within, path.beta * flight.factor, path.beta),
            ours=where(within, path.ours * flight.factor, path.ours),
            lights=where(within, path.lights * flight.light, path.lights),
        )
        path = shine(scene, path, t, flight.albedo, scattered)
        path = replace(path, beta=where(scattered, path.beta * flight.albedo, path.beta))
    return replace(path, steps=path.steps + 1), scattered, t


@specialised
def shine(program):
    """``(scene, path, t, albedo, scattered) -> path``: with the light that the medium emits at t.

    A collision is an absorption with the probability 1 - albedo; absorbed is what is emitted, times
    the medium's emission (Kirchhoff). No other strategy finds this light.
    """
    return _shine if EMISSIVE in program.media else _stay_dark


@kernel
def _stay_dark(scene, path, t, albedo, scattered):
    return path


@kernel
def _shine(scene, path, t, albedo, scattered):
    Le = emission(scene, where(scattered, path.medium, 0), path.o + t * path.d)
    absorbed = lanes_vec3(1.0) - albedo
    emitted = path.beta * absorbed * Le * (1.0 / mean(path.ours))
    return gather_light(path, emitted, scattered, path.depth <= 1)


@specialised
def turn_in_medium(program):
    """``(scene, path, u2, scattered, turn) -> turn``: by the phase function where `scattered`."""
    return _turn if program.media else _keep_turn


@kernel
def _keep_turn(scene, path, u2, scattered, turn):
    return turn


@kernel
def _turn(scene, path, u2, scattered, turn):
    if any_lane(scattered):
        wi, density = sample_phase(scene, path.medium, path.d, u2, scattered)
        turn = where(scattered, Turn(wi, lanes_vec3(1.0), density, lanes_mask(False)), turn)
    return turn


@specialised
def phase_towards_light(program):
    """``(scene, path, wi, scattered, f, pdf) -> (f, pdf)``: the phase function in their place."""
    return _towards_light if program.media else _keep_values


@kernel
def _keep_values(scene, path, wi, scattered, f, pdf):
    return f, pdf


@kernel
def _towards_light(scene, path, wi, scattered, f, pdf):
    if any_lane(scattered):
        density = evaluate_phase(scene, path.medium, path.d, wi, scattered)
        f = where(scattered, lanes_vec3(1.0) * density, f)
        pdf = where(scattered, density, pdf)
    return f, pdf


# ---------------------------------------------------------------- light


def _write_add_direct_light(chosen_weight, by_light):
    """Light sampling at surfaces and in media.

    ``(scene, path, surface, wo, p, scattered, active) -> path``; p is the surface's point, or where
    paths scattered. Only delta lights count unless `by_light`.
    """

    @kernel
    def add_direct_light(scene, path, surface, wo, p, scattered, active):
        rays = path.rays
        dimension = vertex_dimension(path.steps)
        # Media have no normal.
        n = where(scattered, lanes_vec3(0.0), lit_normal(surface.ns, wo))
        light = sample_light(
            scene, p, n, get_1d(path.sampler, dimension + LIGHT_CHOICE),
            get_2d(path.sampler, dimension + LIGHT_POINT), active,
        )  # fmt: skip
        lit = active & (light.pdf > 0.0)
        if not by_light:
            lit = lit & light.delta
        if any_lane(lit):
            wi = to_local(surface, light.wi)
            f_cos, pdf = evaluate_bsdf(scene, surface, wo, wi, lit & ~scattered)
            f_cos, pdf = phase_towards_light(scene, path, light.wi, lit & scattered, f_cos, pdf)
            lit = lit & ~(max_component(f_cos) <= 0.0)
            o, end = shadow_ray(surface, light)
            o = where(scattered, p, o)
            free = shadow_length(light.distance, light.cosine, light.error, 0.0)
            end = where(scattered, free, end)
            medium = medium_beyond(scene, surface, light.wi, path.medium)
            medium = where(scattered, path.medium, medium)
            stream = stream_of(path.sampler, 2 * path.steps + 1)
            segment = Segment(o, light.wi, end, medium, path.channel, stream)
            crossing, _, rays = come_through(scene, segment, UNLIMITED, lit, rays)
            lit = lit & (max_component(crossing.passed) > 0.0)
            w = chosen_weight(path, light, pdf, crossing) * crossing.boost
            Ld = path.beta * f_cos * light.radiance * crossing.passed * w
            path = gather_light(path, Ld, lit, path.depth == 0)
        return replace(path, rays=rays)

    return add_direct_light


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
