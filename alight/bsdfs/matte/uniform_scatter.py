r"""Scatters uniformly over the hemisphere with weight = albedo: the beginner's "diffuse".

.. math::
    p(\omega_i) = \frac{1}{2\pi}, \qquad
    f(\omega_o, \omega_i)\, \cos\theta_i = \frac{\rho}{2\pi}

Many first ray tracers pick a uniform direction and multiply by the albedo, forgetting the cosine.
That is a material of its own, f = rho / (2 pi cos theta_i): it keeps energy, but it is **not
reciprocal**, and it scatters more light to grazing directions than Lambert's law.

Source: reciprocity as in Veach, Robust Monte Carlo Methods (1997), section 3.6.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_TWO_PI
from alight.core.field_types import ColorTexture
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.warps import square_to_uniform_hemisphere
from alight.textures.fetch import TexturedColor
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, where


class UniformScatter(Bsdf):
    """Surface that scatters to all directions of the hemisphere with equal probability.

    Parameters
    ----------
    reflectance : ColorTexture, default 0.5
        Albedo, each channel in [0, 1].
    """

    matte: ClassVar[bool] = True
    type: Literal["uniform_scatter"] = "uniform_scatter"
    reflectance: ColorTexture = (0.5, 0.5, 0.5)


EXAMPLES = (
    UniformScatter(),
    UniformScatter(reflectance=1.0),
    UniformScatter(reflectance=(0.9, 0.5, 0.1)),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: UniformScatter) -> bool:
    """All light that arrives leaves again."""
    return spec.reflectance == (1.0, 1.0, 1.0)


def is_reciprocal(spec: UniformScatter) -> bool:
    """f(wo, wi) = f(wi, wo) only where there is nothing to exchange."""
    return spec.reflectance == (0.0, 0.0, 0.0)


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: UniformScatter, packer) -> None:
    """Fill the row of one material."""
    packer.color("reflectance", spec.reflectance)


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    pdf = where((wo.z > 0.0) & (wi.z > 0.0), INV_TWO_PI, 0.0)
    return params.reflectance * pdf, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    wi = square_to_uniform_hemisphere(u2)
    above = (wo.z > 0.0) & (wi.z > 0.0)
    weight = params.reflectance * where(above, 1.0, 0.0)
    return wi, weight, where(above, INV_TWO_PI, 0.0), lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of the light."""
    return params.reflectance
