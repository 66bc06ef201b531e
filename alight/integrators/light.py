r"""Light tracing: paths start at the lights, and each of their vertices is seen by the camera.

Where a path of flux :math:`\beta` meets a surface (`alight.integrators.light_walk`), from the
direction :math:`\omega_l`, it adds to the pixel that sees the point from :math:`\omega_c`

.. math::
    \beta\, f(\omega_c, \omega_l)\, |\omega_l \cdot n_s|\,
    \frac{|\omega_c \cdot n_g|}{|\omega_l \cdot n_g|}\, W

with the importance W of the camera (`alight.cameras.connection`).

What the camera sees in a mirror or through clear glass no light path can connect to: it stays
black. Light tracing is for what path tracing cannot find, caustics above all.

Source: Arvo, Backward ray tracing, SIGGRAPH 1986 course notes; Dutre, Lafortune and Willems, Monte
Carlo light tracing with direct computation of pixel intensities, Compugraphics 1993; Veach 1997,
Robust Monte Carlo methods for light transport simulation, section 5.3.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, ClassVar, Literal, Self

from pydantic import model_validator

from alight.accel import is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.switch import has_null
from alight.cameras.rays import connect_camera, connect_far_camera, sees_far
from alight.core.constants import INFINITY
from alight.core.noise_only import NoiseOnly
from alight.core.spec import Depth, Integrator, invalid
from alight.core.vec import dot, max_component
from alight.filters.splatting import choose_pixel
from alight.integrators.light_walk import set_out, write_arrive, write_leave
from alight.integrators.shadow_rays import come_through_holes
from alight.integrators.walk import (
    LIGHT_CHOICE,
    LIGHT_POINT,
    count_lanes,
    to_local,
    vertex_dimension,
)
from alight.lights.emission_sampling import emission_towards, is_around
from alight.lights.environment_emission import arriving_pdf
from alight.lights.hits import on_shapes
from alight.lights.misses import environment_radiance, environments_of
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
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


def _write_show(program):
    """Connections: ``(scene, settings, (sampler, depth, c, o), end, lit, value) -> (splat, rays)``.

    o is where the ray to the camera starts, `value` what it carries but for what is in its way.
    """
    holes = has_null(program)

    @kernel
    def show(scene, settings, at, end, lit, value):
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

    return show


@kernel
def lens_numbers(sampler, depth):
    """The pair that chooses the point of the lens at the vertex after `depth` edges."""
    return get_2d(sampler, vertex_dimension(depth + 1) + LENS_POINT)


# ---------------------------------------------------------------- paths


@kernel
def _sees_nothing(scene, settings, e, numbers, new):
    zero = lanes(0.0)
    return Splat(zero, zero, lanes_vec3(0.0), lanes_mask(False)), 0


def _write_see_lamps(program, show):
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
        return show(scene, settings, at, c.distance, new, intensity * c.importance)

    return see_lamps


def _write_see_surroundings(program, show):
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
        return show(scene, settings, back, lanes(INFINITY), around, value)

    return see_surroundings


def begin(program):
    """The kernel that starts paths at lights: ``(scene, settings, new, sampler)``.

    It returns the paths of the lanes `new`, and the splats of lights that the camera sees.
    """
    show = _write_show(program)
    see_lamps = _write_see_lamps(program, show)
    see_surroundings = _write_see_surroundings(program, show)

    @kernel
    def begin_light_paths(scene, settings, new, sampler):
        path, e = set_out(scene, settings, new, sampler)
        first = vertex_dimension(lanes_u32(1))
        numbers = (
            sampler, get_1d(sampler, first + LIGHT_CHOICE), get_2d(sampler, first + LIGHT_POINT)
        )  # fmt: skip
        splat, rays = see_lamps(scene, settings, e, numbers, new)
        far, more = see_surroundings(scene, settings, e, numbers, new)
        return replace(path, rays=path.rays + rays + more), where(far.lit, far, splat)

    return begin_light_paths


def extend(program):
    """The kernel that extends paths by one vertex: ``(scene, settings, path) -> (path, splat)``."""
    show, arrive, leave = _write_show(program), write_arrive(program), write_leave(program)

    @kernel
    def extend_light_paths(scene, settings, path):
        path, arrival = arrive(scene, path)
        surface, wl, per_cos = arrival.surface, arrival.wl, arrival.per_cos
        sampler, depth = path.sampler, path.depth + 1

        # The camera sees the point.
        c = connect_camera(scene, surface.p, lens_numbers(sampler, depth))
        seen = path.active & (depth < settings.max_depth)
        f_cos, _ = evaluate_bsdf(scene, surface, to_local(surface, c.w), wl, seen)
        corrected = absolute(dot(surface.ng, c.w)) * per_cos * c.importance
        at = (sampler, depth, c, spawn_origin(surface.p, surface.error, surface.ng, c.w))
        splat, more = show(scene, settings, at, c.distance, seen, path.beta * f_cos * corrected)

        path, _ = leave(scene, settings, path, arrival)
        return replace(path, rays=path.rays + more), splat

    return extend_light_paths
