r"""Smooth dielectric (glass, water): perfectly specular reflection and refraction.

.. math::
    \text{reflect with probability } F(\cos\theta_o; \eta), \qquad
    \text{refract with } 1 - F, \qquad \eta = \eta_\text{int} / \eta_\text{ext}

Two delta lobes. Beyond the critical angle F = 1: total internal reflection. Refracted radiance is
scaled by 1 / eta^2, because the beam's solid angle changes. `int_ior` lies on the side that the
normal points away from.

Nested bodies, such as water in a glass: every boundary is one surface, whose `int_ior` and
`ext_ior` name the media on its two sides. Overlapping surfaces have no priorities; where two
boundaries coincide, use only one. What bodies absorb: see `alight.bsdfs.interiors.absorption`.

Source: PBR4 section 9.5; Veach, Robust Monte Carlo Methods (1997), section 5.2 for the factor.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.dielectrics import interface
from alight.bsdfs.dielectrics.dispersion import Dispersive, Index, dispersion_features, pack_spread
from alight.bsdfs.dielectrics.interface import albedo as albedo
from alight.bsdfs.dielectrics.interface import is_lossless as is_lossless
from alight.bsdfs.dielectrics.interface import relative_ior as relative_ior
from alight.bsdfs.dirac import evaluate as evaluate
from alight.bsdfs.flags import DELTA, REFLECTION, TRANSMISSION
from alight.bsdfs.interiors.absorption import Absorbing, absorption_features
from alight.bsdfs.tints import Tint
from alight.core.fresnel import fresnel_dielectric, refract
from alight.core.parameters import loader, reader, slots_of
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes_u32, where


class Dielectric(Dispersive, Absorbing):
    """Clear glass, water and the like.

    Parameters
    ----------
    int_ior, ext_ior, specular_reflectance, specular_transmittance
        As in `alight.bsdfs.dielectrics.interface.Interface`.
    dispersion
        As in `alight.bsdfs.dielectrics.dispersion.Dispersive`.
    attenuation_color, attenuation_distance
        As in `alight.bsdfs.interiors.absorption.Absorbing`.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["dielectric"] = "dielectric"


EXAMPLES = (
    Dielectric(),
    Dielectric(int_ior="water", ext_ior="bk7"),
    Dielectric(int_ior="diamond", ext_ior="vacuum"),
    Dielectric(int_ior=1.0, ext_ior=1.0),
    Dielectric(dispersion="sf10"),
    Dielectric(specular_reflectance=(0.9, 0.6, 0.2), specular_transmittance=(0.3, 1.0, 0.8)),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_reciprocal(spec: Dielectric) -> bool:
    """f(wo, wi) / eta_o^2 = f(wi, wo) / eta_i^2, with the index on the side of each direction."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    eta: Index
    reflectance: Tint
    transmittance: Tint


SLOTS = slots_of(Params)
load = loader(Params)
inner_index = reader(Params, "eta")


def pack(spec: Dielectric, packer) -> None:
    """Fill the row of one material."""
    interface.pack(spec, packer)
    pack_spread(packer, spec.dispersion, spec.int_ior, spec.ext_ior)


def features(spec: Dielectric) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    glass = (
        interface.features(spec),
        dispersion_features(spec.dispersion),
        absorption_features(spec),
    )
    return tuple(name for names in glass for name in names)


# ---------------------------------------------------------------- scattering


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
