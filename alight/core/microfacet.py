r"""Microfacets: distributions of their normals, and of the visible ones.

A distribution D(wm) has roughness alpha_x along x and alpha_y along y, both > 0, and obeys

.. math:: \int D(\omega_m) \cos\theta_m \, d\omega_m = 1.

By Smith's assumption a facet is hidden or not whatever its normal. All that masking needs is then
the area of the facets seen from w, per area of the surface and projected along w:

.. math:: \sigma(\omega) = \int \max(0, \omega \cdot \omega_m) D(\omega_m) \, d\omega_m

before masking, of which G1 = cos theta / sigma <= 1 is left by it. The normals seen from w have the
density D(wm) max(0, w . wm) / sigma(w). (In terms of Smith's Lambda, sigma = cos theta
(1 + Lambda); unlike Lambda it stays finite at grazing angles.) Masking in two directions is taken
to be independent, G = G1(wo) G1(wi), as Walter et al. and Mitsuba do.

Sources: Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces; Heitz 2014,
Understanding the Masking-Shadowing Function (JCGT 3:2), equations 72, 80, 83 to 87; Dupuy and
Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps; Heitz and d'Eon 2014, Importance
Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_PI
from alight.core.maths import exp, log, sincos_2pi
from alight.core.vec import Vec3, normalize
from lanewise.jit import kernel, specialised
from lanewise.simd import absolute, any_lane, maximum, minimum, sqrt, where

#: Roughness along x and y, and whether the distribution is Beckmann's (1) or GGX (0).
Facets = namedtuple("Facets", "alpha_x alpha_y beckmann")

#: What programs call the two distributions: only those in use are compiled.
GGX, BECKMANN = "facets:ggx", "facets:beckmann"
FEATURES = {"ggx": GGX, "beckmann": BECKMANN}

_INV_SQRT_PI = 0.564189583547756287
_HALF_SQRT_PI = 0.886226925452758014


# ---------------------------------------------------------------- whichever distribution


def _either(program, ggx, beckmann):
    """The kernel of the one distribution that a program uses, or a blend of both."""
    if BECKMANN not in program.bsdfs:
        return ggx
    if GGX not in program.bsdfs:
        return beckmann

    @kernel
    def either(facets, w, *u2):
        value, other = ggx(facets, w, *u2), facets.beckmann > 0.0
        if any_lane(other):
            value = where(other, beckmann(facets, w, *u2), value)
        return value

    return either


@specialised
def facet_density(program):
    """``(facets, wm) -> D`` per steradian; 0 below the surface."""
    return _either(program, ggx_density, beckmann_density)


@specialised
def visible_area(program):
    """``(facets, w) -> sigma``: >= |cos theta|, and > 0 at grazing angles too."""
    return _either(program, ggx_visible_area, beckmann_visible_area)


@specialised
def sample_visible_facet(program):
    """``(facets, wo, u2) -> wm``: normal of a facet that is seen from wo, where wo.z > 0.

    Its density is D(wm) (wo . wm) / sigma(wo).
    """
    return _either(program, sample_ggx_visible, sample_beckmann_visible)


# ---------------------------------------------------------------- GGX


@kernel
def _stretched_tan2(facets, w):
    """(x / alpha_x)^2 + (y / alpha_y)^2."""
    x, y = w.x / facets.alpha_x, w.y / facets.alpha_y
    return x * x + y * y


@kernel
def _stretched(facets, wo):
    """The direction from which rough facets look as those of roughness 1 do from wo.

    Below the surface nothing is seen; wo is then mirrored, so that results stay tame.
    """
    return normalize(Vec3(wo.x * facets.alpha_x, wo.y * facets.alpha_y, absolute(wo.z)))


@kernel
def ggx_density(facets, wm):
    """D of GGX (Trowbridge and Reitz), per steradian; 0 below the surface."""
    s = _stretched_tan2(facets, wm) + wm.z * wm.z
    d = INV_PI / (facets.alpha_x * facets.alpha_y * s * s)
    return where(wm.z > 0.0, d, 0.0)


@kernel
def ggx_visible_area(facets, w):
    """Area of the facets seen from w, for GGX."""
    x, y = w.x * facets.alpha_x, w.y * facets.alpha_y
    # cos (1 + Lambda) with Lambda = (sqrt(1 + alpha^2 tan^2) - 1) / 2.
    return 0.5 * (absolute(w.z) + sqrt(x * x + y * y + w.z * w.z))


@kernel
def sample_ggx_visible(facets, wo, u2):
    """Normal of a facet that is visible from wo (wo.z > 0), for GGX."""
    # Stretched by the roughness, the facets are a hemisphere; seen from wo, the normals of its
    # visible part are halfway between wo and a uniform point of the sphere's cap above -wo.z.
    std = _stretched(facets, wo)
    s, c = sincos_2pi(u2[1])
    # The point lies `down` below the top of the sphere, z above the foot of the cap; in these
    # terms nothing cancels for the normals of steep facets.
    down, z = u2[0] * (1.0 + std.z), (1.0 - u2[0]) * (1.0 + std.z)
    r = sqrt(maximum(0.0, down * (1.0 - std.z + z)))
    h = Vec3(r * c + std.x, r * s + std.y, z)
    return normalize(Vec3(h.x * facets.alpha_x, h.y * facets.alpha_y, maximum(h.z, 1e-6)))


# ---------------------------------------------------------------- Beckmann


@kernel
def beckmann_density(facets, wm):
    """D of Beckmann (Gaussian slopes), per steradian; 0 below the surface."""
    z2 = wm.z * wm.z
    above = z2 > 1e-12
    z2 = where(above, z2, 1.0)
    e = exp(-_stretched_tan2(facets, wm) / z2)
    d = INV_PI * e / (facets.alpha_x * facets.alpha_y * z2 * z2)
    return where(above & (wm.z > 0.0), d, 0.0)


@kernel
def beckmann_visible_area(facets, w):
    """Area of the facets seen from w, for Beckmann."""
    x, y = w.x * facets.alpha_x, w.y * facets.alpha_y
    return _beckmann_area_stretched(absolute(w.z), sqrt(x * x + y * y))


@kernel
def _beckmann_area_stretched(z, m):
    """sigma for w . n = z >= 0 and alpha sin theta = m >= 0, not both 0.

    With a = z / m, Lambda = exp(-a^2) / (2 a sqrt(pi)) - erfc(a) / 2. Here a Lambda exp(a^2) is
    s^2 times a polynomial in s = 1 / (1 + a), fitted as those of `alight.core.maths`: relative
    error of Lambda below 6e-6 for a < 11, and beyond that Lambda < 1e-54.
    """
    a = z / maximum(m, 1e-18)
    s = m / (m + z)
    p = ((-0.6572006 * s + 3.2532141) * s - 6.6135106) * s + 6.8165803
    p = ((p * s - 3.2723088) * s + 0.16377209) * s + 0.1661868
    p = (p * s + 0.28435245) * s + 0.14100753
    return z + m * (s * s * p * exp(-a * a))


@kernel
def sample_beckmann_visible(facets, wo, u2):
    """Normal of a facet that is visible from wo (wo.z > 0), for Beckmann.

    Slopes are made Gaussian with variance 1/2 by stretching, as for GGX. Along the direction of
    wo they have the density (z - m x) exp(-x^2) / (sqrt(pi) sigma) for x < z / m, at right angles
    to it they are not affected. The first is inverted numerically, the second is a quantile.
    """
    std = _stretched(facets, wo)
    squared = std.x * std.x + std.y * std.y
    m = sqrt(squared)
    slanted = squared > 1e-14
    # Direction of wo in the plane; any will do at the pole.
    inverse = 1.0 / where(slanted, m, 1.0)
    c, s = where(slanted, std.x * inverse, 1.0), where(slanted, std.y * inverse, 0.0)
    x = _visible_slope(std.z, m, u2[0])
    y = gaussian_quantile(_within_quantiles(2.0 * u2[1]))
    # Slopes fall where normals rise.
    sx, sy = facets.alpha_x * (c * x - s * y), facets.alpha_y * (s * x + c * y)
    return normalize(Vec3(-sx, -sy, 1.0))


@kernel
def _visible_slope(z, m, u):
    """The x at which the cumulative distribution of visible slopes is u; error of u below 1e-5.

    With q = 1 + erf(x) the distribution is (z q + m exp(-x^2) / sqrt(pi)) / (2 sigma), monotone
    and nearly linear in q (Jakob 2014, An Improved Visible Normal Sampling Routine for the
    Beckmann Distribution). Two steps of Halley's method.
    """
    target = 2.0 * u * _beckmann_area_stretched(z, m)
    # The largest q is 1 + erf(a) with a = z / m; erfc(a) exp(a^2) is a polynomial within 1.3e-4.
    a = z / maximum(m, 1e-18)
    s = 1.0 / (1.0 + 0.55 * a)
    p = ((0.81860143 - 0.19142231 * s) * s - 0.014846676) * s + 0.39634091
    largest = 2.0 - (p * s - 0.0085507752) * exp(-a * a)
    # The solution is its part u from above, and at grazing angles erfc(y) with exp(-y^2) = u.
    # Between them a power of erfc(y) exp(y^2), whose logarithm is a cubic within 0.0014, serves
    # as a start. It must not lie beyond the solution, where the distribution turns down.
    y = sqrt(-log(maximum(u, 1e-8)))
    s = 1.0 / (1.0 + 0.3 * y)
    e = ((0.9734962 * s - 2.0454309) * s + 5.0039601) * s - 3.9320822
    q = 0.9998 * u * largest * exp(m / (m + z) * e)
    q = minimum(_halley_step(z, m, target, q), largest)
    q = minimum(_halley_step(z, m, target, q), largest)
    return gaussian_quantile(_within_quantiles(q))


@kernel
def _halley_step(z, m, target, q):
    q = _within_quantiles(q)
    x = gaussian_quantile(q)
    bell = exp(-x * x)
    # f' = z - m x vanishes only where the facets turn away; f'' = -m dx/dq.
    slope = maximum(z - m * x, 1e-5)
    step = (z * q + _INV_SQRT_PI * m * bell - target) / slope
    curved = 1.0 + 0.5 * step * (_HALF_SQRT_PI * m) / (bell * slope)
    return q - step / maximum(curved, 0.1)


@kernel
def _within_quantiles(q):
    """q at least as far from 0 and 2 as `gaussian_quantile` is good for."""
    return maximum(1e-8, minimum(q, 1.9999998))


@kernel
def gaussian_quantile(q):
    """The x with erf(x) = q - 1, for q in [1e-8, 2 - 2e-7]; relative error below 1e-6.

    Two polynomials in place of the inverse error function over its argument, in terms of
    w = -log(1 - (q - 1)^2) (Giles 2010, Approximating the erfinv function; own fit).
    """
    w = maximum(0.0, -log(q * (2.0 - q)))
    c = w - 2.5
    p = ((3.1813912e-7 * c - 3.1803415e-6) * c - 4.1130265e-6) * c + 0.00021729607
    p = ((p * c - 0.0012545985) * c - 0.0041761957) * c + 0.24664141
    p = p * c + 1.5014092
    t = sqrt(w) - 3.0
    r = ((0.00092413777 * t - 0.0035011976) * t + 0.0060163871) * t - 0.0076951995
    r = ((r * t + 0.0093798004) * t + 1.0016805) * t + 2.832979
    return (q - 1.0) * where(w < 5.0, p, r)
