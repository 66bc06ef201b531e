r"""Light on level ground, as the luminance of its irradiance: known as a whole, and by samples.

.. math:: E(x) = \int_\Omega Y\big(L_e(\omega)\big) \cos\theta \, d\omega
    = E_\infty + \sum_k E_k(x)

Light from infinity is the same everywhere, so that its part is one number. Those parts of lights at
points have a formula, their own. Lights on shapes would be integrals for each x: there is no ground
beneath them.

Two techniques find light from infinity, with the weights of the balance heuristic: light sampling,
and directions in proportion to the cosine, which also find what MIS compensation leaves to them.

Source: Veach and Guibas, Optimally combining sampling techniques, SIGGRAPH 1995.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.core.constants import INV_PI
from alight.core.vec import Vec3, gather_vec3, luminance
from alight.core.warps import cosine_hemisphere_pdf, square_to_cosine_hemisphere
from alight.lights.misses import environment_pdf, environment_radiance, environments_of
from alight.lights.sampling import (
    has_delta_lights,
    no_sample,
    sample_chosen,
    sample_light,
)
from alight.lights.tables import INFO, STRIDE
from lanewise.jit import instantiate, kernel, specialised
from lanewise.simd import lanes, lanes_u32, maximum, where

#: The layer of shadows on it.
SHADOW = "shadow"

#: Level ground with +y up. height: m; sky: luminance of the irradiance of all light from infinity,
#: W/m^2, as float32.
Ground = namedtuple("Ground", "height sky")

#: Points by which the light from infinity is measured, and the steps of an additive sequence of low
#: discrepancy in five dimensions: powers of 1/x with x^6 = x + 1 (Roberts 2018).
POINTS = 1 << 17
_ROOT = 1.134724138401519
_STEPS = 1.0 / _ROOT ** np.arange(1.0, 6.0)


@kernel
def light_to_ground(scene, p, u, u2, active):
    """Light sampling: a `LightSample` for points p of the ground, and what it adds to E of the sky.

    That is 0 where the choice of a light has fallen on a lamp.
    """
    s = sample_light(scene, p, Vec3(lanes(0.0), lanes(1.0), lanes(0.0)), u, u2, active)
    cosine = maximum(s.wi.y, 0.0)
    density = s.pdf + INV_PI * cosine
    added = luminance(s.radiance) * cosine / where(density > 0.0, density, 1.0)
    return s, where(s.delta, 0.0, added)


@kernel
def sky_above_ground(scene, p, u2):
    """By the cosine: a unit direction, and what it adds to E of the sky."""
    w = square_to_cosine_hemisphere(u2)
    d = Vec3(w.x, w.z, w.y)
    density = cosine_hemisphere_pdf(w) + environment_pdf(scene, p, d)
    added = luminance(environment_radiance(scene, d)) * w.z
    return d, added / where(density > 0.0, density, 1.0)


@specialised
def lamps_above_ground(program):
    """``lamps_above_ground(scene, p, u)``: a lamp by what it brings to p, and the sum of all E_k.

    A `LightSample` of lamp k has the probability E_k(p) over the sum, so that the sum is the
    estimate. u chooses, uniform in [0, 1), and is used again for the next choice: one lamp stays
    or gives way to the next (reservoir sampling, Chao 1982).
    """
    around = len(environments_of(program))
    if not has_delta_lights(program):

        @kernel
        def no_lamps(scene, p, u):
            return no_sample(scene, lanes_u32(0), p, u, (u, u)), lanes(0.0)

        return no_lamps

    @kernel
    def choose_lamp(scene, p, u):
        middle, total = lanes(0.5), lanes(0.0)
        chosen = no_sample(scene, lanes_u32(0), p, u, (u, u))
        for row in range(scene.lights.info.size // INFO - around):
            index = lanes_u32(0) + row
            s = sample_chosen(scene, index, p, middle, (middle, middle))
            radiance = s.radiance * gather_vec3(scene.lights.data, index * STRIDE)
            lit = (s.pdf > 0.0) & (s.wi.y > 0.0) & (s.cosine > 0.0)
            added = where(lit, luminance(radiance) * s.wi.y / where(lit, s.pdf, 1.0), 0.0)
            total += added
            share = added / where(total > 0.0, total, 1.0)
            takes = u < share
            chosen = where(takes, s, chosen)
            u = where(takes, u, u - share) / where(takes, share, 1.0 - share)
        return chosen, total

    return choose_lamp


def measured_ground(program, tables, point: np.ndarray) -> Ground:
    """The ground at the height of a point, and what light from infinity brings it.

    By the techniques that kernels use, at `POINTS` places: for smooth maps right to some 1e-4.

    Parameters
    ----------
    program : Program
    tables : namedtuple
        Of the compiled scene.
    point : (3,) float64, metres
        For windows, through which light is sampled, it matters where it is.
    """
    if not environments_of(program):
        return Ground(np.float32(point[1]), np.float32(0.0))
    # In float64: whole multiples of a step lose none of the sequence's evenness.
    u = np.arange(1.0, POINTS + 1.0)[None, :] * _STEPS[:, None] % 1.0
    u = np.minimum(u.astype(np.float32), np.float32(1.0 - 2.0**-24))
    p = Vec3(*(np.full(POINTS, c, np.float32) for c in point))
    by_light = instantiate(light_to_ground, program, compiled=False)
    by_cosine = instantiate(sky_above_ground, program, compiled=False)
    with np.errstate(all="ignore"):
        _, from_lights = by_light(tables, p, u[0], (u[1], u[2]), np.ones(POINTS, bool))
        _, from_sky = by_cosine(tables, p, (u[3], u[4]))
    sky = from_lights.mean(dtype=np.float64) + from_sky.mean(dtype=np.float64)
    return Ground(np.float32(point[1]), np.float32(sky))
