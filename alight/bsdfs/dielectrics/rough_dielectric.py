r"""Rough dielectric (ground glass): facets that reflect and refract, with masking and shadowing.

.. math::
    f_r(\omega_o, \omega_i) &= \frac{F D\, G_1(\omega_o) G_1(\omega_i)}
        {4 \cos\theta_o \cos\theta_i}, &
    \omega_m &\propto \omega_o + \omega_i, \\
    f_t(\omega_o, \omega_i) &= \frac{(1 - F) D\, G_1(\omega_o) G_1(\omega_i)\,
        |\omega_o \cdot \omega_m|\, |\omega_i \cdot \omega_m|}
        {|\cos\theta_o|\, |\cos\theta_i|\,
        (\omega_o \cdot \omega_m + \eta\, \omega_i \cdot \omega_m)^2}, &
    \omega_m &\propto \omega_o + \eta\, \omega_i

eta is the index beyond the surface over the one on wo's side; f_t contains the factor eta^2 of the
Jacobian of refraction and the 1 / eta^2 of radiance. Facets are sampled in proportion to how large
they are seen, then reflect with probability F; weight = G1(wi), in refraction / eta^2. Beyond a
facet's critical angle F = 1: total internal reflection. Light that meets two facets is lost (single
scattering).

Source: Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces, equations 16,
17, 20 and 21; Heitz and d'Eon 2014 for the sampling; PBR4 section 9.7.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, Self

from pydantic import model_validator

from alight.bsdfs.dielectrics import interface
from alight.bsdfs.dielectrics.dispersion import Dispersive, Index, dispersion_features, pack_spread
from alight.bsdfs.dielectrics.interface import albedo as albedo
from alight.bsdfs.dielectrics.interface import relative_ior as relative_ior
from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.bsdfs.interiors.absorption import Absorbing, absorption_features
from alight.bsdfs.microfacets.facets import (
    FacetsOfRow,
    Rough,
    facet_features,
    pack_facets,
)
from alight.bsdfs.tints import Tint
from alight.core.fields import invalid
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import facet_density, sample_visible_facet, visible_area
from alight.core.parameters import loader, reader, slots_of
from alight.core.vec import Vec3, dot, normalize, reflect, renormalize
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes_u32, maximum, where

#: Both indices differ by at least this part: the facet that refracts is found from how far.
LEAST_DIFFERENCE = 1e-3


class RoughDielectric(Dispersive, Rough, Absorbing):
    """Frosted glass, ice, ground crystals.

    Parameters
    ----------
    int_ior, ext_ior, specular_reflectance, specular_transmittance
        As in `alight.bsdfs.dielectrics.interface.Interface`; the indices differ by at least 0.1 %.
    distribution, alpha, alpha_u, alpha_v
        As in `alight.bsdfs.microfacets.facets.Rough`.
    dispersion
        As in `alight.bsdfs.dielectrics.dispersion.Dispersive`.
    attenuation_color, attenuation_distance
        As in `alight.bsdfs.interiors.absorption.Absorbing`.
    """

    type: Literal["rough_dielectric"] = "rough_dielectric"

    @model_validator(mode="after")
    def _refracts(self) -> Self:
        low, high = (index / self.ext_ior - 1.0 for index in self.extreme_indices)
        if low < LEAST_DIFFERENCE and high > -LEAST_DIFFERENCE:
            given = f"{self.int_ior:g} and {self.ext_ior:g}"
            text = "int_ior and ext_ior must differ by at least 0.1 %"
            raise invalid(f"{text}, got {given}; equal media are of type dielectric or null")
        return self


EXAMPLES = (
    RoughDielectric(int_ior="sapphire", alpha=0.3),
    RoughDielectric(int_ior=1.5, ext_ior=1.0, distribution="beckmann", alpha=0.5),
    RoughDielectric(int_ior="water", ext_ior="bk7", distribution="beckmann", alpha=0.9),
    RoughDielectric(int_ior="diamond", ext_ior="vacuum", alpha_u=0.2, alpha_v=0.7),
    RoughDielectric(
        distribution="beckmann",
        alpha=1.0,
        specular_reflectance=(0.9, 0.6, 0.2),
        specular_transmittance=(0.3, 1.0, 0.8),
    ),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: RoughDielectric) -> bool:
    """Never: light that would meet a second facet is lost."""
    return False


def is_reciprocal(spec: RoughDielectric) -> bool:
    """f(wo, wi) / eta_o^2 = f(wi, wo) / eta_i^2, with the index on the side of each direction."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    eta: Index
    reflectance: Tint
    transmittance: Tint
    facets: FacetsOfRow


SLOTS = slots_of(Params)
load = loader(Params)
inner_index = reader(Params, "eta")


def pack(spec: RoughDielectric, packer) -> None:
    """Fill the row of one material."""
    interface.pack(spec, packer)
    pack_spread(packer, spec.dispersion, spec.int_ior, spec.ext_ior)
    pack_facets(spec, packer)


def features(spec: RoughDielectric) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    glass = (
        interface.features(spec), dispersion_features(spec.dispersion), facet_features(spec),
        absorption_features(spec),
    )  # fmt: skip
    return tuple(name for names in glass for name in names)


# ---------------------------------------------------------------- scattering


@kernel
def _scatter(params, eta, wo, wi):
    """(f cos theta_i / pdf, pdf per steradian) for wo above the surface, wi anywhere."""
    reflects = wi.z > 0.0
    # The facet's normal, turned to the side of wo: refraction bends towards the denser side.
    wm = wo + where(reflects, 1.0, eta) * wi
    wm = normalize(where(wm.z < 0.0, -wm, wm))
    cos_o, cos_i = dot(wo, wm), dot(wi, wm)
    fresnel, _ = fresnel_dielectric(maximum(cos_o, 0.0), eta)
    # Density of wi over that of wm: the Jacobian of reflection (cos_o cancels), or of refraction.
    projected = cos_o + eta * cos_i
    stretched = eta / where(projected == 0.0, 1.0, projected)
    refracted = (fresnel - 1.0) * cos_o * cos_i * (stretched * stretched)
    jacobian = where(reflects, 0.25 * fresnel, refracted)
    pdf = jacobian * facet_density(params.facets, wm) / visible_area(params.facets, wo)
    # Facets are seen from their outer side by wo, and by wi if it leaves on the right side.
    turned = (reflects & (cos_i > 0.0)) | ((wi.z < 0.0) & (cos_i < 0.0))
    valid = (wo.z > 0.0) & (cos_o > 0.0) & turned
    masking = absolute(wi.z) / visible_area(params.facets, wi)
    weight = params.reflectance * masking
    # Radiance falls by 1 / eta^2 as the beam fans out.
    passed = params.transmittance * (masking / (eta * eta))
    return where(reflects, weight, passed) * where(valid, 1.0, 0.0), where(valid, pdf, 0.0)


@kernel
def _turned(mask, w):
    """-w where the mask holds: seen from below, the surface is turned over."""
    return where(mask, -w, w)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    below = wo.z < 0.0
    eta = where(below, 1.0 / params.eta, params.eta)
    weight, pdf = _scatter(params, eta, _turned(below, wo), _turned(below, wi))
    return weight * pdf, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    below = wo.z < 0.0
    eta = where(below, 1.0 / params.eta, params.eta)
    wo = _turned(below, wo)
    wm = sample_visible_facet(params.facets, wo, u2)
    cos_o = maximum(dot(wo, wm), 0.0)
    fresnel, cos_t = fresnel_dielectric(cos_o, eta)
    reflects = u < fresnel
    # Along the facet wo shrinks by 1 / eta, which is Snell's law.
    refracted = (cos_o / eta - cos_t) * wm - wo / eta
    wi = renormalize(where(reflects, reflect(wo, wm), refracted))
    # On the wrong side of the surface it would be taken for the other lobe; in the surface it has
    # neither density nor weight.
    above = wi.z > 0.0
    right = (above & reflects) | (~above & ~reflects)
    wi = where(right, wi, Vec3(1.0, 0.0, 0.0))
    weight, pdf = _scatter(params, eta, wo, wi)
    flags = where(reflects, lanes_u32(REFLECTION), lanes_u32(TRANSMISSION))
    return _turned(below, wi), weight, pdf, flags
