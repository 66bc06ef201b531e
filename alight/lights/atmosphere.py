r"""Light of the sun and of a clear sky, in closed form.

The sky is Preetham's: with :math:`\theta` from the zenith and :math:`\gamma` from the sun

.. math::
    F(\theta, \gamma) = (1 + A e^{B / \cos\theta}) (1 + C e^{D \gamma} + E \cos^2\gamma), \qquad
    Y = Y_z F(\theta, \gamma) / F(0, \theta_s)

and likewise for the chromaticities x and y; A to E and the zenith's values depend on the turbidity
and the height of the sun. The sun's disk is a black body of 5778 K, all of it equally bright, seen
through Rayleigh's and the haze's scattering and the ozone; water vapour and mixed gases, which take
little of the visible light, are left out.

Radiances are linear sRGB in W/(m^2 sr), one watt being 683 lumens: Y is the luminance in cd/m^2
over 683.

Sources: Preetham, Shirley and Smits, A practical analytic model for daylight, SIGGRAPH 1999
(appendix for the coefficients; Iqbal 1983 for the ozone); Wyman, Sloan and Shirley, Simple analytic
approximations to the CIE XYZ color matching functions, JCGT 2(2), 2013.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.core.field_types import Triple

#: XYZ -> linear sRGB (IEC 61966-2-1).
_TO_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
# For Y, x and y: rows A to E, each slope times turbidity plus offset.
_SHAPE = np.array(
    [
        [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771],
         [-0.0670, 0.3703]],
        [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989],
         [-0.0033, 0.0452]],
        [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537],
         [-0.0109, 0.0529]],
    ]
)  # fmt: skip
# Chromaticity of the zenith: rows T^2, T, 1; columns theta^3, theta^2, theta, 1.
_ZENITH = np.array(
    [
        [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394],
         [0.11693, -0.21196, 0.06052, 0.25886]],
        [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516],
         [0.15346, -0.26756, 0.06670, 0.26688]],
    ]
)  # fmt: skip

#: nm, and the ozone's absorption at them, 1/cm.
_WAVELENGTHS = np.arange(380.0, 751.0, 10.0)
_OZONE = np.array(
    [0, 0, 0, 0, 0, 0, 0, 0.003, 0.006, 0.009, 0.014, 0.021, 0.03, 0.04, 0.048, 0.063, 0.075, 0.085,
     0.103, 0.12, 0.12, 0.115, 0.125, 0.12, 0.105, 0.09, 0.079, 0.067, 0.057, 0.048, 0.036, 0.028,
     0.023, 0.018, 0.014, 0.011, 0.01, 0.009]
)  # fmt: skip
# Ozone at normal pressure, cm; temperature of the sun, K.
_OZONE_DEPTH, _TEMPERATURE = 0.35, 5778.0


def sky_radiance(directions: NDArray[np.float64], sun: ArrayLike, turbidity: float) -> np.ndarray:
    """Radiance of the sky in some directions above the horizon.

    Parameters
    ----------
    directions : (..., 3) float64
        Unit vectors, +y up.
    sun : (3,) float
        Unit vector to the sun, which is above the horizon.
    turbidity : float

    Returns
    -------
    (..., 3) float64, W/(m^2 sr)
        Not negative.
    """
    sun = np.asarray(sun, float)
    zenith = float(np.arccos(np.clip(sun[1], 0.0, 1.0)))
    cosine = np.maximum(directions[..., 1], 0.01)
    gamma = np.arccos(np.clip(directions @ sun, -1.0, 1.0))
    chi = (4.0 / 9.0 - turbidity / 120.0) * (np.pi - 2.0 * zenith)
    bright = (4.0453 * turbidity - 4.9710) * np.tan(chi) - 0.2155 * turbidity + 2.4192
    powers = np.array([zenith**3, zenith**2, zenith, 1.0])
    chroma = np.array([turbidity**2, turbidity, 1.0]) @ (_ZENITH @ powers).T
    values = []
    for shape, at_zenith in zip(_SHAPE, (1000.0 * bright, *chroma), strict=True):
        a, b, c, d, e = shape @ [turbidity, 1.0]

        def perez(cosine, gamma, a=a, b=b, c=c, d=d, e=e):
            rim = 1.0 + a * np.exp(b / cosine)
            return rim * (1.0 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2)

        values.append(at_zenith * perez(cosine, gamma) / perez(1.0, zenith))
    luminance, x, y = np.maximum(values[0], 0.0) / 683.0, values[1], values[2]
    xyz = np.stack([x / y, np.ones_like(x), (1.0 - x - y) / y], axis=-1) * luminance[..., None]
    return np.maximum(xyz @ _TO_RGB.T, 0.0)


def air_mass(elevation: float) -> float:
    """Way of sunlight through the air over that from the zenith; elevation in radians."""
    # Kasten 1965, as in Preetham's appendix.
    degrees = np.degrees(elevation)
    return float(1.0 / (np.sin(elevation) + 0.15 * (degrees + 3.885) ** -1.253))


def sun_transmittance(elevation: float, turbidity: float) -> NDArray[np.float64]:
    """Share of the sun's light that arrives, by wavelength (380, 390, ..., 750 nm)."""
    mass, micrometres = air_mass(elevation), _WAVELENGTHS / 1000.0
    rayleigh = 0.008735 * micrometres**-4.08
    haze = (0.04608 * turbidity - 0.04586) * micrometres**-1.3
    return np.exp(-mass * (rayleigh + haze + _OZONE * _OZONE_DEPTH))


def sun_radiance(elevation: float, turbidity: float) -> Triple:
    """Mean radiance of the sun's disk, W/(m^2 sr).

    Parameters
    ----------
    elevation : float
        Radians above the horizon, at least 0.
    turbidity : float
    """
    # Planck's law, W/(m^2 sr nm); hc/k = 1.438777e7 nm K.
    c1 = 1.191043e20
    planck = c1 / _WAVELENGTHS**5 / np.expm1(1.438777e7 / (_WAVELENGTHS * _TEMPERATURE))
    spectrum = planck * sun_transmittance(elevation, turbidity)
    xyz = (color_matching(_WAVELENGTHS) * spectrum).sum(axis=1) * 10.0
    red, green, blue = np.maximum(_TO_RGB @ xyz, 0.0)
    return float(red), float(green), float(blue)


def color_matching(wavelength: NDArray[np.float64]) -> NDArray[np.float64]:
    """The CIE 1931 functions x, y and z, within 1 % of their maxima; (3, n) for n nm."""

    def lobe(middle, below, above):
        width = np.where(wavelength < middle, below, above)
        return np.exp(-0.5 * ((wavelength - middle) / width) ** 2)

    return np.array(
        [
            1.056 * lobe(599.8, 37.9, 31.0)
            + 0.362 * lobe(442.0, 16.0, 26.7)
            - 0.065 * lobe(501.1, 20.4, 26.2),
            0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
            1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
        ]
    )
