r"""Rayleigh phase function: particles much smaller than the wavelength, such as air's.

.. math:: p(\mu) = \frac{3}{16 \pi} (1 + \mu^2)

The distribution function is a cubic, whose real root is
:math:`\mu = a - 1 / a` with :math:`a^3 = c + \sqrt{c^2 + 1}`, :math:`c = 2 (2 u - 1)`.

Source: Frisvad, Importance sampling the Rayleigh phase function, JOSA A 28(12) (2011).
"""

from __future__ import annotations

from typing import Literal

from alight.core.constants import INV_FOUR_PI
from alight.core.maths import pow
from alight.core.spec import PhaseFunction
from lanewise.jit import kernel
from lanewise.simd import absolute, sqrt, where


class Rayleigh(PhaseFunction):
    """Scattering by very small particles."""

    type: Literal["rayleigh"] = "rayleigh"


EXAMPLES = (Rayleigh(),)


def parameter(spec: Rayleigh) -> float:
    """The number that kernels are given: none is needed."""
    return 0.0


def mean_cosine(spec: Rayleigh) -> float:
    """Mean of the cosine between the directions before and after."""
    return 0.0


@kernel
def density(parameter, one_minus_cosine):
    """Density per steradian."""
    mu = 1.0 - one_minus_cosine
    return 0.75 * INV_FOUR_PI * (1.0 + mu * mu)


@kernel
def sample(parameter, u):
    """1 - cosine, from u in [0, 1)."""
    c = 2.0 * (2.0 * u - 1.0)
    # The root of the larger number: that of the smaller one, its inverse, would cancel.
    a = pow(absolute(c) + sqrt(c * c + 1.0), 1.0 / 3.0)
    mu = a - 1.0 / a
    return 1.0 - where(c < 0.0, -mu, mu)
