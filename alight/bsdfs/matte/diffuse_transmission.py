r"""Matte surface that transmits light: paper, leaves, lamp shades.

.. math::
    f(\omega_o, \omega_i) = \frac{1}{\pi} \begin{cases}
        \rho' & \text{both directions on one side} \\
        \tau' & \text{on different sides}
    \end{cases}, \qquad
    (\rho', \tau') = \frac{(\rho, \tau)}{\max(1, \rho + \tau)}

The same from both sides. Reflection or transmission is chosen in proportion to the luminance of the
two, then a direction in proportion to the cosine. Where the two together exceed 1 in a channel,
both are scaled down, so that no energy is created.

Source: PBR4 section 9.2 and the material ``diffusetransmission`` of its program.
"""

from __future__ import annotations

from collections import namedtuple
from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, luminance
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import TexturedColor
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes_u32, maximum, where


class DiffuseTransmission(Bsdf):
    """Thin matte sheet.

    Parameters
    ----------
    reflectance : ColorTexture, default 0.25
        Part of the light that goes back, each channel in [0, 1].
    transmittance : ColorTexture, default 0.25
        Part of the light that is transmitted, each channel in [0, 1].
    """

    transmissive: ClassVar[bool] = True
    matte: ClassVar[bool] = True
    type: Literal["diffuse_transmission"] = "diffuse_transmission"
    reflectance: ColorTexture = (0.25, 0.25, 0.25)
    transmittance: ColorTexture = (0.25, 0.25, 0.25)


EXAMPLES = (
    DiffuseTransmission(),
    DiffuseTransmission(reflectance=0.5, transmittance=0.5),
    DiffuseTransmission(reflectance=(0.1, 0.4, 0.05), transmittance=(0.3, 0.5, 0.02)),
    DiffuseTransmission(reflectance=(1.0, 0.5, 0.0), transmittance=(1.0, 1.0, 1.0)),
    DiffuseTransmission(reflectance=0.0, transmittance=0.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: DiffuseTransmission) -> bool:
    """Whether all light that arrives leaves again, on either side."""
    if isinstance(spec.reflectance, tuple) and isinstance(spec.transmittance, tuple):
        pairs = zip(spec.reflectance, spec.transmittance, strict=True)
        return all(sum(pair) >= 1.0 for pair in pairs)
    return False


def is_reciprocal(spec: DiffuseTransmission) -> bool:
    """f(wo, wi) = f(wi, wo), from either side."""
    return True


# ---------------------------------------------------------------- tables


class Row(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor
    transmittance: TexturedColor


SLOTS = slots_of(Row)
_load_row = loader(Row)
#: share: probability of reflection.
Params = namedtuple("DiffuseTransmissionParams", "reflectance transmittance share")


def pack(spec: DiffuseTransmission, packer) -> None:
    """Fill the row of one material."""
    packer.color("reflectance", spec.reflectance)
    packer.color("transmittance", spec.transmittance)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface, textures looked up."""
    back, on = _load_row(scene, base, surface)
    whole = back + on
    scale = Vec3(
        1.0 / maximum(whole.x, 1.0), 1.0 / maximum(whole.y, 1.0), 1.0 / maximum(whole.z, 1.0)
    )
    back, on = back * scale, on * scale
    # A black sheet reflects nothing with probability 0 as well as with any other.
    share = luminance(back) / maximum(luminance(back + on), 1e-20)
    return Params(back, on, share)


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    cosine = INV_PI * absolute(wi.z)
    cosine = where(wo.z * wi.z == 0.0, 0.0, cosine)
    goes_back = wo.z * wi.z > 0.0
    f = where(goes_back, params.reflectance, params.transmittance)
    return f * cosine, where(goes_back, params.share, 1.0 - params.share) * cosine


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    goes_back = u < params.share
    wi = square_to_cosine_hemisphere(u2)
    chance = where(goes_back, params.share, 1.0 - params.share)
    pdf = INV_PI * wi.z * chance
    # (rho / pi) cos / (share cos / pi): the cosine cancels.
    weight = where(goes_back, params.reflectance, params.transmittance) / maximum(chance, 1e-20)
    # Above the surface if wo is above and is reflected, or is below and is transmitted.
    above = wo.z > 0.0
    turned = (above & ~goes_back) | (~above & goes_back)
    wi = Vec3(wi.x, wi.y, where(turned, -wi.z, wi.z))
    right = wo.z != 0.0
    flags = where(goes_back, lanes_u32(REFLECTION), lanes_u32(TRANSMISSION))
    return wi, where(right, weight, weight * 0.0), where(right, pdf, 0.0), flags


@kernel
def albedo(params):
    """Light that leaves on either side."""
    return params.reflectance + params.transmittance
