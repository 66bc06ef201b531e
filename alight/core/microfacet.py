r"""Surfaces made of tiny mirrors: distributions of their normals, and which of them are seen.

A distribution D(wm) has roughness alpha_x along x and alpha_y along y, both > 0, and obeys

.. math:: \int D(\omega_m) \cos\theta_m \, d\omega_m = 1.

By Smith's assumption the part of them that is seen from w is G1 = 1 / (1 + Lambda(w)), so that

.. math:: \int G_1(\omega) \max(0, \omega \cdot \omega_m) D(\omega_m) \, d\omega_m = \cos\theta.

Sources: Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces; Heitz 2014,
Understanding the Masking-Shadowing Function (JCGT 3:2), equations 72, 80, 83 to 87; Dupuy and
Benyoub 2023, Sampling Visible GGX Normals with Spherical Caps.
"""

from __future__ import annotations

from alight.core.constants import INV_PI
from alight.core.jit import kernel
from alight.core.maths import exp, log1p, sincos_2pi
from alight.core.simd import maximum, sqrt, where
from alight.core.vec import Vec3, dot, normalize


@kernel
def _stretched_tan2(w, alpha_x, alpha_y):
    """(x / alpha_x)^2 + (y / alpha_y)^2."""
    x, y = w.x / alpha_x, w.y / alpha_y
    return x * x + y * y


@kernel
def ggx_distribution(wm, alpha_x, alpha_y):
    """D of GGX (Trowbridge and Reitz), per steradian; 0 below the surface."""
    s = _stretched_tan2(wm, alpha_x, alpha_y) + wm.z * wm.z
    d = INV_PI / (alpha_x * alpha_y * s * s)
    return where(wm.z > 0.0, d, 0.0)


@kernel
def beckmann_distribution(wm, alpha_x, alpha_y):
    """D of Beckmann (Gaussian slopes), per steradian; 0 below the surface."""
    z2 = wm.z * wm.z
    above = z2 > 1e-12
    z2 = where(above, z2, 1.0)
    e = exp(-_stretched_tan2(wm, alpha_x, alpha_y) / z2)
    d = INV_PI * e / (alpha_x * alpha_y * z2 * z2)
    return where(above & (wm.z > 0.0), d, 0.0)


@kernel
def _projected_roughness2(w, alpha_x, alpha_y):
    """(alpha tan theta)^2 in the plane of w, and infinity at grazing angles."""
    x, y = w.x * alpha_x, w.y * alpha_y
    return (x * x + y * y) / maximum(w.z * w.z, 1e-30)


@kernel
def ggx_lambda(w, alpha_x, alpha_y):
    """Hidden over visible area of the facets seen from w, for GGX."""
    t = _projected_roughness2(w, alpha_x, alpha_y)
    # (sqrt(1 + t) - 1) / 2 without its cancellation.
    return 0.5 * t / (1.0 + sqrt(1.0 + t))


@kernel
def beckmann_lambda(w, alpha_x, alpha_y):
    """Hidden over visible area of the facets seen from w, for Beckmann.

    With a = 1 / (alpha tan theta), Lambda = exp(-a^2) / (2 a sqrt(pi)) - erfc(a) / 2. Here
    a Lambda exp(a^2) is a polynomial in s = 1 / (1 + a), fitted as those of `alight.core.maths`:
    relative error below 6e-6 for a < 11, and beyond that Lambda < 1e-54.
    """
    a = 1.0 / sqrt(maximum(_projected_roughness2(w, alpha_x, alpha_y), 1e-12))
    s = 1.0 / (1.0 + a)
    p = ((-0.6572006 * s + 3.2532141) * s - 6.6135106) * s + 6.8165803
    p = ((p * s - 3.2723088) * s + 0.16377209) * s + 0.1661868
    p = (p * s + 0.28435245) * s + 0.14100753
    return s * s * p * exp(-a * a) / a


@kernel
def smith_g1(lambda_w):
    """Visible part of the facets that face w."""
    return 1.0 / (1.0 + lambda_w)


@kernel
def smith_g2(lambda_o, lambda_i):
    """Part of the facets seen from both directions on one side, heights correlated."""
    return 1.0 / (1.0 + lambda_o + lambda_i)


@kernel
def sample_ggx_visible(wo, alpha_x, alpha_y, u2):
    """Normal of a facet that is visible from wo (wo.z > 0), by density `visible_normal_pdf`."""
    # Stretched by the roughness, the facets are a hemisphere; seen from wo, the normals of its
    # visible part are halfway between wo and a uniform point of the sphere's cap above -wo.z.
    std = normalize(Vec3(wo.x * alpha_x, wo.y * alpha_y, wo.z))
    s, c = sincos_2pi(u2[1])
    # 1 - z and 1 + z of the point of the cap.
    down = u2[0] * (1.0 + std.z)
    r = sqrt(maximum(0.0, down * (2.0 - down)))
    h = Vec3(r * c + std.x, r * s + std.y, 1.0 - down + std.z)
    return normalize(Vec3(h.x * alpha_x, h.y * alpha_y, maximum(h.z, 1e-6)))


@kernel
def visible_normal_pdf(wo, wm, distribution, lambda_o):
    """Density per steradian of normals wm in proportion to how large they are seen from wo."""
    seen = maximum(0.0, dot(wo, wm)) * distribution * smith_g1(lambda_o)
    return where(wo.z > 0.0, seen / where(wo.z > 0.0, wo.z, 1.0), 0.0)


@kernel
def sample_beckmann(alpha_x, alpha_y, u2):
    """Normal of any facet, seen or not, with density D cos theta_m."""
    # Slopes are Gaussian (Box and Muller).
    r = sqrt(-log1p(-u2[0]))
    s, c = sincos_2pi(u2[1])
    return normalize(Vec3(alpha_x * r * c, alpha_y * r * s, 1.0))
