r"""Paths that start at lights: where their flux goes, whoever looks at it.

A path carries the flux :math:`\beta` of its last ray, watts. Where it meets a surface, from the
direction :math:`\omega_l`, it goes on along :math:`\omega_o` with

.. math::
    \beta\, f(\omega_o, \omega_l)\, |\omega_l \cdot n_s|\,
    \frac{|\omega_o \cdot n_g|}{|\omega_l \cdot n_g|}

over the density of :math:`\omega_o`. Materials are evaluated as paths from the camera see them. The
quotient of the geometric cosines is Veach's correction for shading normals: without it, the two
directions of a path would carry different light. Flux is not concentrated in glass as radiance is:
where a delta lobe refracts, the factor 1 / eta^2 of its weight is undone.

Source: Veach 1997, Robust Monte Carlo methods for light transport simulation, sections 5.2 and 5.3.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import (
    has_null,
    refracts,
    squared_index,
)
from alight.core.constants import INFINITY
from alight.core.vec import absolute_vec3, dot, max_component
from alight.integrators.interiors.dispersed import at_wavelength_of
from alight.integrators.interiors.enclosing import begin_inside, bodies_beyond, come_to
from alight.integrators.roulette import play_roulette
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    count_lanes,
    empty_paths,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.lights.emission.sampling import sample_emission
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import spawn_origin
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import absolute, any_lane, lanes, lanes_u32, where

#: Where light arrives. surface; wl: unit direction that it comes from, in the shading frame;
#: per_cos: float, 1 / |wl . n_g|.
Arrival = namedtuple("Arrival", "surface wl per_cos")

#: Where light goes on. d: unit direction; weight: factor of the flux; pdf: per steradian, `reverse`
#: that of the way back (0 of a delta lobe); flags: of `sample_bsdf`.
Turn = namedtuple("Turn", "d weight pdf reverse flags")


@kernel
def set_out(scene, settings, new, sampler):
    """`set_out_by` the first numbers of a vertex."""
    return set_out_by(scene, settings, new, sampler, vertex_dimension(lanes_u32(1)))


@kernel
def set_out_by(scene, settings, new, sampler, first):
    """Start paths in the lanes `new`, by the random numbers from the dimension `first` on.

    Returns
    -------
    path : PathState
        Its density is the brightness that it starts with.
    emission : Emission
    """
    u, u2 = get_1d(sampler, first + LIGHT_CHOICE), get_2d(sampler, first + LIGHT_POINT)
    e = sample_emission(scene, u, u2, get_2d(sampler, first + BSDF_DIRECTION))
    brightness = max_component(e.flux)
    path = replace(
        empty_paths(),
        o=e.o,
        d=e.d,
        p=e.p,
        beta=e.flux,
        pdf=brightness,
        sampler=sampler,
        active=new & ~(brightness <= 0.0) & (lanes_u32(1) < settings.max_depth),
    )
    return begin_inside(scene, path, path.active), e


def write_arrive(program):
    """``(scene, path) -> (path, arrival)``: the flux that reaches the next surface.

    Paths stay active where there is one; they are still on the edge that leads to it.
    """

    @kernel
    def arrive(scene, path):
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        rays = path.rays + count_lanes(path.active)
        active = path.active & (hit.t < INFINITY)
        surface = make_surface(scene, hit, path.o, path.d, active)
        surface = at_wavelength_of(surface, path.sampler)
        # The viewer's side of a path from the camera is the far one here.
        wl = to_local(surface, -path.d)
        path = come_to(scene, path, surface, hit.t, active, active)
        cos_l = absolute(dot(surface.ng, path.d))
        active = active & (cos_l > 0.0)
        per_cos = 1.0 / where(active, cos_l, 1.0)
        path = replace(path, active=active, rays=rays)
        return path, Arrival(surface, wl, per_cos)

    return arrive


def write_leave(program):
    """``(scene, settings, path, arrival) -> (path, flags)``: where the flux continues.

    It plays roulette, if there is one; the flags are those of the direction.
    """
    turn, follow = write_turn(program), write_follow(program)

    @kernel
    def leave(scene, settings, path, arrival):
        depth = path.depth + 1
        path = replace(path, active=path.active & (depth < settings.max_depth))
        dimension = vertex_dimension(depth + 1)
        way = turn(scene, path, arrival, dimension)
        return follow(scene, settings, path, arrival.surface, way, dimension), way.flags

    return leave


def write_turn(program):
    """``(scene, path, arrival, dimension) -> Turn``: directions of active paths from a surface.

    They are chosen by the random numbers from `dimension` on.
    """
    refracting = refracts(program)

    @kernel
    def turn(scene, path, arrival, dimension):
        surface, wl, per_cos = arrival.surface, arrival.wl, arrival.per_cos
        active, sampler = path.active, path.sampler
        wo, weight, pdf, flags = sample_bsdf(
            scene, surface, wl, get_1d(sampler, dimension + BSDF_CHOICE),
            get_2d(sampler, dimension + BSDF_DIRECTION), active,
        )  # fmt: skip
        d = to_world(surface, wo)
        corrected = absolute(dot(surface.ng, d)) * per_cos
        delta = (flags & DELTA) != 0
        smooth, reverse = active & ~delta & (pdf > 0.0), lanes(0.0)
        if any_lane(smooth):
            f_cos, reverse = evaluate_bsdf(scene, surface, wo, wl, smooth)
            weight = where(smooth, f_cos * (corrected / where(smooth, pdf, 1.0)), weight)
        # A delta lobe has the weight of radiance, from which two cosines have cancelled.
        turned = corrected * absolute(wl.z) / where(absolute(wo.z) > 0.0, absolute(wo.z), 1.0)
        if refracting:
            inside, outside = squared_index(scene, surface, wo), squared_index(scene, surface, wl)
            turned = turned * inside / outside
        weight = where(delta & ((flags & NULL) == 0), weight * turned, weight)
        return Turn(d, weight, pdf, reverse, flags)

    return turn


def write_follow(program):
    """``(scene, settings, path, surface, turn, dimension) -> path``: active paths on their way."""
    holes = has_null(program)
    roulette = program.option("russian_roulette") == "throughput"

    @kernel
    def follow(scene, settings, path, surface, turn, dimension):
        active, depth, d = path.active, path.depth + 1, turn.d
        beta = where(active, path.beta * turn.weight, path.beta)
        # Weights of wavelengths have negative channels.
        brightness = max_component(absolute_vec3(beta))
        # Not "brightness > 0": a NaN must live on and be counted by the film.
        active = active & ~(brightness <= 0.0) & (depth + 1 < settings.max_depth)
        o = spawn_origin(surface.p, surface.error, surface.ng, d)
        bodies = bodies_beyond(scene, path.bodies, surface, path.d, d)
        on = replace(
            path, o=o, d=d, p=surface.p, beta=beta, depth=depth, active=active, bodies=bodies
        )
        if roulette:
            # Of the flux that the path began with.
            on = play_roulette(settings, on, dimension, brightness / path.pdf)
        if holes:
            beyond = spawn_origin(surface.p, surface.error, surface.ng, path.d)
            unseen = replace(path, o=beyond, beta=beta, depth=depth, active=active, bodies=bodies)
            on = where((turn.flags & NULL) != 0, unseen, on)
        return replace(on, sampler=path.sampler, rays=path.rays)

    return follow
