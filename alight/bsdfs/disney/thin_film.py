r"""Colours of a thin film on a surface: soap, oil, tempered steel.

A film of index n2 and thickness d lies between air and a base that reflects R23 by itself. The
paths inside it add up with the phase 2 pi (2 n2 d cos theta_2) / wavelength, plus a half turn at
each reflection from a denser medium. Summed over all rounds and over the eye's response,

.. math::
    F = C_0 + 2 \sum_{m=1}^{2} C_m\, S(m D, m \phi), \qquad
    C_0 = R_{12} + R_s, \quad C_m = (R_s - T^2) (R_{12} R_{23})^{m/2}, \quad
    R_s = \frac{T^4 R_{23}}{1 - R_{12} R_{23}}, \quad T^2 = 1 - R_{12},

with the Fourier transform S of the response, as Gaussians. Light is taken to be unpolarised, and
the base to be dielectric or, where it is a metal, as an index that reflects as much.

Source: Belcour and Barla 2017, A Practical Extension to Microfacet Theory for the Modeling of
Varying Iridescence, with the numbers of their supplement; KHR_materials_iridescence of glTF.
"""

from __future__ import annotations

from alight.core.constants import PI, TWO_PI
from alight.core.fresnel import fresnel_dielectric, fresnel_schlick
from alight.core.maths import exp, sincos
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import maximum, minimum, sqrt, where


@kernel
def _gaussian(height, place, width, phase, shift):
    # Beyond 1e4 radians the envelope has long vanished.
    _, c = sincos(minimum(place * phase + shift, 1e4))
    return height * c * exp(-width * (phase * phase))


@kernel
def _response(difference, shift):
    """S of linear sRGB at an optical path difference in metres; channels shift on their own."""
    phase = TWO_PI * difference
    # Gaussians of the colour-matching functions over the wave number: area over that of Y, place,
    # and squared width; X has a second one.
    x = _gaussian(0.8465900, 1.6810e6, 4.3278e9, phase, shift.x)
    x = x + _gaussian(0.1538683, 2.2399e6, 4.5282e9, phase, shift.x)
    y = _gaussian(1.0002219, 1.7953e6, 9.3046e9, phase, shift.y)
    z = _gaussian(1.0011225, 2.2084e6, 6.6121e9, phase, shift.z)
    return Vec3(
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    )


@kernel
def _inner_channel(f0, eta2, cos_2):
    """(R23, phase) of the boundary between film and base."""
    root = sqrt(minimum(maximum(f0, 0.0), 0.9999))
    base = (1.0 + root) / (1.0 - root)
    r = (base - eta2) / (base + eta2)
    return fresnel_schlick(cos_2, r * r), where(base < eta2, PI, 0.0)


@kernel
def film_fresnel(cos_1, eta2, thickness, f0):
    """Reflected part of light that meets a film, for each channel in [0, 1].

    Parameters
    ----------
    cos_1 : float in [0, 1]
        Cosine outside the film.
    eta2 : float
        Index of the film.
    thickness : float
        Nanometres.
    f0 : Vec3
        What the base reflects in air along its normal.
    """
    # Films thinner than light's waves vanish: their index goes over to that of air.
    part = minimum(maximum(thickness * (1.0 / 30.0), 0.0), 1.0)
    part = part * part * (3.0 - 2.0 * part)
    eta2 = 1.0 + (eta2 - 1.0) * part
    r12, cos_2 = fresnel_dielectric(cos_1, eta2)
    t = 1.0 - r12
    # The first boundary turns light around by half a turn seen from outside: none from inside.
    x, phase_x = _inner_channel(f0.x, eta2, cos_2)
    y, phase_y = _inner_channel(f0.y, eta2, cos_2)
    z, phase_z = _inner_channel(f0.z, eta2, cos_2)
    r23 = Vec3(x, y, z)
    shift = Vec3(PI + phase_x, PI + phase_y, PI + phase_z)
    difference = 2e-9 * eta2 * thickness * cos_2
    both = minimum(r12, 0.9999) * r23
    inner = Vec3(_root(both.x), _root(both.y), _root(both.z))
    rs = Vec3(t * t * x / (1.0 - both.x), t * t * y / (1.0 - both.y), t * t * z / (1.0 - both.z))
    total = r12 + rs
    order = (rs - t) * inner
    total = total + 2.0 * (order * _response(difference, shift))
    order = order * inner
    total = total + 2.0 * (order * _response(2.0 * difference, 2.0 * shift))
    return Vec3(_share(total.x), _share(total.y), _share(total.z))


@kernel
def _root(a):
    return sqrt(maximum(a, 0.0))


@kernel
def _share(a):
    return minimum(maximum(a, 0.0), 1.0)
