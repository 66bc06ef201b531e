r"""Shadow catcher: the light that objects keep from the level ground on which they stand.

The ground is not there for the picture: it sends no light, and hides nothing. Where a sample of the
picture leaves the scene and its ray meets the ground at x, the layer ``shadow`` counts

.. math:: s(x) = 1 - \frac{\int Y(L_e)\, V \cos\theta \, d\omega}{\int Y(L_e) \cos\theta\, d\omega}
    = \frac{1}{E(x)} \int Y(L_e)\, (1 - V) \cos\theta \, d\omega ,

the share of the direct light that does not arrive, Y being the luminance. E is known
(`alight.lights.ground`), and the integral is estimated by samples, so that the layer is unbiased:
two rays for the light from infinity, and one to a lamp that is drawn by what it brings. Glass keeps
all light away, as it does from shadow rays in the picture; holes of a mask let it through.

Over a background b of the ground's own colour a pixel shows :math:`c + (1 - a - s)\, b` with the
coverage a and the premultiplied colour c: alpha is a + s, and a shadow is black.

Source: the definition is that of Blender Cycles before 3.0, "Shadow Catcher"; Debevec, Rendering
synthetic objects into real scenes, SIGGRAPH 1998, for the difference that objects make to a ground.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel import is_occluded
from alight.bsdfs.switch import has_null
from alight.core.constants import INFINITY, gamma
from alight.core.vec import Vec3
from alight.integrators.aov import add_layer
from alight.integrators.coverage import write_cover
from alight.integrators.interiors.enclosing import empty_space
from alight.integrators.moments import at_times_of
from alight.integrators.shadow_rays import transmittance_through_holes
from alight.integrators.walk import (
    BSDF_DIRECTION,
    LIGHT_CHOICE,
    LIGHT_POINT,
    UNLIMITED,
    vertex_dimension,
)
from alight.lights.ground import lamps_above_ground, light_to_ground, sky_above_ground
from alight.lights.misses import environments_of
from alight.lights.sampling import has_delta_lights
from alight.samplers.sampling import get_1d, get_2d
from alight.shapes.hit import shadow_length, spawn_origin
from lanewise.jit import kernel, specialised
from lanewise.simd import absolute, any_lane, as_int, is_finite, lanes, lanes_u32, where

#: Channels of the layer: A, the mean of s; square, that of (a + s)^2 over the samples.
CHANNELS = ("A", "square")

#: A `LayerFilm` of the one layer, and the `Ground`.
ShadowFilm = namedtuple("ShadowFilm", "tile wanted sums ground")

_GAMMA_8 = gamma(8)


@kernel
def add_covered(film, path, hit, mask):
    """A sample that has met a surface: no shadow, but a part of alpha."""
    weight = path.beta.x
    add_layer(film, 0, path, Vec3(lanes(0.0), weight * weight, lanes(0.0)), mask)


@specialised
def catch_shadows(program):
    """``catch_shadows(scene, film, path)``: add the shadows of a packet of camera rays.

    film: `ShadowFilm`.
    """
    cover = write_cover(program, add_covered, _write_catch(program))

    @kernel
    def catch(scene, film, path):
        cover(at_times_of(scene, path.sampler), film, path)

    return catch


def _write_catch(program):
    """``(scene, film, path, mask)``: add the shadows where rays leave the scene."""
    by_lamps, by_sky = has_delta_lights(program), bool(environments_of(program))
    kept_away = _write_kept_away(program)

    @kernel
    def catch(scene, film, path, mask):
        height = film.ground.height
        down = mask & (path.d.y < 0.0) & (path.o.y > height)
        if any_lane(down):
            t = (height - path.o.y) / where(down, path.d.y, -1.0)
            # The height is exact, and the error of the others moves the point within the ground.
            p = Vec3(path.o.x + t * path.d.x, lanes(height), path.o.z + t * path.d.z)
            error = _GAMMA_8 * (absolute(p.x) + absolute(p.y) + absolute(p.z))
            down = down & is_finite(error)
            dimension = vertex_dimension(path.depth + 1)
            u = get_1d(path.sampler, dimension + LIGHT_CHOICE)
            s, lamps = lamps_above_ground(scene, p, u)
            whole, kept = film.ground.sky + lamps, lanes(0.0)
            if by_lamps:
                end = shadow_length(s.distance, s.cosine, s.error, error)
                kept = lamps * kept_away(scene, p, error, s.wi, end, down & (lamps > 0.0))
            if by_sky:
                u2 = get_2d(path.sampler, dimension + LIGHT_POINT)
                s, value = light_to_ground(scene, p, u, u2, down)
                far = lanes(INFINITY)
                kept += value * kept_away(scene, p, error, s.wi, far, down & (value > 0.0))
                u2 = get_2d(path.sampler, dimension + BSDF_DIRECTION)
                d, value = sky_above_ground(scene, p, u2)
                kept += value * kept_away(scene, p, error, d, far, down & (value > 0.0))
            shadow = path.beta.x * kept / where(whole > 0.0, whole, 1.0)
            value = Vec3(shadow, shadow * shadow, lanes(0.0))
            add_layer(film, 0, path, value, down & (whole > 0.0))

    return catch


def _write_kept_away(program):
    """``(scene, p, error, wi, end, mask)``: share of the light that does not come through."""
    holes = has_null(program)

    @kernel
    def kept_away(scene, p, error, wi, end, mask):
        o = spawn_origin(p, error, Vec3(lanes(0.0), lanes(1.0), lanes(0.0)), wi)
        if holes:
            most, rays = lanes_u32(0) + UNLIMITED, as_int(0)
            ray = o, wi, end, empty_space()
            share, _, _, _ = transmittance_through_holes(scene, ray, most, mask, rays)
            return where(mask, 1.0 - share, 0.0)
        return where(is_occluded(scene, o, wi, end, mask) & mask, 1.0, 0.0)

    return kept_away
