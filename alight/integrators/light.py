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

from typing import ClassVar, Literal

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.switch import has_null
from alight.cameras.rays import connect_camera, connect_far_camera, sees_far
from alight.core.constants import INFINITY
from alight.core.vec import dot, max_component
from alight.integrators.light_walk import (
    Splat,
    lens_numbers,
    write_arrive,
    write_meet,
    write_turn,
)
from alight.integrators.options import PathLengths
from alight.integrators.roulette import play_roulette
from alight.integrators.walk import (
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    no_paths,
    to_local,
    vertex_dimension,
)
from alight.lights.emission_sampling import emission_towards, is_around, sample_emission
from alight.lights.environment_emission import arriving_pdf
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, lanes, lanes_mask, lanes_u32, lanes_vec3, where


class Light(PathLengths):
    """Light tracer."""

    splats: ClassVar[bool] = True
    type: Literal["light"] = "light"

    @property
    def choice_of_lights(self) -> str:
        """By their power."""
        return "power"


EXAMPLES = (
    Light(),
    Light(max_depth=8, rr_depth=3),
    Light(max_depth=3, russian_roulette="none"),
)


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
    arrive = write_arrive(program)
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
    arrive, holes = write_arrive(program), has_null(program)
    meet, turn = write_meet(program), write_turn(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def extend_light_paths(scene, settings, path):
        v = meet(scene, path)
        active, depth, sampler, surface = v.active, path.depth + 1, path.sampler, v.surface

        # The camera sees the point.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = active & (depth < settings.max_depth)
        f_cos, _ = evaluate_bsdf(scene, surface, to_local(surface, c.w), v.wl, seen)
        per_cos = 1.0 / where(active, v.cosine, 1.0)
        corrected = absolute(dot(surface.ng, c.w)) * per_cos * c.importance
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w))
        value = v.beta * f_cos * corrected
        splat, more = arrive(scene, settings, at, c.distance, seen, value)

        # Where the path continues.
        active = active & (depth + 1 < settings.max_depth)
        dimension = vertex_dimension(depth + 1)
        t = turn(scene, sampler, dimension, v, active)
        beta = where(active, v.beta * t.weight, v.beta)
        brightness = max_component(beta)
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0)
        o = spawn_origin(surface.p, surface.error, surface.ng, t.d)
        on = replace(path, o=o, d=t.d, p=surface.p, beta=beta, depth=depth, active=active)
        if roulette:
            # Of the flux that the path began with.
            on = play_roulette(settings, on, dimension, brightness / path.pdf)
        if holes:
            beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
            unseen = replace(path, o=beyond, beta=beta, depth=depth, active=active)
            on = where(t.straight, unseen, on)
        return replace(on, sampler=sampler, rays=v.rays + more), splat

    return extend_light_paths
