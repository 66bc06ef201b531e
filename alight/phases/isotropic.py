r"""Isotropic phase function: every direction is equally likely.

.. math:: p = \frac{1}{4 \pi}

Source: PBR4 section 11.3.
"""

from __future__ import annotations

from typing import Literal

from alight.core.constants import INV_FOUR_PI
from alight.core.spec import PhaseFunction
from lanewise.jit import kernel
from lanewise.simd import lanes


class Isotropic(PhaseFunction):
    """Scattering without memory of where light came from."""

    type: Literal["isotropic"] = "isotropic"


EXAMPLES = (Isotropic(),)


def parameter(spec: Isotropic) -> float:
    """The number that kernels are given: none is needed."""
    return 0.0


def mean_cosine(spec: Isotropic) -> float:
    """Mean of the cosine between the directions before and after."""
    return 0.0


@kernel
def density(parameter, one_minus_cosine):
    """Density per steradian."""
    return lanes(INV_FOUR_PI)


@kernel
def sample(parameter, u):
    """1 - cosine, from u in [0, 1)."""
    return 2.0 * u
