r"""Spectra -> linear sRGB, as Mitsuba reduces them when it computes in RGB.

.. math::
    (X, Y, Z) = \frac{1}{N} \int s(\lambda)\, w(\lambda)\, (\bar x, \bar y, \bar z)\, d\lambda,
    \qquad N = \int \bar y\, d\lambda

A reflectance or an index of refraction is seen in daylight (w is D65, so that a grey stays grey), a
light by itself (w = 1, so that the same power at all wavelengths is reddish: sRGB's white is D65).
Negative channels, of colours outside of sRGB, become 0.

Source: Mitsuba 3 (found by experiment, equal to 0.02 %); the constants of IEC 61966-2-1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.core.cie import D65, OBSERVER, WAVELENGTHS

TO_SRGB = np.array(
    [
        [3.240479, -1.537150, -0.498535],
        [-0.969256, 1.875991, 0.041556],
        [0.055648, -0.204043, 1.057311],
    ]
)
# Mitsuba divides D65 by this, which leaves a reflectance of 1 at 0.9989.
DAYLIGHT = 98.9974
LUMINOUS = 106.856895

# CODATA 2018: h c^2 2 in W m^2 / sr and h c / k in m K.
_FIRST, _SECOND = 1.191042972397188e-16, 1.438776877503933e-2

# Fine enough for spectra with steps in them.
_FINE = np.arange(360.0, 830.25, 0.5)


def to_linear_srgb(
    wavelengths: NDArray[np.float64], values: NDArray[np.float64], *, shines: bool
) -> list[float]:
    """Reduce a spectrum to three numbers.

    Parameters
    ----------
    wavelengths : (n,) float64, nm
        Ascending.
    values : (n,) float64
        In between the spectrum is linear, outside it is 0.
    shines : bool
        Whether it is emitted, not a property of a surface.
    """
    spectrum = np.interp(_FINE, wavelengths, values, left=0.0, right=0.0)
    return [max(0.0, float(channel)) for channel in _seen(spectrum, shines=shines)]


def _seen(spectrum: NDArray[np.float64], *, shines: bool) -> NDArray[np.float64]:
    """Linear sRGB of a spectrum at the wavelengths `_FINE`, with what is negative."""
    if not shines:
        spectrum = spectrum * np.interp(_FINE, WAVELENGTHS, D65) / DAYLIGHT
    curves = [np.interp(_FINE, WAVELENGTHS, OBSERVER[:, i]) for i in range(3)]
    xyz = [np.trapezoid(spectrum * curve, _FINE) / LUMINOUS for curve in curves]
    return TO_SRGB @ xyz


def reduction_error(
    wavelengths: NDArray[np.float64], values: NDArray[np.float64], *, shines: bool
) -> tuple[float, float]:
    r"""How far light is off if three numbers take the place of a spectrum s.

    .. math:: e_k = \max_c |S(s^k)_c - \bar S(s)_c^k| \Big/ \max_c |S(s^k)_c|

    S is the colour in linear sRGB, and \bar S what is left of it in [0, 1], of lights above 0.

    Parameters
    ----------
    wavelengths, values, shines
        See `to_linear_srgb`.

    Returns
    -------
    e_1, e_2 : float
        Of what is seen directly, in daylight if it does not shine, and after two reflections; of
        lights the latter is 0.
    """
    spectrum = np.interp(_FINE, wavelengths, values, left=0.0, right=0.0)
    kept = np.clip(_seen(spectrum, shines=shines), 0.0, np.inf if shines else 1.0)
    off = []
    for times in (1,) if shines else (1, 2):
        color = _seen(spectrum**times, shines=shines)
        most = np.abs(color).max()
        off.append(float(np.abs(color - kept**times).max() / most) if most > 0.0 else 0.0)
    return off[0], 0.0 if shines else off[1]


def reflectance_weights(wavelengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each number of a reflectance adds to linear sRGB in daylight.

    Parameters
    ----------
    wavelengths : (n,) float64, nm
        Ascending; in between reflectances are linear, beyond the ends as there.

    Returns
    -------
    (3, n) float64
        The sum of each channel is 1: white stays white.
    """
    hats = np.array([np.interp(_FINE, wavelengths, hat) for hat in np.eye(len(wavelengths))])
    light = np.interp(_FINE, WAVELENGTHS, D65)
    curves = [np.interp(_FINE, WAVELENGTHS, OBSERVER[:, i]) * light for i in range(3)]
    weights = TO_SRGB @ np.array([np.trapezoid(hats * curve, _FINE, axis=1) for curve in curves])
    return weights / weights.sum(axis=1, keepdims=True)


def blackbody(temperature: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Planck's law: wavelengths in nm and radiance in W m^-2 sr^-1 nm^-1.

    Parameters
    ----------
    temperature : float, K
    """
    metres = _FINE * 1e-9
    with np.errstate(over="ignore"):
        per_metre = _FIRST / (metres**5 * np.expm1(_SECOND / (metres * temperature)))
    return _FINE, per_metre * 1e-9
