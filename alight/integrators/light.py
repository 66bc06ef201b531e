r"""Light tracing: paths start at the lights, and each of their vertices is seen by the camera.

A path carries the flux :math:`\beta` of its last ray, watts. Where it meets a surface, from the
direction :math:`\omega_l`, it adds to the pixel that sees the point from :math:`\omega_c`

.. math::
    \beta\, f(\omega_c, \omega_l)\, |\omega_l \cdot n_s|\,
    \frac{|\omega_c \cdot n_g|}{|\omega_l \cdot n_g|}\, W

with the importance W of the camera (`alight.cameras.connection`), and goes on along
:math:`\omega_o` with the same expression over the density of :math:`\omega_o` in the place of W.
Materials are evaluated as paths from the camera see them. The quotient of the geometric cosines is
Veach's correction for shading normals: without it, the two directions of a path would carry
different light. Flux is not concentrated in glass as radiance is: where a lobe of Dirac refracts,
its weight's 1 / eta^2 is taken back.

What the camera sees in a mirror or through clear glass no light path can connect to: it stays
black. Light tracing is for what path tracing cannot find, caustics above all.

Source: Arvo, Backward ray tracing, SIGGRAPH 1986 course notes; Dutre, Lafortune and Willems, Monte
Carlo light tracing with direct computation of pixel intensities, Compugraphics 1993; Veach 1997,
Robust Monte Carlo methods for light transport simulation, sections 5.2 and 5.3.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, ClassVar, Literal, Self

from pydantic import model_validator

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import absorbs, has_null, refracts, squared_index, transmittance
from alight.cameras.rays import connect_camera, connect_far_camera, sees_far
from alight.core.constants import INFINITY
from alight.core.noise_only import NoiseOnly
from alight.core.spec import Depth, Integrator, invalid
from alight.core.vec import dot, max_component
from alight.filters.splatting import choose_pixel
from alight.integrators.roulette import play_roulette
from alight.integrators.shadow_rays import come_through_holes
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    count_lanes,
    no_paths,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.emission_sampling import emission_towards, is_around, sample_emission
from alight.lights.environment_emission import arriving_pdf
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, any_lane, lanes, lanes_mask, lanes_u32, lanes_vec3, where

#: Further places among the dimensions of a vertex: the pixel that a point belongs to, the lens.
PIXEL, LENS_POINT = 7, 9

#: Light for one pixel. x, y: whole floats, pixels of the full film; value: what it adds to the mean
#: over all light paths; lit: mask.
Splat = namedtuple("Splat", "x y value lit")


class Light(Integrator):
    """Light tracer.

    Parameters
    ----------
    russian_roulette : {"throughput", "none"}, default "throughput"
        Whether dim paths end at random, with weights that keep the mean.
    rr_depth : int >= 1, default 5
        Depth from which roulette is played.
    max_depth : int >= 1, optional
        Longest path, counted in edges: 1 shows lights only, 2 adds direct light. Unlimited by
        default, which needs roulette.
    """

    splats: ClassVar[bool] = True
    type: Literal["light"] = "light"
    russian_roulette: Annotated[Literal["throughput", "none"], NoiseOnly()] = "throughput"
    rr_depth: Annotated[Depth, NoiseOnly()] = 5
    max_depth: Depth | None = None

    @property
    def longest_path(self) -> int | None:
        """As `max_depth` says."""
        return self.max_depth

    @property
    def choice_of_lights(self) -> str:
        """By their power."""
        return "power"

    @model_validator(mode="after")
    def _paths_end(self) -> Self:
        if self.max_depth is None and self.russian_roulette == "none":
            raise invalid("paths would never end: give max_depth or russian_roulette: throughput")
        return self


EXAMPLES = (
    Light(),
    Light(max_depth=8, rr_depth=3),
    Light(max_depth=3, russian_roulette="none"),
)


# ---------------------------------------------------------------- towards the camera


def _write_arrive(program):
    """``(scene, settings, sampler, depth, c, o, lit, value) -> (splat, rays)`` for connections.

    o is where the ray to the camera starts, `value` what it carries but for what is in its way.
    """
    holes = has_null(program)

    @kernel
    def arrive(scene, settings, at, end, lit, value):
        sampler, depth, c, o = at
        lit = lit & c.visible & ~(max_component(value) <= 0.0)
        u2 = get_2d(sampler, vertex_dimension(depth + 1) + PIXEL)
        x, across = choose_pixel(scene, where(lit, c.x, 0.0), u2[0])
        y, down = choose_pixel(scene, where(lit, c.y, 0.0), u2[1])
        lit = lit & (absolute(across * down) > 0.0)
        rays = 0 if holes else count_lanes(lit)
        value = value * (across * down)
        if any_lane(lit):
            if holes:
                most = lanes_u32(0) + settings.max_depth - depth - 1
                share, _, rays = come_through_holes(scene, o, c.w, end, most, lit, rays)
                lit = lit & (share > 0.0)
                value = value * share
            else:
                lit = lit & ~is_occluded(scene, o, c.w, end, lit)
        return Splat(x, y, where(lit, value, lanes_vec3(0.0)), lit), rays

    return arrive


@kernel
def lens_numbers(sampler, depth):
    """The pair that chooses the point of the lens at the vertex after `depth` edges."""
    return get_2d(sampler, vertex_dimension(depth + 1) + LENS_POINT)


# ---------------------------------------------------------------- paths


@kernel
def _sees_nothing(scene, settings, e, numbers, new):
    zero = lanes(0.0)
    return Splat(zero, zero, lanes_vec3(0.0), lanes_mask(False)), 0


def _write_see_lamps(program, arrive):
    """``(scene, settings, e, (sampler, u, u2), new) -> (splat, rays)``: shapes that shine."""
    if not on_shapes(program):
        return _sees_nothing

    @kernel
    def see_lamps(scene, settings, e, numbers, new):
        sampler, u, u2 = numbers
        depth = lanes_u32(0)
        c = connect_camera(scene, e.p, lens_numbers(sampler, depth))
        intensity, o = emission_towards(scene, e.light, u, u2, c.o)
        at = (sampler, depth, c, o)
        return arrive(scene, settings, at, c.distance, new, intensity * c.importance)

    return see_lamps


def _write_see_surroundings(program, arrive):
    """The same of light from infinity."""
    if not environments_of(program) or not sees_far(program):
        return _sees_nothing
    count = max(len(program.environments), 1)

    @kernel
    def see_surroundings(scene, settings, e, numbers, new):
        sampler, _, _ = numbers
        depth, wi = lanes_u32(0), -e.d
        c = connect_far_camera(scene, wi, lens_numbers(sampler, depth))
        density = e.choice * arriving_pdf(scene, e.p, wi)
        around = new & is_around(scene, e.light, count) & (density > 0.0)
        value = environment_radiance(scene, wi) * (c.importance / where(around, density, 1.0))
        # From the camera outwards: at its other end the ray has no place to start from.
        back = (sampler, depth, replace(c, w=wi), c.o)
        return arrive(scene, settings, back, lanes(INFINITY), around, value)

    return see_surroundings


def begin(program):
    """The kernel that starts paths at lights: ``(scene, settings, new, sampler)``.

    It returns the paths of the lanes `new`, and the splats of lights that the camera sees.
    """
    arrive = _write_arrive(program)
    see_lamps = _write_see_lamps(program, arrive)
    see_surroundings = _write_see_surroundings(program, arrive)

    @kernel
    def begin_light_paths(scene, settings, new, sampler):
        first = vertex_dimension(lanes_u32(1))
        u, u2 = get_1d(sampler, first + LIGHT_CHOICE), get_2d(sampler, first + LIGHT_POINT)
        e = sample_emission(scene, u, u2, get_2d(sampler, first + BSDF_DIRECTION))
        brightness = max_component(e.flux)
        numbers = (sampler, u, u2)
        splat, rays = see_lamps(scene, settings, e, numbers, new)
        far, more = see_surroundings(scene, settings, e, numbers, new)
        path = replace(
            no_paths(),
            o=e.o,
            d=e.d,
            p=e.p,
            beta=e.flux,
            pdf=brightness,
            sampler=sampler,
            active=new & ~(brightness <= 0.0) & (lanes_u32(1) < settings.max_depth),
            rays=rays + more,
        )
        return path, where(far.lit, far, splat)

    return begin_light_paths


def extend(program):
    """The kernel that extends paths by one vertex: ``(scene, settings, path) -> (path, splat)``."""
    arrive, holes = _write_arrive(program), has_null(program)
    absorbing, refracting = absorbs(program), refracts(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def extend_light_paths(scene, settings, path):
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        rays = path.rays + count_lanes(path.active)
        active, depth = path.active & (hit.t < INFINITY), path.depth + 1
        surface = make_surface(scene, hit, path.o, path.d, active)
        # The viewer's side of a path from the camera is the far one here.
        wl, sampler = to_local(surface, -path.d), path.sampler
        beta = path.beta
        if absorbing:
            share = transmittance(scene, surface, wl, where(active, hit.t, 0.0))
            beta = where(active, beta * share, beta)
        cos_l = absolute(dot(surface.ng, path.d))
        active = active & (cos_l > 0.0)
        per_cos = 1.0 / where(active, cos_l, 1.0)

        # The camera sees the point.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = active & (depth < settings.max_depth)
        f_cos, _ = evaluate_bsdf(scene, surface, to_local(surface, c.w), wl, seen)
        corrected = absolute(dot(surface.ng, c.w)) * per_cos * c.importance
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w))
        splat, more = arrive(scene, settings, at, c.distance, seen, beta * f_cos * corrected)

        # Where the path continues.
        active = active & (depth + 1 < settings.max_depth)
        dimension = vertex_dimension(depth + 1)
        wo, weight, pdf, flags = sample_bsdf(
            scene, surface, wl, get_1d(sampler, dimension + BSDF_CHOICE),
            get_2d(sampler, dimension + BSDF_DIRECTION), active,
        )  # fmt: skip
        d = to_world(surface, wo)
        corrected = absolute(dot(surface.ng, d)) * per_cos
        delta = (flags & DELTA) != 0
        smooth = active & ~delta & (pdf > 0.0)
        if any_lane(smooth):
            f_cos, _ = evaluate_bsdf(scene, surface, wo, wl, smooth)
            weight = where(smooth, f_cos * (corrected / where(smooth, pdf, 1.0)), weight)
        # A lobe of Dirac has the weight of radiance, from which two cosines have cancelled.
        turned = corrected * absolute(wl.z) / where(absolute(wo.z) > 0.0, absolute(wo.z), 1.0)
        if refracting:
            inside, outside = squared_index(scene, surface, wo), squared_index(scene, surface, wl)
            turned = turned * inside / outside
        straight = (flags & NULL) != 0
        weight = where(delta & ~straight, weight * turned, weight)
        beta = where(active, beta * weight, beta)
        brightness = max_component(beta)
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        on = replace(path, o=o, d=d, p=surface.p, beta=beta, depth=depth, active=active)
        if roulette:
            # Of the flux that the path began with.
            on = play_roulette(settings, on, dimension, brightness / path.pdf)
        if holes:
            beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
            unseen = replace(path, o=beyond, beta=beta, depth=depth, active=active)
            on = where(straight, unseen, on)
        return replace(on, sampler=sampler, rays=rays + more), splat

    return extend_light_paths
