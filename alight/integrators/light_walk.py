"""What paths from lights do at a vertex: how the camera sees it, and where they continue.

Both follow the expressions of `alight.integrators.light`.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import intersect_closest, is_occluded
from alight.bsdfs.dispatch import evaluate_bsdf, sample_bsdf
from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.switch import absorbs, has_null, refracts, squared_index, transmittance
from alight.core.constants import INFINITY
from alight.core.vec import dot, max_component
from alight.filters.splatting import choose_pixel
from alight.integrators.shadow_rays import come_through_holes
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    count_lanes,
    to_local,
    to_world,
    vertex_dimension,
)
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.surfaces import make_surface
from lanewise.jit import kernel
from lanewise.simd import absolute, any_lane, lanes, lanes_u32, lanes_vec3, where

#: Further places among the dimensions of a vertex: the pixel that a point belongs to, the lens.
PIXEL, LENS_POINT = 7, 9

#: Light for one pixel. x, y: whole floats, pixels of the full film; value: what it adds to the mean
#: over all light paths; lit: mask.
Splat = namedtuple("Splat", "x y value lit")

#: Where paths have met surfaces. wl: local direction that they came from; beta: flux, W;
#: distance: of the last ray, metres; cosine: of wl with the geometric normal, not negative;
#: active: mask; rays: uniform, those of the packet so far.
LitVertex = namedtuple("LitVertex", "surface wl beta distance cosine active rays")

#: Where paths go on. d: unit direction; wo: the same, local; weight: factor of the flux; pdf: per
#: steradian, `reverse` that of the way back; cosine: of d with the geometric normal, not negative;
#: delta, straight: masks, by a lobe of Dirac, and through a surface that is not there.
Turn = namedtuple("Turn", "d wo weight pdf reverse cosine delta straight")


def write_arrive(program):
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


def write_meet(program):
    """``(scene, path) -> LitVertex``: where light paths meet the next surface."""
    absorbing = absorbs(program)

    @kernel
    def meet(scene, path):
        hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
        rays = path.rays + count_lanes(path.active)
        active = path.active & (hit.t < INFINITY)
        surface = make_surface(scene, hit, path.o, path.d, active)
        # The viewer's side of a path from the camera is the far one here.
        wl = to_local(surface, -path.d)
        beta = path.beta
        if absorbing:
            share = transmittance(scene, surface, wl, where(active, hit.t, 0.0))
            beta = where(active, beta * share, beta)
        cosine = absolute(dot(surface.ng, path.d))
        return LitVertex(surface, wl, beta, hit.t, cosine, active & (cosine > 0.0), rays)

    return meet


def write_turn(program):
    """``(scene, sampler, dimension, v, active) -> Turn``: where light paths go on from `v`.

    `v` is their `LitVertex`, `dimension` the first of the numbers that they turn by.
    """
    refracting = refracts(program)

    @kernel
    def turn(scene, sampler, dimension, v, active):
        surface, wl = v.surface, v.wl
        wo, weight, pdf, flags = sample_bsdf(
            scene, surface, wl, get_1d(sampler, dimension + BSDF_CHOICE),
            get_2d(sampler, dimension + BSDF_DIRECTION), active,
        )  # fmt: skip
        d = to_world(surface, wo)
        cosine = absolute(dot(surface.ng, d))
        corrected = cosine * (1.0 / where(v.active, v.cosine, 1.0))
        delta = (flags & DELTA) != 0
        smooth = active & ~delta & (pdf > 0.0)
        reverse = lanes(0.0)
        if any_lane(smooth):
            f_cos, reverse = evaluate_bsdf(scene, surface, wo, wl, smooth)
            weight = where(smooth, f_cos * (corrected / where(smooth, pdf, 1.0)), weight)
        # A lobe of Dirac has the weight of radiance, from which two cosines have cancelled.
        turned = corrected * absolute(wl.z) / where(absolute(wo.z) > 0.0, absolute(wo.z), 1.0)
        if refracting:
            inside, outside = squared_index(scene, surface, wo), squared_index(scene, surface, wl)
            turned = turned * inside / outside
        straight = (flags & NULL) != 0
        weight = where(delta & ~straight, weight * turned, weight)
        return Turn(d, wo, weight, pdf, reverse, cosine, delta, straight)

    return turn
