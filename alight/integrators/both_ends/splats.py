"""How the camera sees vertices of light paths: splats, and the numbers that choose their pixels."""

from __future__ import annotations

from collections import namedtuple

from alight.accel import is_occluded
from alight.bsdfs.switch import has_null
from alight.core.vec import absolute_vec3, max_component
from alight.filters.splatting import choose_pixel
from alight.integrators.interiors.enclosing import dimmed, left_along
from alight.integrators.shadow_rays import transmittance_through_holes
from alight.integrators.walk import count_lanes, vertex_dimension
from alight.samplers.sampling import get_2d
from lanewise.jit import kernel
from lanewise.simd import absolute, any_lane, lanes_u32, lanes_vec3, where

#: Further places among the dimensions of a vertex: the pixel that a point belongs to, the lens.
PIXEL, LENS_POINT = 7, 9

#: Light for one pixel. x, y: whole floats, pixels of the full film; value: what it adds to the mean
#: over all light paths; lit: mask.
Splat = namedtuple("Splat", "x y value lit")


def write_show(program):
    """Connections: ``(scene, settings, at, end, lit, value) -> (splat, rays)``.

    at: (sampler, depth, c, o, bodies); the ray to the camera starts at o, in `Bodies`; `value` is
    what it carries but for what is in its way.
    """
    holes = has_null(program)

    @kernel
    def show(scene, settings, at, end, lit, value):
        sampler, depth, c, o, bodies = at
        lit = lit & c.visible & ~(max_component(absolute_vec3(value)) <= 0.0)
        u2 = get_2d(sampler, vertex_dimension(depth + 1) + PIXEL)
        x, across = choose_pixel(scene, where(lit, c.x, 0.0), u2[0])
        y, down = choose_pixel(scene, where(lit, c.y, 0.0), u2[1])
        lit = lit & (absolute(across * down) > 0.0)
        rays = 0 if holes else count_lanes(lit)
        value = value * (across * down)
        if any_lane(lit):
            if holes:
                most = lanes_u32(0) + settings.max_depth - depth - 1
                ray = o, c.w, end, bodies
                share, left, _, rays = transmittance_through_holes(scene, ray, most, lit, rays)
                lit = lit & (share > 0.0)
                value = dimmed(value * share, left)
            else:
                lit = lit & ~is_occluded(scene, o, c.w, end, lit)
                value = dimmed(value, left_along(bodies, end, lit))
        return Splat(x, y, where(lit, value, lanes_vec3(0.0)), lit), rays

    return show


@kernel
def lens_numbers(sampler, depth):
    """The pair that chooses the point of the lens at the vertex after `depth` edges."""
    return get_2d(sampler, vertex_dimension(depth + 1) + LENS_POINT)
