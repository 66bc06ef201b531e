r"""Light tracing: paths start at the lights, and each of their vertices is seen by the camera.

Where a path of flux :math:`\beta` meets a surface (`alight.integrators.both_ends.light_walk`), from
the direction :math:`\omega_l`, it adds to the pixel that sees the point from :math:`\omega_c`

.. math::
    \beta\, f(\omega_c, \omega_l)\, |\omega_l \cdot n_s|\,
    \frac{|\omega_c \cdot n_g|}{|\omega_l \cdot n_g|}\, W

with the importance W of the camera (`alight.cameras.connection`).

Light paths cannot connect to what the camera sees in a mirror or through clear glass, so it stays
black. Light tracing is for what path tracing cannot find, caustics above all.

Source: Arvo, Backward ray tracing, SIGGRAPH 1986 course notes; Dutre, Lafortune and Willems, Monte
Carlo light tracing with direct computation of pixel intensities, Compugraphics 1993; Veach 1997,
Robust Monte Carlo methods for light transport simulation, section 5.3.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.cameras.rays import connect_camera, connect_far_camera, sees_far
from alight.core.constants import INFINITY
from alight.core.vec import dot
from alight.integrators.both_ends.light_walk import set_out, write_arrive, write_leave
from alight.integrators.both_ends.splats import Splat, lens_numbers, write_show
from alight.integrators.interiors.dispersed import meet_dispersion
from alight.integrators.interiors.enclosing import bodies_beyond
from alight.integrators.options import PathLengths
from alight.integrators.walk import (
    LIGHT_CHOICE,
    LIGHT_POINT,
    to_local,
    vertex_dimension,
)
from alight.lights.emission.from_environments import arriving_pdf
from alight.lights.emission.sampling import emission_towards, is_around
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, lanes, lanes_mask, lanes_u32, lanes_vec3, where


class Light(PathLengths):
    """Light tracer."""

    sees_dispersion: ClassVar[bool] = True
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


def _write_see_lamps(program, show):
    """``(scene, settings, e, numbers, new) -> (splat, rays)``: shapes that shine.

    numbers: (sampler, u, u2, bodies), with the `Bodies` that the paths begin in.
    """
    if not on_shapes(program):
        return _sees_nothing

    @kernel
    def see_lamps(scene, settings, e, numbers, new):
        sampler, u, u2, around = numbers
        depth = lanes_u32(0)
        c = connect_camera(scene, e.p, lens_numbers(sampler, depth))
        intensity, o = emission_towards(scene, e.light, u, u2, c.o)
        at = (sampler, depth, c, o, around)
        return show(scene, settings, at, c.distance, new, intensity * c.importance)

    return see_lamps


def _write_see_surroundings(program, show):
    """The same of light from infinity."""
    if not environments_of(program) or not sees_far(program):
        return _sees_nothing
    count = max(len(program.environments), 1)

    @kernel
    def see_surroundings(scene, settings, e, numbers, new):
        sampler, _, _, bodies = numbers
        depth, wi = lanes_u32(0), -e.d
        c = connect_far_camera(scene, wi, lens_numbers(sampler, depth))
        density = e.choice * arriving_pdf(scene, e.p, wi)
        around = new & is_around(scene, e.light, count) & (density > 0.0)
        value = environment_radiance(scene, wi) * (c.importance / where(around, density, 1.0))
        # From the camera outwards: at its other end the ray has no place to start from.
        back = (sampler, depth, replace(c, w=wi), c.o, bodies)
        return show(scene, settings, back, lanes(INFINITY), around, value)

    return see_surroundings


def begin(program):
    """The kernel that starts paths at lights: ``(scene, settings, new, sampler)``.

    It returns the paths of the lanes `new`, and the splats of lights that the camera sees.
    """
    show = write_show(program)
    see_lamps = _write_see_lamps(program, show)
    see_surroundings = _write_see_surroundings(program, show)

    @kernel
    def begin_light_paths(scene, settings, new, sampler):
        path, e = set_out(scene, settings, new, sampler)
        first = vertex_dimension(lanes_u32(1))
        numbers = (
            sampler, get_1d(sampler, first + LIGHT_CHOICE), get_2d(sampler, first + LIGHT_POINT),
            path.bodies,
        )  # fmt: skip
        splat, rays = see_lamps(scene, settings, e, numbers, new)
        far, more = see_surroundings(scene, settings, e, numbers, new)
        return replace(path, rays=path.rays + rays + more), where(far.lit, far, splat)

    return begin_light_paths


def extend(program):
    """The kernel that extends paths by one vertex: ``(scene, settings, path) -> (path, splat)``."""
    show, arrive, leave = write_show(program), write_arrive(program), write_leave(program)

    @kernel
    def extend_light_paths(scene, settings, path):
        path, arrival = arrive(scene, path)
        path = meet_dispersion(scene, arrival.surface, path, path.active)
        surface, wl, per_cos = arrival.surface, arrival.wl, arrival.per_cos
        sampler, depth = path.sampler, path.depth + 1

        # The camera sees the point.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = path.active & (depth < settings.max_depth)
        wc = to_local(surface, c.w)
        f_cos, _ = evaluate_bsdf(scene, surface, wc, wl, seen)
        corrected = absolute(dot(surface.ng, c.w)) * per_cos * c.importance
        around = bodies_beyond(scene, path.bodies, surface, path.d, c.w)
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w), around)
        value = path.beta * f_cos * corrected
        splat, more = show(scene, settings, at, c.distance, seen, value)

        path, _ = leave(scene, settings, path, arrival)
        return replace(path, rays=path.rays + more), splat

    return extend_light_paths
