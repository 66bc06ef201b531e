r"""Rough metal: facets that reflect by Fresnel's equations, with masking and shadowing.

.. math::
    f(\omega_o, \omega_i) = \rho \frac{F(\omega_o \cdot \omega_m)\, D(\omega_m)\,
        G_1(\omega_o)\, G_1(\omega_i)}{4 \cos\theta_o \cos\theta_i}, \qquad
    \omega_m = \frac{\omega_o + \omega_i}{|\omega_o + \omega_i|}

with D by GGX or Beckmann, isotropic or not. Facets are sampled in proportion to how large they are
seen from wo; then all but F and one G1 cancel: weight = rho F G1(wi). Light that meets two facets
is lost (single scattering), so rough surfaces are a little too dark. Black from behind.

Source: Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces, equation 20;
Heitz and d'Eon 2014 for the sampling; PBR4 section 9.6.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.conductors.conductor import Metallic, pack_metal
from alight.bsdfs.flags import REFLECTION
from alight.bsdfs.microfacets.facets import FacetsOfRow, Rough, facet_features, pack_facets
from alight.bsdfs.tints import Tint, tint_features
from alight.core.fresnel import fresnel_conductor
from alight.core.microfacet import facet_density, sample_visible_facet, visible_area
from alight.core.parameters import loader, slots_of
from alight.core.spec import largest_channel
from alight.core.vec import Vec3, dot, normalize, reflect, renormalize
from alight.textures.fetch import PlainColor
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, where


class RoughConductor(Metallic, Rough):
    """Brushed, sandblasted or worn metal.

    Parameters
    ----------
    metal, eta, k, specular_reflectance
        As in `alight.bsdfs.conductors.conductor.Metallic`.
    distribution, alpha, alpha_u, alpha_v
        As in `alight.bsdfs.microfacets.facets.Rough`.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["rough_conductor"] = "rough_conductor"

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions."""
        # Fresnel's factor and the masking of visible facets are 1 at most.
        return largest_channel(self.specular_reflectance)


EXAMPLES = (
    RoughConductor(alpha=0.3),
    RoughConductor(metal="silver", distribution="beckmann", alpha=0.5),
    RoughConductor(metal="copper", alpha=1.0, specular_reflectance=(0.9, 0.8, 0.3)),
    RoughConductor(metal="tungsten", alpha_u=0.15, alpha_v=0.6),
    RoughConductor(eta=1.5, k=0.0, distribution="beckmann", alpha_u=0.7, alpha_v=0.3),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: RoughConductor) -> bool:
    """Every real metal absorbs what it does not reflect."""
    return False


def is_reciprocal(spec: RoughConductor) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    eta: PlainColor
    k: PlainColor
    tint: Tint
    facets: FacetsOfRow


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: RoughConductor, packer) -> None:
    """Fill the row of one material."""
    pack_metal(spec, packer)
    pack_facets(spec, packer)


def features(spec: RoughConductor) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return (*tint_features(spec.specular_reflectance), *facet_features(spec))


# ---------------------------------------------------------------- scattering


@kernel
def _scatter(params, wo, wi):
    """(f cos theta_i / pdf, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # Below the surface, the overhead direction replaces it; the result is not used.
    wo, wi = where(above, wo, Vec3(0.0, 0.0, 1.0)), where(above, wi, Vec3(0.0, 0.0, 1.0))
    wm = normalize(wo + wi)
    # The density D (wo . wm) / sigma of normals, over the Jacobian 4 (wo . wm) of reflection.
    pdf = 0.25 * facet_density(params.facets, wm) / visible_area(params.facets, wo)
    masking = wi.z / visible_area(params.facets, wi)
    fresnel = fresnel_conductor(dot(wo, wm), params.eta, params.k)
    return params.tint * fresnel * where(above, masking, 0.0), where(above, pdf, 0.0)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    weight, pdf = _scatter(params, wo, wi)
    return weight * pdf, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    wi = renormalize(reflect(wo, sample_visible_facet(params.facets, wo, u2)))
    # The facet is found again from wi: rounding of narrow lobes would tell the densities apart.
    weight, pdf = _scatter(params, wo, wi)
    return wi, weight, pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles, as if the metal were smooth."""
    return params.tint * fresnel_conductor(lanes(1.0), params.eta, params.k)
