r"""Wavelengths of light, and what one alone does to the three channels of a picture.

Glass that disperses light refracts each wavelength by itself. A path that meets some is followed
for one wavelength from then on, and stands for its share of each channel. The wavelength has the
density

.. math:: p(\lambda) \propto \operatorname{sech}^2(k (\lambda - \lambda_m)),

and the path is multiplied by

.. math:: w_c(\lambda) = \frac{r_c(\lambda)}{p(\lambda) \int r_c}, \qquad c = R, G, B,

where r_c are the colour-matching functions of the linear sRGB primaries. So w_c has the mean 1 in
each channel, and white light stays white when all wavelengths are put together again. One alone
lies outside what the three primaries can mix: there a weight is negative, as the matching functions
are, and so may be the channel of a pixel that sees a pure part of a rainbow.

The model: each channel of a light shines with the spectrum that is white to the film, scaled by the
channel, and tints act on the channels. For white lights behind clear glass that is what a spectral
renderer shows.

Source: Wyman, Sloan and Shirley 2013, Simple analytic approximations to the CIE XYZ color matching
functions, JCGT 2(2), the fit by several lobes; IEC 61966-2-1 for the primaries; Wilkie et al.,
Hero wavelength spectral sampling, EGSR 2014; PBR4 section 4.5.4 for the density's form.
"""

from __future__ import annotations

import numpy as np

from alight.core.maths import exp, log
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import where

#: What programs call a material that disperses light.
DISPERSIVE = "dispersive"

#: Nanometres: the line d of helium, for which indices of refraction are given, and F and C of
#: hydrogen, by which Abbe's number compares them.
LINE_D, LINE_F, LINE_C = 587.5618, 486.1327, 656.2725

#: Wavelengths of paths, nanometres: beyond, eyes see little. The density's middle and its rate per
#: nanometre make the second moments of the weights small.
SHORTEST, LONGEST = 380.0, 720.0
_MIDDLE, _RATE = 530.0, 0.0065
_LOW, _HIGH = (float(np.tanh(_RATE * (end - _MIDDLE))) for end in (SHORTEST, LONGEST))

_RGB_OF_XYZ = (
    (3.2404542, -1.5371385, -0.4985314),
    (-0.9692660, 1.8760108, 0.0415560),
    (0.0556434, -0.2040259, 1.0572252),
)


@kernel
def _lobe(wavelength, height, middle, below, above):
    """A Gauss curve of two widths."""
    t = (wavelength - middle) * where(wavelength < middle, 1.0 / below, 1.0 / above)
    return height * exp(-0.5 * t * t)


@kernel
def _matched(a):
    """The colour-matching functions x, y and z at the wavelengths a."""
    x = _lobe(a, 1.056, 599.8, 37.9, 31.0) + _lobe(a, 0.362, 442.0, 16.0, 26.7)
    x = x + _lobe(a, -0.065, 501.1, 20.4, 26.2)
    y = _lobe(a, 0.821, 568.8, 46.9, 40.5) + _lobe(a, 0.286, 530.9, 16.3, 31.1)
    z = _lobe(a, 1.217, 437.0, 11.8, 36.0) + _lobe(a, 0.681, 459.0, 26.0, 13.8)
    return Vec3(x, y, z)


def _scaled() -> list[list[float]]:
    """The matrix from XYZ, each row over the integral of its channel."""
    at = np.linspace(SHORTEST, LONGEST, 3401, dtype=np.float32)
    matched = _matched(at)
    xyz = np.array([matched.x, matched.y, matched.z], np.float64)
    matrix = np.array(_RGB_OF_XYZ)
    integrals = np.asarray(np.trapezoid(matrix @ xyz, at))
    return (matrix / integrals[:, np.newaxis]).tolist()


(_RX, _RY, _RZ), (_GX, _GY, _GZ), (_BX, _BY, _BZ) = _scaled()


@kernel
def wavelength_at(u):
    """The wavelength that a uniform number in [0, 1) chooses, nanometres."""
    t = _LOW + (_HIGH - _LOW) * u
    return _MIDDLE + (0.5 / _RATE) * log((1.0 + t) / (1.0 - t))


@kernel
def weights_at(u):
    """What a path of `wavelength_at(u)` is multiplied by, a Vec3 with the mean 1 over u."""
    t = _LOW + (_HIGH - _LOW) * u
    v = _matched(wavelength_at(u))
    per_pdf = ((_HIGH - _LOW) / _RATE) / (1.0 - t * t)
    return Vec3(
        (_RX * v.x + _RY * v.y + _RZ * v.z) * per_pdf,
        (_GX * v.x + _GY * v.y + _GZ * v.z) * per_pdf,
        (_BX * v.x + _BY * v.y + _BZ * v.z) * per_pdf,
    )
