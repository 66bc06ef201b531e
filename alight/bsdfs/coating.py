r"""Matte stuff under a clear coat: what `plastic` and `rough_plastic` share.

Light that enters the coat scatters at the base, is partly thrown back by the coat from inside, and
scatters again. With the internal reflectance R (for diffuse light) the sum over all rounds is

.. math:: \rho' = \rho\,(1 + \rho R + \rho^2 R^2 + \dots) = \frac{\rho}{1 - \rho R},

where each round colours the light anew. The linear version keeps the colour of one round:
rho / (1 - R).

For a rough coat the numbers over the cosine are integrals over its facets. With a direction w at
the cosine mu, facets m seen from w (density p), Fresnel's F and Smith's masking G1,

.. math::
    T(\mu) = \int p(m)\,(1 - F)\,G_1(w_t)\,dm, \qquad
    R = \frac{2}{64} \sum_{k=0}^{63} \mu_k \int p(m)\,F\,G_1(w_r)\,dm

with the refracted w_t, and w_r mirrored on the inner side. The sum over 64 equal steps is what
Mitsuba's ``roughplastic`` computes in place of the integral over mu, found by experiment; it is
1 to 2 % smaller. Tables of T have 64 equal steps too, and are interpolated linearly.

Source: PBR4 section 9.7 for the microfacets; Walter et al. 2007, Microfacet Models for Refraction
through Rough Surfaces; the plug-ins ``plastic`` and ``roughplastic`` of Mitsuba 3.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.constants import INV_PI
from alight.core.fresnel import fresnel_dielectric
from alight.core.jit import kernel, specialised
from alight.core.microfacet import Facets, beckmann_visible_area, ggx_visible_area
from alight.core.simd import (
    gather,
    lanes,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    where,
)
from alight.core.vec import Vec3, luminance

Array = NDArray[np.float64]

#: Cosines in a table of transmittances.
STEPS = 64
#: Numbers of a row: the transmittances and the internal reflectance.
ROW = STEPS + 1
#: Rows for textured roughness, at equal steps of its root.
ROWS = 33
#: What programs call it that a coat's roughness is textured.
TEXTURED_COAT = "coat:textured"


# ---------------------------------------------------------------- on the host


def diffuse_reflectance(eta: float) -> float:
    r"""Part of diffuse light that a smooth interface reflects: ∫ 2 mu F(mu) d mu; within 1e-6."""
    # Below the critical angle's cosine all of it. Above, in steps of the refracted ray's cosine,
    # in which F has no root: mu^2 = c^2 + (1 - c^2) t^2.
    critical = max(0.0, 1.0 - eta * eta)
    nodes, weights = np.polynomial.legendre.leggauss(64)
    t, dt = 0.5 * (nodes + 1.0), 0.5 * weights
    f, _ = fresnel_dielectric(np.sqrt(critical + (1.0 - critical) * t * t), eta)
    return float(critical + (1.0 - critical) * np.sum(dt * 2.0 * t * f))


class Seen(NamedTuple):
    """Facets seen from directions at given cosines, the plane of incidence being x-z.

    Attributes
    ----------
    weight : (n, k) float64
        Of each facet; sums to 1 for each direction.
    x, z : (n, k) float64
        The facet's normal.
    cosine : (n, k) float64
        Between normal and direction.
    """

    weight: Array
    x: Array
    z: Array
    cosine: Array


#: Points of the integrals over facets, and the generator of their lattice: Fibonacci numbers. No
#: two points share a coordinate, so that the kinks at total reflection are met at many places.
POINTS, GENERATOR = 4181, 2584


def _lattice(points: int = POINTS, generator: int = GENERATOR) -> tuple[Array, Array, Array]:
    """Points (u, phi) of the disk's square and their weights; u is dense near 1."""
    i = np.arange(points)
    rest = 1.0 - (i + 0.5) / points
    phi = 2.0 * np.pi * ((i * generator + 0.5) % points) / points
    # Facets near the horizon (u = 1) change with the root of 1 - u.
    return 1.0 - rest * rest, phi, 2.0 * rest / points


def ggx_facets(mu: Array, alpha: float, points: int = POINTS, generator: int = GENERATOR) -> Seen:
    """Facets of GGX by the map of `alight.core.microfacet.sample_ggx_visible`."""
    u, phi, weight = _lattice(points, generator)
    sine = np.sqrt(1.0 - mu * mu)
    length = np.hypot(sine * alpha, mu)
    x0, z0 = (sine * alpha / length)[:, None], (mu / length)[:, None]
    down = u * (1.0 + z0)
    r = np.sqrt(np.maximum(0.0, down * (2.0 - down)))
    x, y, z = alpha * (r * np.cos(phi) + x0), alpha * r * np.sin(phi), 1.0 - down + z0
    return _facets(weight + 0.0 * z, x, y, z, mu)


def beckmann_facets(mu: Array, alpha: float) -> Seen:
    """Facets of Beckmann: Gaussian slopes, weighed by how large they are seen."""
    u, phi, weight = _lattice()
    slope = alpha * np.sqrt(-np.log1p(-u))
    x, y = slope * np.cos(phi), slope * np.sin(phi)
    seen = np.maximum(0.0, mu[:, None] + np.sqrt(1.0 - mu * mu)[:, None] * x)
    return _facets(weight * seen, x + 0.0 * seen, y, np.ones_like(seen), mu)


def _facets(weight: Array, x: Array, y: Array, z: Array, mu: Array) -> Seen:
    """Normals of the lengths 1, and weights that sum to 1."""
    length = np.sqrt(x * x + y * y + z * z)
    x, z = x / length, z / length
    cosine = x * np.sqrt(1.0 - mu * mu)[:, None] + z * mu[:, None]
    weight = weight / weight.sum(1, keepdims=True)
    return Seen(weight, x, z, np.clip(cosine, 0.0, 1.0))


def _masking(distribution: str, cosine: Array, alpha: float) -> Array:
    """Smith's G1: the visible part of the facets; 0 below the horizon."""
    above = cosine > 0.0
    w = Vec3(np.sqrt(np.maximum(0.0, 1.0 - cosine * cosine)), 0.0, np.where(above, cosine, 1.0))
    areas = {"ggx": ggx_visible_area, "beckmann": beckmann_visible_area}
    area = areas[distribution](Facets(alpha, alpha, 0.0), w)
    return np.where(above, w.z / np.where(above, area, 1.0), 0.0)


@lru_cache(maxsize=256)
def coat_row(distribution: str, alpha: float, eta: float) -> NDArray[np.float32]:
    """Numbers of a rough coat.

    Returns
    -------
    (ROW,) float32
        T at `STEPS` cosines from 0 to 1, from outside; then R, from inside. Within 1e-4.
    """
    find_facets = ggx_facets if distribution == "ggx" else beckmann_facets
    mu = np.maximum(np.linspace(0.0, 1.0, STEPS), 1e-6)
    facets = find_facets(mu, alpha)
    c = facets.cosine
    cos_t = np.sqrt(np.maximum(0.0, 1.0 - (1.0 - c * c) / eta**2))
    refracted = mu[:, None] / eta - (c / eta - cos_t) * facets.z
    through = (1.0 - fresnel_dielectric(c, eta)[0]) * _masking(distribution, refracted, alpha)
    mirrored = 2.0 * c * facets.z - mu[:, None]
    inside, _ = fresnel_dielectric(c, 1.0 / eta)
    back = inside * _masking(distribution, np.minimum(mirrored, 1.0), alpha)
    transmittance = np.sum(facets.weight * through, axis=1)
    internal = 2.0 * np.mean(mu * np.sum(facets.weight * back, axis=1))
    return np.append(transmittance, internal).astype(np.float32)


@lru_cache(maxsize=32)
def coat_table(distribution: str, alpha: float | None, eta: float) -> NDArray[np.float32]:
    """Rows of a rough coat: one, or where its roughness is textured `ROWS`.

    Row i of many holds alpha = (i / (ROWS - 1))^2.
    """
    if alpha is not None:
        return coat_row(distribution, alpha, eta)
    roots = np.maximum(np.linspace(0.0, 1.0, ROWS), 0.01)
    return np.concatenate([coat_row(distribution, float(r * r), eta) for r in roots])


# ---------------------------------------------------------------- in kernels


@kernel
def base_reflectance(reflectance, internal, nonlinear):
    """Reflectance of the base with all rounds inside of the coat, as if seen from there."""
    colored = where(nonlinear > 0.0, reflectance, 1.0)
    return reflectance / (lanes_vec3(1.0) - colored * internal)


@kernel
def base_f_cos(reflectance, through, eta, cos_i):
    """f cos theta_i of the base: `through` is the product of both ways through the coat."""
    # Radiance that leaves the denser coat falls by 1 / eta^2.
    return reflectance * (through * (INV_PI * cos_i) / (eta * eta))


@kernel
def share_of_coat(reflected, specular, matte):
    """Probability of sampling the coat: its part of the reflected light, by luminance."""
    coat = reflected * luminance(specular)
    base = (1.0 - reflected) * luminance(matte)
    both = coat + base
    return where(both > 0.0, coat / where(both > 0.0, both, 1.0), 0.0)


#: Where a rough coat's numbers are: table, start of a row, distance to the next row, part of that.
Coat = namedtuple("Coat", "curves row step part")


@specialised
def load_coat(program):
    """``(scene, slot, alpha) -> Coat``: slots hold the start of a table and its last row."""
    return _textured_coat if TEXTURED_COAT in program.bsdfs else _constant_coat


@kernel
def _constant_coat(scene, slot, alpha):
    row = to_uint(gather(scene.materials.data, slot))
    return Coat(scene.materials.curves, row, lanes_u32(0), lanes(0.0))


@kernel
def _textured_coat(scene, slot, alpha):
    last = gather(scene.materials.data, slot + 1)
    x = sqrt(minimum(alpha, 1.0)) * last
    i = to_uint(minimum(x, maximum(last - 1.0, 0.0)))
    row = to_uint(gather(scene.materials.data, slot)) + i * ROW
    # A table of one row has no next one.
    step = where(last > 0.0, lanes_u32(ROW), 0)
    return Coat(scene.materials.curves, row, step, x - to_float(i))


@specialised
def _read(program):
    """``(coat, i) -> number i`` of the row, between two rows interpolated."""
    return _read_two if TEXTURED_COAT in program.bsdfs else _read_one


@kernel
def _read_one(coat, i):
    return gather(coat.curves, coat.row + i)


@kernel
def _read_two(coat, i):
    a = gather(coat.curves, coat.row + i)
    b = gather(coat.curves, coat.row + coat.step + i)
    return a + coat.part * (b - a)


@kernel
def coat_transmittance(coat, cosine):
    """T at a cosine."""
    x = minimum(maximum(cosine, 0.0), 1.0) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    a, b = _read(coat, i), _read(coat, i + 1)
    return a + (x - to_float(i)) * (b - a)


@kernel
def coat_internal(coat):
    """R of a rough coat."""
    return _read(coat, lanes_u32(STEPS))
