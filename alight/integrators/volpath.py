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

from typing import ClassVar, Literal

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import concentration, has_null, is_null, refracts
from alight.core.constants import INFINITY
from alight.core.vec import max_component
from alight.integrators.options import PathTracing
from alight.integrators.path import (
    BY_BSDF,
    BY_LIGHT,
    MIS,
    NO_LISTENERS,
    STRATEGIES,
    write_reach_environment,
    write_reach_lamp,
)
from alight.integrators.shadow_rays import come_through
from alight.integrators.volume_walk import (
    FREE_FLIGHT,
    mean,
    medium_beyond,
)
from alight.integrators.volume_walk import empty_paths as empty_paths
from alight.integrators.volume_walk import put_more as put_more
from alight.integrators.volume_walk import start_paths as start_paths
from alight.integrators.volume_walk import take_more as take_more
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    MAX_SURVIVAL,
    ROULETTE,
    UNLIMITED,
    count_lanes,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.hits import on_shapes
from alight.lights.sampling import (
    environments_of,
    has_delta_lights,
    lit_normal,
    sample_light,
    shadow_ray,
)
from alight.media.sampling import evaluate_phase, fly, sample_phase
from alight.media.tables import EMISSIVE, stream_of
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
    minimum,
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
    play_roulette = _write_play_roulette(refracts(program))
    hides = program.option("hide_emitters", False)

    @kernel
    def volpath_step(scene, settings, path):
        """One more surface or collision of each path."""
        rays = path.rays + count_lanes(path.active)
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        # The media on the way: a collision comes before the surface, or none does.
        path, scattered, t = pass_media(scene, path, hit.t)
        depth = path.depth + 1
        missed = path.active & ~scattered & (hit.t == INFINITY)
        met = path.active & ~scattered & (hit.t < INFINITY)
        L, L_direct = path.L, path.L_direct
        if hides:
            missed = missed & (path.depth > 0)
        if environment:
            L, L_direct = reach_environment(scene, path, depth, missed, L, L_direct)
        surface = make_surface(scene, hit, path.o, path.d, met)

        # Surfaces that are not there are no vertices, nor lights that the camera looks through.
        passing, shining = lanes_mask(False), met
        if nulls:
            passing = met & is_null(scene, surface.bsdf)
        if hides:
            hidden = met & (path.depth == 0) & (surface.light != 0)
            passing, shining = passing | hidden, met & ~hidden
        if area_lights:
            L, L_direct = reach_lamp(scene, path, hit, surface, depth, shining, L, L_direct)
        active = (met | scattered) & ~passing & (depth < settings.max_depth)
        p = where(scattered, path.o + t * path.d, surface.p)
        wo = to_local(surface, -path.d)
        if samples_lights:
            L, L_direct, rays = add_direct_light(
                scene, path, surface, p, wo, scattered, depth, active, L, L_direct, rays
            )

        # Where the path continues.
        dimension = vertex_dimension(path.steps)
        u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
        u = get_1d(path.sampler, dimension + BSDF_CHOICE)
        turning = active & ~scattered
        if nulls:
            # The last surface may be a hole, behind which the last edge continues.
            turning = met & ~passing
        wi, weight, pdf, flags = sample_bsdf(scene, surface, wo, u, u2, turning)
        d = to_world(surface, wi)
        delta = (flags & DELTA) != 0
        if nulls:
            # Holes in a surface are no vertices either.
            hole = turning & ((flags & NULL) != 0)
            passing, active = passing | hole, active & ~hole
        d, weight, pdf, delta = turn_in_medium(
            scene, path, u2, active & scattered, d, weight, pdf, delta
        )
        beta = path.beta * weight
        # Not "largest > 0": a NaN must live on and be counted by the film.
        active = active & ~(max_component(beta) <= 0.0)
        if roulette:
            beta, active = play_roulette(
                scene, settings, path, surface, wi, scattered, depth, beta, active
            )
        lights = where(delta, lanes_vec3(0.0), path.ours * (1.0 / maximum(pdf, 1e-30)))
        d = where(passing, path.d, d)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        medium = medium_beyond(scene, surface, d, path.medium)
        on = replace(
            path, o=where(scattered, p, o), d=d, L=L, L_direct=L_direct,
            medium=where(scattered, path.medium, medium),
        )  # fmt: skip
        vertex = replace(on, p=p, beta=beta, pdf=pdf, delta=delta, depth=depth, lights=lights)
        path = where(passing, on, vertex)
        return replace(path, sampler=on.sampler, active=active | passing, rays=rays)

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
    moved = _moved(path, path.L, path.L_direct, path.medium, path.beta, path.ours, path.lights)
    return moved, lanes_mask(False), t


@kernel
def _fly(scene, path, t):
    first = path.steps == 0
    medium = where(first, lanes_u32(0) + scene.media.start[0], path.medium)
    within = path.active & (medium != 0)
    beta, ours, lights, scattered = path.beta, path.ours, path.lights, lanes_mask(False)
    L, L_direct = path.L, path.L_direct
    if any_lane(within):
        u = get_1d(path.sampler, vertex_dimension(path.steps + 1) + FREE_FLIGHT)
        stream = stream_of(path.sampler, 2 * path.steps)
        flight = fly(scene, medium, path.o, path.d, t, path.channel, u, stream, within)
        scattered = within & flight.scattered
        t = where(scattered, flight.t, t)
        beta = where(within, beta * flight.factor, beta)
        ours = where(within, ours * flight.factor, ours)
        lights = where(within, lights * flight.light, lights)
        L, L_direct = shine(scene, path, medium, t, beta, ours, flight.albedo, scattered)
        beta = where(scattered, beta * flight.albedo, beta)
    return _moved(path, L, L_direct, medium, beta, ours, lights), scattered, t


@specialised
def shine(program):
    """``(scene, path, medium, t, beta, ours, albedo, scattered) -> (L, L_direct)``: with its light.

    A collision is an absorption with the probability 1 - albedo; absorbed is what is emitted, times
    the medium's emission (Kirchhoff). No other strategy finds this light.
    """
    return _shine if EMISSIVE in program.media else _stay_dark


@kernel
def _stay_dark(scene, path, medium, t, beta, ours, albedo, scattered):
    return path.L, path.L_direct


@kernel
def _shine(scene, path, medium, t, beta, ours, albedo, scattered):
    Le = emission(scene, where(scattered, medium, 0), path.o + t * path.d)
    absorbed = lanes_vec3(1.0) - albedo
    L = where(scattered, path.L + beta * absorbed * Le * (1.0 / mean(ours)), path.L)
    return L, where(scattered & (path.depth <= 1), L, path.L_direct)


@kernel
def _moved(path, L, L_direct, medium, beta, ours, lights):
    """The path with one more step, and these."""
    return replace(
        path, L=L, L_direct=L_direct, beta=beta, medium=medium, steps=path.steps + 1, ours=ours,
        lights=lights,
    )  # fmt: skip


@specialised
def turn_in_medium(program):
    """``(scene, path, u2, scattered, d, weight, pdf, delta)``: the last four anew.

    By the phase function, where the mask `scattered` holds.
    """
    return _turn if program.media else _keep_direction


@kernel
def _keep_direction(scene, path, u2, scattered, d, weight, pdf, delta):
    return d, weight, pdf, delta


@kernel
def _turn(scene, path, u2, scattered, d, weight, pdf, delta):
    if any_lane(scattered):
        wi, density = sample_phase(scene, path.medium, path.d, u2, scattered)
        d = where(scattered, wi, d)
        weight = where(scattered, lanes_vec3(1.0), weight)
        pdf = where(scattered, density, pdf)
        delta = delta & ~scattered
    return d, weight, pdf, delta


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

    ``(scene, path, surface, p, wo, scattered, depth, active, L, L_direct, rays)`` gives the last
    three anew. Only delta lights count unless `by_light`.
    """

    @kernel
    def add_direct_light(scene, path, surface, p, wo, scattered, depth, active, L, L_direct, rays):
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
            crossing, _, rays = come_through(
                scene, o, light.wi, end, medium, path.channel, stream, UNLIMITED, lit, rays
            )
            lit = lit & (max_component(crossing.passed) > 0.0)
            w = chosen_weight(path, light, pdf, crossing) * crossing.boost
            L = where(lit, L + path.beta * f_cos * light.radiance * crossing.passed * w, L)
            L_direct = where(lit & (depth <= 1), L, L_direct)
        return L, L_direct, rays

    return add_direct_light


def _write_play_roulette(refracting):
    """Ends dim paths at random, and lets the survivors carry their light.

    ``(scene, settings, path, surface, wi, scattered, depth, beta, active) -> (beta, active)``
    """

    @kernel
    def play_roulette(scene, settings, path, surface, wi, scattered, depth, beta, active):
        # What the path would bring of a white light: the weight of a channel alone may be large.
        bright = max_component(beta) / mean(path.ours)
        if refracting:
            # A path in glass is not dim: what it lost on the way in comes back on the way out.
            bright = bright * where(scattered, 1.0, concentration(scene, surface, wi))
        survival = minimum(bright, MAX_SURVIVAL)
        playing = depth >= settings.rr_depth
        survived = get_1d(path.sampler, vertex_dimension(path.steps) + ROULETTE) < survival
        active = active & (survived | ~playing)
        return where(playing, beta / survival, beta), active

    return play_roulette


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
