r"""Rough plastic: a matte base under a clear coat of tiny facets.

.. math::
    f(\omega_o, \omega_i) = \rho_s\, \frac{F(\omega_o \cdot \omega_m)\, D(\omega_m)\,
        G_1(\omega_o)\, G_1(\omega_i)}{4 \cos\theta_o \cos\theta_i}
        + \frac{T(\cos\theta_o)\, T(\cos\theta_i)}{\eta^2}\, \frac{\rho'}{\pi}

with T the part of light that enters the coat, and rho' the base with all rounds inside it (see
`alight.bsdfs.plastics.coating`). Light that meets two facets is lost (single scattering). One
smooth mixture of two lobes; black from behind.

Source: the plug-in ``roughplastic`` of Mitsuba 3 (https://mitsuba.readthedocs.io); Walter et al.
2007, Microfacet Models for Refraction through Rough Surfaces.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION
from alight.bsdfs.plastics.coating import (
    ROWS,
    base_f_cos,
    base_reflectance,
    chance_of_coat,
    coat_at,
    coat_internal,
    coat_table,
    coat_transmittance,
)
from alight.bsdfs.plastics.plastic import Coated, pack_coat
from alight.bsdfs.rows import MANY_ROWS, rows_in_slots
from alight.core.constants import INV_PI
from alight.core.field_types import SMOOTHEST, Roughness
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import (
    FEATURES,
    Facets,
    facet_density,
    sample_visible_facet,
    visible_area,
)
from alight.core.parameters import loader, slots_of
from alight.core.spec import Texture
from alight.core.vec import Vec3, dot, normalize, quotient, reflect
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import (
    Scalar,
    TexturedColor,
    TexturedScalar,
)
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, maximum, minimum, where


class RoughPlastic(Coated):
    """Satin plastic, painted wood, eggshell.

    Parameters
    ----------
    int_ior, ext_ior, diffuse_reflectance, specular_reflectance, nonlinear
        As in `alight.bsdfs.plastics.plastic.Coated`.
    distribution : {"ggx", "beckmann"}, default "ggx"
        Distribution of the facets' normals.
    alpha : Roughness, default 0.1
        Roughness of the coat, in [0.0001, 1].
    """

    one_sided: ClassVar[bool] = True
    type: Literal["rough_plastic"] = "rough_plastic"
    distribution: Literal["ggx", "beckmann"] = "ggx"
    alpha: Roughness = 0.1


EXAMPLES = (
    RoughPlastic(),
    RoughPlastic(diffuse_reflectance=1.0, nonlinear=True, alpha=0.3, distribution="beckmann"),
    RoughPlastic(int_ior="diamond", diffuse_reflectance=(0.9, 0.5, 0.1), alpha=1.0),
    RoughPlastic(int_ior=1.2, ext_ior=1.5, diffuse_reflectance=1.0, alpha=0.5),
    RoughPlastic(diffuse_reflectance=0.0, specular_reflectance=(0.9, 0.5, 0.1), alpha=0.2),
    RoughPlastic(diffuse_reflectance=0.7, specular_reflectance=0.0, nonlinear=True),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: RoughPlastic) -> bool:
    """Light between facets is lost."""
    return False


def is_reciprocal(spec: RoughPlastic) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Row(NamedTuple):
    """A row of the table."""

    diffuse: TexturedColor
    specular: TexturedColor
    eta: Scalar
    nonlinear: Scalar
    alpha: TexturedScalar
    beckmann: Scalar
    transmittances: Annotated[Any, rows_in_slots("transmittances")]


SLOTS = slots_of(Row)
_load_row = loader(Row)
Params = namedtuple("RoughPlasticParams", "base specular eta internal facets coat")


def pack(spec: RoughPlastic, packer) -> None:
    """Fill the row of one material."""
    pack_coat(spec, packer)
    packer.scalar("alpha", spec.alpha)
    packer.numbers("beckmann", float(spec.distribution == "beckmann"))
    alpha = packer.number("alpha")
    alpha = None if alpha is None else max(alpha, SMOOTHEST)
    table = coat_table(spec.distribution, alpha, spec.int_ior / spec.ext_ior)
    packer.curve("transmittances", table)
    packer.numbers("last_transmittances", 0 if alpha is not None else ROWS - 1)


def features(spec: RoughPlastic) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    facets = FEATURES[spec.distribution]
    return (facets, MANY_ROWS) if _is_textured(spec) else (facets,)


def _is_textured(spec: RoughPlastic) -> bool:
    return spec.alpha.varies if isinstance(spec.alpha, Texture) else isinstance(spec.alpha, str)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    row = _load_row(scene, base, surface)
    alpha = maximum(row.alpha, SMOOTHEST)
    coat = coat_at(row.transmittances, alpha)
    internal = coat_internal(coat)
    matte = base_reflectance(row.diffuse, internal, row.nonlinear)
    facets = Facets(alpha, alpha, row.beckmann)
    return Params(matte, row.specular, row.eta, internal, facets, coat)


# ---------------------------------------------------------------- scattering


@kernel
def _chance_of_coat(params, through):
    """Probability of sampling the coat's lobe, where the part T of the light enters."""
    return chance_of_coat(1.0 - through, params.specular, params.base * (1.0 - params.internal))


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # Below the surface, the overhead direction replaces it; the result is not used.
    up = Vec3(0.0, 0.0, 1.0)
    wo, wi = where(above, wo, up), where(above, wi, up)
    # The coat. The density D (wo . wm) / sigma of normals, over the Jacobian 4 (wo . wm).
    wm = normalize(wo + wi)
    density = 0.25 * facet_density(params.facets, wm) / visible_area(params.facets, wo)
    fresnel, _ = fresnel_dielectric(minimum(maximum(dot(wo, wm), 0.0), 1.0), params.eta)
    masking = wi.z / visible_area(params.facets, wi)
    # The base.
    through = coat_transmittance(params.coat, wo.z)
    both_ways = through * coat_transmittance(params.coat, wi.z)
    f_cos = params.specular * (fresnel * masking * density)
    f_cos = f_cos + base_f_cos(params.base, both_ways, params.eta, wi.z)
    chance = _chance_of_coat(params, through)
    pdf = chance * density + (1.0 - chance) * (INV_PI * wi.z)
    return where(above, f_cos, 0.0), where(above, pdf, 0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the two lobes, chosen by u."""
    chance = _chance_of_coat(params, coat_transmittance(params.coat, maximum(wo.z, 0.0)))
    glossy = normalize(reflect(wo, sample_visible_facet(params.facets, wo, u2)))
    wi = where(u < chance, glossy, square_to_cosine_hemisphere(u2))
    f_cos, pdf = evaluate(params, wo, wi)
    return wi, quotient(f_cos, pdf), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    through = coat_transmittance(params.coat, lanes(1.0))
    base = params.base * ((1.0 - params.internal) * through)
    return params.specular * (1.0 - through) + base
