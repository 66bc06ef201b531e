"""Reflection and refraction at smooth interfaces.

`eta` is the index of refraction on the transmitted side over the one on the incident side, for a
conductor the complex index eta + i k against the medium outside. All reflectances are for
unpolarised light.

Source: PBR4 section 9.3.3 to 9.3.6 (equations 9.3 to 9.8); Schlick 1994, An Inexpensive BRDF Model.
"""

from __future__ import annotations

from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, maximum, minimum, sqrt, where


@kernel
def cos_transmitted(cos_i, eta):
    """Cosine of the refracted ray by Snell's law, >= 0; 0 at total internal reflection."""
    # 1 - sin^2 / eta^2, put so that equal media give back cos_i exactly.
    square = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i
    return sqrt(maximum(0.0, square)) / eta


@kernel
def fresnel_dielectric(cos_i, eta):
    """(F, cos_t): reflected part of the light, and the cosine of the refracted ray.

    `cos_i` in [0, 1]. At total internal reflection F = 1 and cos_t = 0.
    """
    cos_t = cos_transmitted(cos_i, eta)
    # Grazing light (both cosines zero) is reflected entirely.
    s_sum, p_sum = cos_i + eta * cos_t, eta * cos_i + cos_t
    s = where(s_sum > 0.0, (cos_i - eta * cos_t) / where(s_sum > 0.0, s_sum, 1.0), 1.0)
    p = where(p_sum > 0.0, (eta * cos_i - cos_t) / where(p_sum > 0.0, p_sum, 1.0), 1.0)
    return minimum(0.5 * (s * s + p * p), 1.0), cos_t


@kernel
def fresnel_conductor(cos_i, eta, k):
    """Reflected part of the light, one channel each of the colours eta and k."""
    return Vec3(
        _conductor_channel(cos_i, eta.x, k.x),
        _conductor_channel(cos_i, eta.y, k.y),
        _conductor_channel(cos_i, eta.z, k.z),
    )


@kernel
def _conductor_channel(cos_i, eta, k):
    """Fresnel's equations with the complex square root a + i b = sqrt(eta_c^2 - sin^2)."""
    cos2 = cos_i * cos_i
    sin2 = maximum(0.0, 1.0 - cos2)
    real = eta * eta - k * k - sin2
    modulus = sqrt(real * real + 4.0 * eta * eta * k * k)
    # Of the two forms of a, the one in which nothing cancels: 2 a^2 = modulus + real, and
    # (modulus + real)(modulus - real) = 4 eta^2 k^2.
    other = maximum(modulus - real, 1e-30)
    twice_a2 = where(real >= 0.0, modulus + real, 4.0 * eta * eta * k * k / other)
    a_cos = 2.0 * cos_i * sqrt(0.5 * maximum(0.0, twice_a2))
    s_sum = modulus + cos2 + a_cos
    s = where(s_sum > 0.0, (modulus + cos2 - a_cos) / where(s_sum > 0.0, s_sum, 1.0), 1.0)
    # r_p = r_s * (...), with the roles of cos^2 and sin^2 mixed (PBR4's real form).
    p_even, p_odd = cos2 * modulus + sin2 * sin2, a_cos * sin2
    p_sum = p_even + p_odd
    p = where(p_sum > 0.0, (p_even - p_odd) / where(p_sum > 0.0, p_sum, 1.0), 1.0)
    # Where nothing is reflected, s is what rounding leaves of a difference.
    return minimum(maximum(0.5 * s * (1.0 + p), 0.0), 1.0)


@kernel
def fresnel_schlick(cos_i, f0):
    """f0 + (1 - f0)(1 - cos)^5: the usual approximation, from the reflectance f0 at cos = 1."""
    m = minimum(maximum(1.0 - absolute(cos_i), 0.0), 1.0)
    m2 = m * m
    return f0 + (1.0 - f0) * (m2 * m2 * m)


@kernel
def refract(wo, eta, cos_t):
    """`wo` refracted at z = 0 to the other side; unit length if cos_t obeys Snell's law."""
    # The part along the surface shrinks by 1 / eta, which is Snell's law.
    z = where(wo.z > 0.0, -cos_t, cos_t)
    return Vec3(-wo.x / eta, -wo.y / eta, z)
