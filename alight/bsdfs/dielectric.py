r"""Smooth dielectric (glass, water): reflects and refracts, both without blur.

.. math::
    \text{reflect with probability } F(\cos\theta_o; \eta), \qquad
    \text{refract with } 1 - F, \qquad \eta = \eta_\text{int} / \eta_\text{ext}

Two Dirac lobes. Radiance that is refracted is scaled by 1 / eta^2, because the beam's solid angle
changes. `int_ior` lies on the side that the normal points away from.

Source: PBR4 section 9.5; Veach, Robust Monte Carlo Methods (1997), section 5.2 for the factor.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, Literal

from pydantic import BeforeValidator

from alight.bsdfs.flags import DELTA, REFLECTION, TRANSMISSION
from alight.bsdfs.tints import WHITE, tint, tint_features
from alight.core.errors import unknown_name
from alight.core.fresnel import fresnel_dielectric, refract
from alight.core.jit import kernel
from alight.core.simd import absolute, lanes, lanes_u32, lanes_vec3, where
from alight.core.spec import Bsdf, ColorTexture, IndexOfRefraction, invalid
from alight.core.vec import Vec3
from alight.textures.fetch import scalar

# Indices at 589.3 nm (sodium D), from the CRC Handbook of Chemistry and Physics and the
# catalogue of Schott AG (bk7: 1.5168, at the green 546 nm line 1.5187).
MEDIA: dict[str, float] = {
    "vacuum": 1.0,
    "air": 1.000277,
    "ice": 1.31,
    "water": 1.333,
    "ethanol": 1.361,
    "fused_quartz": 1.4585,
    "acrylic": 1.49,
    "bk7": 1.5168,
    "amber": 1.55,
    "sapphire": 1.77,
    "diamond": 2.419,
}


def _by_name(value: object) -> object:
    if isinstance(value, str):
        if value not in MEDIA:
            raise invalid(unknown_name("medium", value, MEDIA))
        return MEDIA[value]
    return value


Medium = Annotated[IndexOfRefraction, BeforeValidator(_by_name)]


class Interface(Bsdf):
    """Base class of boundaries between two clear media.

    Parameters
    ----------
    int_ior, ext_ior : float in [1, 5] or str, defaults "bk7" and "air"
        Indices of refraction inside and outside, as numbers or names of `MEDIA`.
    specular_reflectance, specular_transmittance : ColorTexture, defaults 1
        Factors of what is reflected and let through, each channel in [0, 1]; 1 for real media.
    """

    transmissive = True
    int_ior: Medium = MEDIA["bk7"]
    ext_ior: Medium = MEDIA["air"]
    specular_reflectance: ColorTexture = WHITE
    specular_transmittance: ColorTexture = WHITE


class Dielectric(Interface):
    """Clear glass, water and the like.

    Parameters
    ----------
    int_ior, ext_ior, specular_reflectance, specular_transmittance
        As in `Interface`.
    """

    type: Literal["dielectric"] = "dielectric"


EXAMPLES = (
    Dielectric(),
    Dielectric(int_ior="water", ext_ior="bk7"),
    Dielectric(int_ior="diamond", ext_ior="vacuum"),
    Dielectric(int_ior=1.0, ext_ior=1.0),
    Dielectric(specular_reflectance=(0.9, 0.6, 0.2), specular_transmittance=(0.3, 1.0, 0.8)),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Dielectric) -> bool:
    """All light that arrives leaves again."""
    return spec.specular_reflectance == spec.specular_transmittance == WHITE


def is_reciprocal(spec: Dielectric) -> bool:
    """f(wo, wi) / eta_o^2 = f(wi, wo) / eta_i^2, with the index on the side of each direction."""
    return True


# ---------------------------------------------------------------- tables

SLOTS = {"eta": 1, "specular_reflectance": 3, "specular_transmittance": 3}
Params = namedtuple("DielectricParams", "eta reflectance transmittance")


def pack(spec: Dielectric, packer) -> None:
    """Fill the row of one material."""
    pack_interface(spec, packer)


def pack_interface(spec: Interface, packer) -> None:
    """Fill the slots of `SLOTS`."""
    packer.numbers("eta", spec.int_ior / spec.ext_ior)
    packer.color("specular_reflectance", spec.specular_reflectance)
    packer.color("specular_transmittance", spec.specular_transmittance)


def features(spec: Dielectric) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return tint_features(spec.specular_reflectance, spec.specular_transmittance)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    return Params(
        scalar(scene, base, surface),
        tint(scene, base + 1, surface),
        tint(scene, base + 4, surface),
    )


@kernel
def inner_index(scene, base, surface):
    """Index of refraction inside over that outside, of a row that begins with `SLOTS`."""
    return scalar(scene, base, surface)


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(0, 0): directions that were not sampled from a Dirac lobe never lie in it."""
    return lanes_vec3(0.0), lanes(0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    eta = where(wo.z > 0.0, params.eta, 1.0 / params.eta)
    fresnel, cos_t = fresnel_dielectric(absolute(wo.z), eta)
    reflects = u < fresnel
    wi = where(reflects, Vec3(-wo.x, -wo.y, wo.z), refract(wo, eta, cos_t))
    pmf = where(reflects, fresnel, 1.0 - fresnel)
    # The lobe's factor F or 1 - F is also its probability, so it cancels. Light that comes from the
    # denser side fans out into a wider solid angle: its radiance falls by 1 / eta^2.
    weight = where(reflects, 1.0, 1.0 / (eta * eta))
    flags = where(reflects, lanes_u32(REFLECTION | DELTA), lanes_u32(TRANSMISSION | DELTA))
    return wi, where(reflects, params.reflectance, params.transmittance) * weight, pmf, flags


@kernel
def albedo(params):
    """What is let through; nothing is absorbed by real media."""
    return params.transmittance
