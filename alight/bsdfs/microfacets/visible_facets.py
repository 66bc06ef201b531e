r"""Integrals over the facets that are seen from a direction, for the tables of rough models.

With a direction w and the facets m seen from it (density p), Fresnel's F and Smith's masking G1,
one bounce reflects and transmits the parts

.. math::
    W = \int p(m)\, G_1(w_r)\,dm, \quad R = \int p(m)\, F\, G_1(w_r)\,dm, \quad
    T = \int p(m)\, (1 - F)\, G_1(w_t)\,dm, \quad V = \int p(m)\, [w_t]\, G_1(w_t)\,dm

with w_r mirrored and w_t refracted at m, and [w_t] = 1 where there is a refracted direction. The
integrals are sums over a lattice, once for each table.

Source: PBR4 section 9.7; Walter et al. 2007, Microfacet Models for Refraction through Rough
Surfaces; Heitz and d'Eon 2014 for p.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import Facets, beckmann_visible_area
from alight.core.vec import Vec3

Array = NDArray[np.float64]

#: Points of the integrals over facets, and the generator of their lattice: Fibonacci numbers. No
#: two points share a coordinate, so that the kinks at total internal reflection are met at many
#: places.
LATTICE = 4181, 2584


class Seen(NamedTuple):
    """Facets seen from directions, a row for each direction.

    Attributes
    ----------
    facets : Facets
        How rough they are.
    wo : Vec3 of (n, 1) float64
        The directions.
    weight : (n, k) float64
        Of each facet; sums to 1 for each direction.
    wm : Vec3 of (n, k) float64
        The facets' normals.
    cosine : (n, k) float64
        Between normal and direction.
    """

    facets: Facets
    wo: Vec3
    weight: Array
    wm: Vec3
    cosine: Array


class Bounced(NamedTuple):
    """W, R, T and V of each direction, (n,) float64."""

    white: Array
    reflected: Array
    refracted: Array
    passed: Array


def see_facets(
    facets: Facets, mu: Array, azimuth: float = 0.0, lattice: tuple[int, int] = LATTICE
) -> Seen:
    """The facets that are seen from directions.

    Parameters
    ----------
    facets : Facets
    mu : (n,) float64 in (0, 1]
        The directions' cosines.
    azimuth : float, default 0
        Their angle from the x axis.
    lattice : (int, int)
        Points and generator.
    """
    sine = np.sqrt(1.0 - mu * mu)[:, None]
    wo = Vec3(sine * np.cos(azimuth), sine * np.sin(azimuth), mu[:, None])
    weight, wm = (_beckmann if facets.beckmann > 0.0 else _ggx)(facets, wo, lattice)
    wm = wm / np.sqrt(wm.x * wm.x + wm.y * wm.y + wm.z * wm.z)
    cosine = np.clip(wm.x * wo.x + wm.y * wo.y + wm.z * wo.z, 0.0, 1.0)
    return Seen(facets, wo, weight / weight.sum(1, keepdims=True), wm, cosine)


def _lattice(points: int, generator: int) -> tuple[Array, Array, Array]:
    """Points (u, phi) of the disk's square and their weights; u is dense near 1."""
    i = np.arange(points)
    rest = 1.0 - (i + 0.5) / points
    phi = 2.0 * np.pi * ((i * generator + 0.5) % points) / points
    # Facets near the horizon (u = 1) change with the root of 1 - u.
    return 1.0 - rest * rest, phi, 2.0 * rest / points


def _ggx(facets: Facets, wo: Vec3, lattice: tuple[int, int]) -> tuple[Array, Vec3]:
    """Weights and normals of GGX by the map of `alight.core.microfacet.sample_ggx_visible`."""
    u, phi, weight = _lattice(*lattice)
    std = Vec3(wo.x * facets.alpha_x, wo.y * facets.alpha_y, wo.z)
    std = std / np.sqrt(std.x * std.x + std.y * std.y + std.z * std.z)
    down = u * (1.0 + std.z)
    r = np.sqrt(np.maximum(0.0, down * (2.0 - down)))
    x, y = r * np.cos(phi) + std.x, r * np.sin(phi) + std.y
    wm = Vec3(facets.alpha_x * x, facets.alpha_y * y, 1.0 - down + std.z)
    return weight + 0.0 * wm.z, wm


def _beckmann(facets: Facets, wo: Vec3, lattice: tuple[int, int]) -> tuple[Array, Vec3]:
    """Weights and normals of Beckmann: Gaussian slopes, weighed by how large they are seen."""
    u, phi, weight = _lattice(*lattice)
    slope = np.sqrt(-np.log1p(-u))
    x, y = facets.alpha_x * slope * np.cos(phi), facets.alpha_y * slope * np.sin(phi)
    seen = np.maximum(0.0, wo.z + wo.x * x + wo.y * y)
    return weight * seen, Vec3(x + 0.0 * seen, y, np.ones_like(seen))


def _masking(facets: Facets, w: Vec3) -> Array:
    """Smith's G1: the visible part of the facets; 0 below the horizon."""
    above = w.z > 0.0
    z = np.where(above, w.z, 1.0)
    if facets.beckmann > 0.0:
        return np.where(above, z / beckmann_visible_area(facets, Vec3(w.x, w.y, z)), 0.0)
    # Of GGX in float64, which the kernel's arithmetic is not.
    x, y = facets.alpha_x * w.x / z, facets.alpha_y * w.y / z
    return np.where(above, 2.0 / (1.0 + np.sqrt(1.0 + x * x + y * y)), 0.0)


def bounce(seen: Seen, eta: float, refracts: bool = True) -> Bounced:
    """What one bounce does to the light.

    Parameters
    ----------
    seen : Seen
    eta : float
        Index beyond the surface over that before it.
    refracts : bool, default True
        Whether T and V are needed; else they are 0.
    """
    facets, wo, weight, wm, c = seen
    fresnel, cos_t = fresnel_dielectric(c, eta)
    back = weight * _masking(facets, wm * (2.0 * c) - wo)
    white, reflected = back.sum(1), (back * fresnel).sum(1)
    if not refracts:
        return Bounced(white, reflected, 0.0 * white, 0.0 * white)
    # The refracted direction, turned over to the side of wo.
    below = wo / eta - wm * (c / eta - cos_t)
    through = weight * _masking(facets, below) * (cos_t > 0.0)
    return Bounced(white, reflected, (through * (1.0 - fresnel)).sum(1), through.sum(1))


def entering(seen: Seen, eta: float) -> Array:
    """The light that each facet lets in, of what would leave if it were white, (n, k)."""
    back = seen.weight * _masking(seen.facets, seen.wm * (2.0 * seen.cosine) - seen.wo)
    return back * (1.0 - fresnel_dielectric(seen.cosine, eta)[0])
