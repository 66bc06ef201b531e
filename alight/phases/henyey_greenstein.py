r"""Henyey-Greenstein phase function: one lobe, forward for g > 0, backward for g < 0.

.. math:: p(\mu) = \frac{1}{4 \pi} \frac{1 - g^2}{(1 + g^2 - 2 g \mu)^{3/2}}, \qquad
    \langle \mu \rangle = g

Its distribution function can be inverted. Written for :math:`1 - \mu` the inverse has no
cancellation, neither for g = 0 nor in a sharp peak:

.. math:: 1 - \mu = \frac{2 (1 - u) (1 - g)^2 (1 + g u)}{(1 - g + 2 g u)^2}

Source: Henyey and Greenstein, Diffuse radiation in the galaxy, Astrophysical Journal 93 (1941);
PBR4 section 11.3.1.
"""

from __future__ import annotations

from typing import Annotated, Literal

from alight.core.constants import INV_FOUR_PI
from alight.core.fields import Interval
from alight.core.spec import PhaseFunction
from lanewise.jit import kernel
from lanewise.simd import sqrt


class HenyeyGreenstein(PhaseFunction):
    """One lobe of scattering.

    Parameters
    ----------
    g : float in [-0.99, 0.99], default 0
        Mean cosine: 0 is isotropic, towards 1 light continues nearly straight.
    """

    type: Literal["henyey_greenstein"] = "henyey_greenstein"
    g: Annotated[float, Interval(-0.99, 0.99)] = 0.0


EXAMPLES = (
    HenyeyGreenstein(),
    HenyeyGreenstein(g=0.5),
    HenyeyGreenstein(g=-0.7),
    HenyeyGreenstein(g=0.99),
)


def parameter(spec: HenyeyGreenstein) -> float:
    """The number that kernels are given."""
    return spec.g


def mean_cosine(spec: HenyeyGreenstein) -> float:
    """Mean of the cosine between the directions before and after."""
    return spec.g


@kernel
def density(parameter, one_minus_cosine):
    """Density per steradian."""
    g = parameter
    # 1 + g^2 - 2 g mu, which would cancel in a forward peak.
    s = (1.0 - g) * (1.0 - g) + 2.0 * g * one_minus_cosine
    return INV_FOUR_PI * (1.0 - g) * (1.0 + g) / (s * sqrt(s))


@kernel
def sample(parameter, u):
    """1 - cosine, from u in [0, 1)."""
    g = parameter
    below = 1.0 - g + 2.0 * g * u
    return 2.0 * (1.0 - u) * (1.0 - g) * (1.0 - g) * (1.0 + g * u) / (below * below)
