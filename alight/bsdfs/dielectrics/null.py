r"""A surface that is not there: light passes straight on.

.. math:: \omega_i = -\omega_o, \qquad \text{weight} = 1

For surfaces that only bound something, or that only emit (an area light that should not reflect).
Samples carry the flag NULL.

Source: the null interface of PBR4 section 14.2.
"""

from __future__ import annotations

from collections import namedtuple
from typing import ClassVar, Literal

from alight.bsdfs.dirac import evaluate as evaluate
from alight.bsdfs.flags import DELTA, NULL, TRANSMISSION
from alight.core.spec import Bsdf
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, lanes_vec3


class Null(Bsdf):
    """Invisible interface."""

    transmissive = True
    one_sided: ClassVar[bool] = True
    unseen: ClassVar[bool] = True
    type: Literal["null"] = "null"

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions."""
        return 1.0


EXAMPLES = (Null(),)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Null) -> bool:
    """All light that arrives leaves again."""
    return True


def is_reciprocal(spec: Null) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables

Params = namedtuple("NullParams", "")


def pack(spec: Null, packer) -> None:
    """Nothing to store."""


@kernel
def load(scene, base, surface):
    """No parameters."""
    return Params()


# ---------------------------------------------------------------- scattering


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    return -wo, lanes_vec3(1.0), lanes(1.0), lanes_u32(TRANSMISSION | DELTA | NULL)


@kernel
def albedo(params):
    """Nothing is reflected."""
    return lanes_vec3(0.0)
