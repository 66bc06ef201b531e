r"""Burley's thin sheet as Mitsuba has it: paper, leaves, panes and cloth that light comes through.

.. math::
    f_r &= t \frac{F D\, G}{4 \cos\theta_o \cos\theta_i}
        + (1 - t)(1 - d) \left[ \tfrac{\rho}{\pi} f_d + s\, c_s F_d \right], \\
    f_t &= t\, \rho \frac{(1 - F) D'\, G'}{4 \cos\theta_o |\cos\theta_i|}
        + (1 - t)\, d\, \tfrac{\rho}{\pi}

with the glass t, the part d of the rest that goes through, and the lobes of `burley`; what passes
is mirrored to the other side, by facets whose roughness is multiplied by 0.65 eta - 0.35. Both
sides are alike. Reciprocal.

**It creates energy**, as `burley` does: with base colour 1 and roughness 1 it returns 1.04, 1.03,
1.03, 1.06, 1.19 and 1.40 times the incident light at 0, 30, 45, 60, 75 and 85 degrees, and with
sheen up to 1.61 times.

Source: Burley 2015, Extending the Disney BRDF to a BSDF; the plug-in ``principledthin`` of
Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from alight.bsdfs.disney.burley import albedo as albedo
from alight.bsdfs.disney.burley import (
    burley_diffuse,
    burley_facets,
    burley_sheen,
    pack_burley,
    schlick_of_tint,
)
from alight.bsdfs.disney.burley import features as features
from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture, IndexOfRefraction, UnitTexture
from alight.core.frame import mirrored_if
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import ggx_density, ggx_visible_area, sample_ggx_visible
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, dot, lerp, normalize, quotient, reflect, renormalize
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import (
    Scalar,
    TexturedColor,
    TexturedScalar,
)
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, lanes_vec3, maximum, minimum, where

#: What a white sheet sends out at most of the light that it gets, measured.
MOST_SENT_OUT = 1.61


class BurleyThin(Bsdf):
    """Thin sheet of a scene made for Burley's model.

    Parameters
    ----------
    base_color : ColorTexture, default 0.5
        Colour of what is diffuse, and of what the sheet lets through.
    roughness, anisotropic : UnitTexture, defaults 0.5 and 0
        Root of alpha, and how far it differs by direction.
    spec_trans : UnitTexture, default 0
        Share of clear glass.
    through : UnitTexture, default 0
        The part of the diffuse light that goes through; half of Mitsuba's ``diff_trans``.
    spec_tint, sheen, sheen_tint, flatness : UnitTexture, defaults 0
        As in `burley`.
    ior : float in [1, 5], default 1.5
        Index of refraction.
    """

    transmissive = True
    type: Literal["burley_thin"] = "burley_thin"
    base_color: ColorTexture = (0.5, 0.5, 0.5)
    roughness: UnitTexture = 0.5
    anisotropic: UnitTexture = 0.0
    spec_trans: UnitTexture = 0.0
    through: UnitTexture = 0.0
    spec_tint: UnitTexture = 0.0
    sheen: UnitTexture = 0.0
    sheen_tint: UnitTexture = 0.0
    flatness: UnitTexture = 0.0
    ior: IndexOfRefraction = 1.5


EXAMPLES = (
    BurleyThin(through=0.3),
    BurleyThin(base_color=(0.9, 0.5, 0.1), spec_trans=0.7, anisotropic=0.5, ior=1.33),
    BurleyThin(base_color=0.4, through=0.7, sheen=0.4, sheen_tint=0.5, flatness=0.5),
    BurleyThin(base_color=0.6, spec_trans=1.0, spec_tint=0.5, roughness=0.7),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: BurleyThin) -> bool:
    """Light between facets is lost, and towards the rim more is sent out than comes in."""
    return False


def is_reciprocal(spec: BurleyThin) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


def relative_ior(spec: BurleyThin) -> float:
    """The medium on both sides is the same."""
    return 1.0


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    base_color: TexturedColor
    roughness: TexturedScalar
    anisotropic: TexturedScalar
    spec_trans: TexturedScalar
    through: TexturedScalar
    spec_tint: TexturedScalar
    sheen: TexturedScalar
    sheen_tint: TexturedScalar
    flatness: TexturedScalar
    eta: Scalar


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: BurleyThin, packer) -> None:
    """Fill the row of one material."""
    pack_burley(spec, packer)
    packer.numbers("eta", spec.ior)


# ---------------------------------------------------------------- scattering


@kernel
def _facets(params, passes):
    """Those that mirror, and where it passes those that let through."""
    wider = where(passes, 0.65 * params.eta - 0.35, 1.0)
    return burley_facets(wider * params.roughness, params.anisotropic)


@kernel
def _values(params, wo, wi):
    """(f cos theta_i, pdf) from above."""
    valid = (wo.z > 0.0) & (wi.z != 0.0)
    up = Vec3(0.0, 0.0, 1.0)
    wo, wi = where(valid, wo, up), where(valid, wi, up)
    reflects = wi.z > 0.0
    w = mirrored_if(~reflects, wi)
    wm = normalize(wo + w)
    cosine = minimum(maximum(dot(wo, wm), 0.0), 1.0)
    facets = _facets(params, ~reflects)
    density = 0.25 * ggx_density(facets, wm) / ggx_visible_area(facets, wo)
    # As Mitsuba has it: what passes must leave behind the facet that mirrors it.
    density = where(reflects | (dot(wi, wm) < 0.0), density, 0.0)
    masking = w.z / ggx_visible_area(facets, w)
    plain, _ = fresnel_dielectric(cosine, params.eta)
    colored = schlick_of_tint(params.base_color, params.eta, cosine)
    mirror = lerp(params.spec_tint, lanes_vec3(1.0) * plain, colored)
    clear = where(reflects, mirror, params.base_color * (1.0 - plain)) * params.spec_trans
    f_cos = clear * (masking * density)
    rest = 1.0 - params.spec_trans
    diffuse = burley_diffuse(params.roughness, params.flatness, wo.z, w.z, cosine)
    sheen = burley_sheen(params.base_color, params.sheen, params.sheen_tint, cosine)
    back = (params.base_color * (INV_PI * diffuse) + sheen) * (1.0 - params.through)
    through = params.base_color * (INV_PI * params.through)
    f_cos = f_cos + where(reflects, back, through) * (rest * w.z)
    share = where(reflects, 1.0 - params.through, params.through)
    pdf = 0.5 * params.spec_trans * density + rest * share * INV_PI * w.z
    return where(valid, f_cos, 0.0), where(valid, pdf, 0.0)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    below = wo.z < 0.0
    return _values(params, mirrored_if(below, wo), mirrored_if(below, wi))


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the lobes, chosen by u."""
    below = wo.z < 0.0
    wo = mirrored_if(below, wo)
    clear = u < params.spec_trans
    # Which of both sides: half of the clear light, and the stated part of the rest.
    matte = (u - params.spec_trans) / maximum(1.0 - params.spec_trans, 1e-9)
    passes = where(clear, u, 0.0) >= 0.5 * params.spec_trans
    passes = (clear & passes) | (~clear & (matte < params.through))
    facets = _facets(params, passes)
    w = renormalize(reflect(wo, sample_ggx_visible(facets, wo, u2)))
    w = where(clear, w, square_to_cosine_hemisphere(u2))
    # Light that its facet sends below the surface is lost.
    w = where(w.z > 0.0, w, Vec3(1.0, 0.0, 0.0))
    wi = mirrored_if(passes, w)
    f_cos, pdf = _values(params, wo, wi)
    flags = where(passes, lanes_u32(TRANSMISSION), lanes_u32(REFLECTION))
    return mirrored_if(below, wi), quotient(f_cos, pdf), pdf, flags
