r"""Burley's principled material as in Mitsuba, for scenes made for it.

.. math::
    f &= (1 - m)(1 - t) \left[ \tfrac{\rho}{\pi} f_d \right] + (1 - m)\, s\, c_s F_d
        + \frac{F D\, G}{4 \cos\theta_o \cos\theta_i} + (1 - m)\, t \sqrt\rho\, f_t
        + \tfrac{c}{4} F_c D_c G_c

with the metal m, glass t, sheen s and coat c, :math:`F_d = (1 - \cos\theta_d)^5`, and Burley's
diffuse law f_d with its bright rim of rough surfaces, which `flatness` turns towards one of skin.
F mixes Fresnel's equations with Schlick's term of the metal and of a tinted plastic; D and G are
GGX with alpha = roughness^2, along the tangent divided by
:math:`\sqrt{1 - 0.9\, \text{anisotropic}}` and across multiplied by it; f_t is as in
`rough_dielectric`; the coat's D_c is GTR1 of the roughness 0.1 to 0.001, its G_c of 0.25 always.

**It creates energy.** Specular reflection is not taken from the diffuse part, the bright rim of
rough surfaces comes on top of it, and so does sheen; energy is lost only between facets. In an
environment of radiance 1, a surface of base colour 1 should reflect at most 1. Measured, from
normal to grazing incidence:

| base colour 1, else the defaults and | 0° | 30° | 45° | 60° | 75° | 85° |
|---|---|---|---|---|---|---|
| roughness 0 | 1.02 | 1.02 | 1.02 | 1.05 | 1.12 | 1.28 |
| roughness 0.25 | 1.03 | 1.03 | 1.04 | 1.07 | 1.17 | 1.24 |
| roughness 0.5 | 1.04 | 1.05 | 1.05 | 1.07 | 1.14 | 1.19 |
| roughness 0.75 | 1.05 | 1.05 | 1.05 | 1.07 | 1.16 | 1.29 |
| roughness 1 | 1.05 | 1.05 | 1.05 | 1.08 | 1.22 | 1.44 |
| flatness 1 | 0.79 | 0.86 | 0.96 | 1.15 | 1.39 | 1.42 |
| sheen 1 | 1.04 | 1.05 | 1.06 | 1.09 | 1.18 | 1.25 |
| clearcoat 1 | 1.07 | 1.07 | 1.07 | 1.09 | 1.15 | 1.19 |
| metallic 1 | 0.92 | 0.90 | 0.89 | 0.86 | 0.83 | 0.86 |

Combined, and closer to grazing, it reaches 1.73. White walls of it grow brighter with each bounce;
those of `principled` do not. Mitsuba's model behaves the same way. Reciprocal. Black from behind,
except for glass.

Source: Burley 2012 and 2015, Physically Based Shading at Disney; the plug-in ``principled`` of
Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture, IndexOfRefraction, UnitTexture
from alight.core.frame import mirrored_if
from alight.core.fresnel import fresnel_dielectric, fresnel_schlick
from alight.core.maths import exp, log, sincos_2pi
from alight.core.microfacet import Facets, ggx_density, ggx_visible_area, sample_ggx_visible
from alight.core.parameters import loader, reader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, dot, lerp, luminance, normalize, quotient, reflect, renormalize
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import (
    Scalar,
    TexturedColor,
    TexturedScalar,
)
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes, lanes_u32, lanes_vec3, maximum, minimum, sqrt, where

#: Glass has at least this index: the facet that refracts is found from it.
LEAST_IOR = 1.001
LEAST_ALPHA = 1e-3
#: What a white surface sends out at most of the light that it gets, measured.
MOST_SENT_OUT = 1.73


class Burley(Bsdf):
    """Material of a scene made for Burley's model.

    Parameters
    ----------
    base_color : ColorTexture, default 0.5
        Colour of what is diffuse, of the metal, and the square of that of glass.
    metallic, spec_trans : UnitTexture, defaults 0
        Share of metal, and of glass in what is not metal.
    roughness, anisotropic : UnitTexture, defaults 0.5 and 0
        Root of alpha, and how far it differs by direction.
    spec_tint, sheen, sheen_tint, flatness : UnitTexture, defaults 0
        Tint of what plastic reflects, strength and tint of the sheen, share of the flat law.
    clearcoat, clearcoat_gloss : UnitTexture, defaults 0
        Strength of the coat and how smooth it is.
    ior : float in [1, 5], default 1.5
        Index of refraction; glass has at least 1.001.
    """

    type: Literal["burley"] = "burley"
    base_color: ColorTexture = (0.5, 0.5, 0.5)
    metallic: UnitTexture = 0.0
    roughness: UnitTexture = 0.5
    anisotropic: UnitTexture = 0.0
    spec_trans: UnitTexture = 0.0
    spec_tint: UnitTexture = 0.0
    sheen: UnitTexture = 0.0
    sheen_tint: UnitTexture = 0.0
    flatness: UnitTexture = 0.0
    clearcoat: UnitTexture = 0.0
    clearcoat_gloss: UnitTexture = 0.0
    ior: IndexOfRefraction = 1.5

    @property
    def transmissive(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether it has two sides already."""
        return self.spec_trans != 0.0


EXAMPLES = (
    Burley(),
    Burley(base_color=(0.9, 0.5, 0.1), metallic=1.0, roughness=0.6, anisotropic=0.7),
    Burley(base_color=0.4, roughness=0.8, sheen=0.3, sheen_tint=0.5, flatness=0.5, spec_tint=0.4),
    Burley(base_color=(0.6, 0.3, 0.2), clearcoat=1.0, clearcoat_gloss=0.1, metallic=0.3),
    Burley(base_color=(0.9, 1.0, 0.8), spec_trans=0.8, roughness=0.6, metallic=0.2),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Burley) -> bool:
    """Light between facets is lost, and towards the rim more is sent out than comes in."""
    return False


def is_reciprocal(spec: Burley) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


def relative_ior(spec: Burley) -> float:
    """Index inside over that outside."""
    return max(spec.ior, LEAST_IOR) if spec.transmissive else spec.ior


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    base_color: TexturedColor
    metallic: TexturedScalar
    roughness: TexturedScalar
    anisotropic: TexturedScalar
    spec_trans: TexturedScalar
    spec_tint: TexturedScalar
    sheen: TexturedScalar
    sheen_tint: TexturedScalar
    flatness: TexturedScalar
    clearcoat: TexturedScalar
    clearcoat_gloss: TexturedScalar
    eta: Scalar


SLOTS = slots_of(Params)
load = loader(Params)
_eta, _spec_trans = reader(Params, "eta"), reader(Params, "spec_trans")


def pack(spec: Burley, packer) -> None:
    """Fill the row of one material."""
    pack_burley(spec, packer)
    packer.numbers("eta", relative_ior(spec))


def pack_burley(spec, packer) -> None:
    """Fill the slots of the colour and of what may be textured, here and in the thin sheet."""
    packer.color("base_color", spec.base_color)
    for name, value in spec:
        if name in packer.slots and name != "base_color":
            packer.scalar(name, value)


def features(spec) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return () if spec.anisotropic == 0.0 else (ANISOTROPIC,)


@kernel
def burley_facets(roughness, anisotropic):
    """GGX with alpha = roughness^2, stretched along the tangent."""
    alpha, aspect = roughness * roughness, sqrt(1.0 - 0.9 * minimum(anisotropic, 1.0))
    along, across = maximum(alpha / aspect, LEAST_ALPHA), maximum(alpha * aspect, LEAST_ALPHA)
    return Facets(along, across, lanes(0.0))


@kernel
def inner_index(scene, base, surface):
    """Index inside over that outside, where there is glass."""
    return where(_spec_trans(scene, base, surface) > 0.0, _eta(scene, base, surface), 1.0)


# ---------------------------------------------------------------- parts, shared with the thin sheet


@kernel
def schlick_weight(cosine):
    """(1 - cos)^5."""
    return fresnel_schlick(cosine, lanes(0.0))


@kernel
def tinted(base):
    """The colour with luminance 1; white where it is black."""
    y = luminance(base)
    return where(y > 0.0, base / where(y > 0.0, y, 1.0), lanes_vec3(1.0))


@kernel
def schlick_of_tint(base, eta, cosine):
    """Schlick's term from the tinted reflectance at the normal."""
    root = (eta - 1.0) / (eta + 1.0)
    return lerp(schlick_weight(cosine), tinted(base) * (root * root), lanes_vec3(1.0))


@kernel
def burley_diffuse(roughness, flatness, cos_o, cos_i, cos_d):
    """pi f / rho of the diffuse part, for cosines above the surface; cos_d: to the half vector."""
    o, i = schlick_weight(cos_o), schlick_weight(cos_i)
    smooth = (1.0 - 0.5 * o) * (1.0 - 0.5 * i)
    rough = 2.0 * roughness * cos_d * cos_d
    retro = rough * (o + i + o * i * (rough - 1.0))
    rim = 0.5 * rough
    flat = lerp(o, 1.0, rim) * lerp(i, 1.0, rim)
    flat = 1.25 * (flat * (1.0 / maximum(cos_o + cos_i, 1e-6) - 0.5) + 0.5)
    return lerp(flatness, smooth + retro, flat)


@kernel
def burley_sheen(base, sheen, tint, cos_d):
    """f of the sheen."""
    return lerp(tint, lanes_vec3(1.0), tinted(base)) * (sheen * schlick_weight(cos_d))


# ---------------------------------------------------------------- scattering


@kernel
def _gtr1(gloss, cos_h):
    """(D, alpha^2) of the coat."""
    alpha = lerp(gloss, 0.1, 0.001)
    squared = alpha * alpha
    below = 1.0 + (squared - 1.0) * cos_h * cos_h
    return INV_PI * (squared - 1.0) / (log(squared) * below), squared


@kernel
def _smith(w):
    """G1 of GGX with alpha = 0.25."""
    z2 = maximum(w.z * w.z, 1e-18)
    return 2.0 / (1.0 + sqrt(1.0 + 0.0625 * maximum(1.0 - z2, 0.0) / z2))


@kernel
def _chances(params, inside):
    """Probabilities of the facets, the coat and the diffuse part."""
    matte = (1.0 - params.metallic) * (1.0 - params.spec_trans)
    coat = where(inside, 0.0, 0.25 * params.clearcoat)
    matte = where(inside, 0.0, matte)
    per = 1.0 / (1.0 + coat + matte)
    return per, coat * per, matte * per


@kernel
def _chance_of_reflection(params, inside, fresnel):
    """Probability of reflection at a facet."""
    clear = (1.0 - params.metallic) * params.spec_trans
    return where(inside, fresnel, 1.0 - clear * (1.0 - fresnel))


@kernel
def _values(params, inside, wo, wi):
    """(f cos theta_i, pdf) from above, wi mirrored as wo was."""
    facets = burley_facets(params.roughness, params.anisotropic)
    eta = where(inside, 1.0 / params.eta, params.eta)
    rest = 1.0 - params.metallic
    clear, matte = rest * params.spec_trans, rest * (1.0 - params.spec_trans)
    valid = (wo.z > 0.0) & (wi.z != 0.0) & (~inside | (clear > 0.0))
    up = Vec3(0.0, 0.0, 1.0)
    wo, wi = where(valid, wo, up), where(valid, wi, up)
    reflects = wi.z > 0.0
    wm = wo + where(reflects, 1.0, eta) * wi
    wm = normalize(where(wm.z < 0.0, -wm, wm))
    cos_o, cos_i = dot(wo, wm), dot(wi, wm)
    cosine = minimum(maximum(cos_o, 0.0), 1.0)
    plain, _ = fresnel_dielectric(cosine, eta)
    metal = lerp(schlick_weight(cosine), params.base_color, lanes_vec3(1.0))
    colored = schlick_of_tint(params.base_color, params.eta, cosine)
    fresnel = metal * params.metallic + colored * (rest * params.spec_tint)
    fresnel = fresnel + rest * (1.0 - params.spec_tint) * plain
    fresnel = where(inside, lanes_vec3(1.0) * (clear * plain), fresnel)
    # Density of wi over that of wm, as in `alight.bsdfs.dielectrics.rough_dielectric`.
    projected = cos_o + eta * cos_i
    stretched = eta / where(projected == 0.0, 1.0, projected)
    jacobian = where(reflects, 0.25, -cos_o * cos_i * (stretched * stretched))
    density = jacobian * ggx_density(facets, wm) / ggx_visible_area(facets, wo)
    right = (reflects & (cos_i > 0.0)) | (~reflects & (cos_i < 0.0) & (clear > 0.0))
    right = right & (cos_o > 0.0)
    density = where(right, density, 0.0)
    masking = absolute(wi.z) / ggx_visible_area(facets, wi)
    base = params.base_color
    root = Vec3(sqrt(base.x), sqrt(base.y), sqrt(base.z)) * (clear * (1.0 - plain) / (eta * eta))
    f_cos = where(reflects, fresnel, root) * (masking * density)
    # What only the outside has.
    outside = reflects & ~inside
    diffuse = burley_diffuse(params.roughness, params.flatness, wo.z, wi.z, cos_i)
    both = base * (matte * INV_PI * diffuse)
    sheen = burley_sheen(base, params.sheen * rest, params.sheen_tint, cos_i)
    both = both + where(matte > 0.0, sheen, lanes_vec3(0.0))
    d, _ = _gtr1(params.clearcoat_gloss, wm.z)
    schlick = fresnel_schlick(cosine, lanes(0.04))
    coat = 0.25 * params.clearcoat * schlick * d * _smith(wo) * _smith(wi)
    coat = where(right, coat, 0.0)
    f_cos = f_cos + where(outside, (both + coat) * wi.z, lanes_vec3(0.0))
    to_facets, to_coat, to_matte = _chances(params, inside)
    chance = _chance_of_reflection(params, inside, plain)
    pdf = to_facets * density * where(reflects, chance, 1.0 - chance)
    coat_pdf = where(right, 0.25 * d * wm.z / maximum(cos_o, 1e-9), 0.0)
    others = to_coat * coat_pdf + to_matte * INV_PI * wi.z
    pdf = pdf + where(outside, others, 0.0)
    return where(valid, f_cos, 0.0), where(valid, pdf, 0.0)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    inside = (wo.z < 0.0) & (params.spec_trans > 0.0)
    return _values(params, inside, mirrored_if(inside, wo), mirrored_if(inside, wi))


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the lobes, chosen by u."""
    inside = (wo.z < 0.0) & (params.spec_trans > 0.0)
    wo = mirrored_if(inside, wo)
    eta = where(inside, 1.0 / params.eta, params.eta)
    to_facets, to_coat, _ = _chances(params, inside)
    facets, coat = u < to_facets, (u >= to_facets) & (u < to_facets + to_coat)
    wm = sample_ggx_visible(burley_facets(params.roughness, params.anisotropic), wo, u2)
    # The coat's normals have the density D cos theta.
    _, squared = _gtr1(params.clearcoat_gloss, lanes(1.0))
    height2 = (1.0 - exp(log(squared) * (1.0 - u2[1]))) / (1.0 - squared)
    flat = sqrt(maximum(1.0 - height2, 0.0))
    s, c = sincos_2pi(u2[0])
    wm = where(coat, Vec3(flat * c, flat * s, sqrt(maximum(height2, 0.0))), wm)
    cos_o = dot(wo, wm)
    cosine = minimum(maximum(cos_o, 0.0), 1.0)
    plain, cos_t = fresnel_dielectric(cosine, eta)
    # At total internal reflection the chance of it is 1: what rounding still lets pass has pdf 0.
    passes = facets & (u / to_facets >= _chance_of_reflection(params, inside, plain))
    refracted = (cosine / eta - cos_t) * wm - wo / eta
    wi = renormalize(where(passes, refracted, reflect(wo, wm)))
    wi = where(facets | coat, wi, square_to_cosine_hemisphere(u2))
    # On the wrong side it would be taken for the other lobe.
    above = wi.z > 0.0
    right = (above & ~passes) | (~above & passes)
    wi = where(right, wi, Vec3(1.0, 0.0, 0.0))
    f_cos, pdf = _values(params, inside, wo, wi)
    flags = where(passes, lanes_u32(TRANSMISSION), lanes_u32(REFLECTION))
    return mirrored_if(inside, wi), quotient(f_cos, pdf), pdf, flags


@kernel
def albedo(params):
    """A colour, without light and angle."""
    return params.base_color
