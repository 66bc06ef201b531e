r"""Coated metal: rough or polished metal under a rough or smooth clear coat.

.. math::
    f(\omega_o, \omega_i) = \frac{F(\omega_o \cdot \omega_m)\, D_c(\omega_m)\, G_c}
        {4 \cos\theta_o \cos\theta_i} + s(\cos\theta_o)\, s(\cos\theta_i)\,
        \frac{D(\omega_m')\, G}{4 \eta^2 \cos\theta_o' \cos\theta_i'}

The first term is reflection by the coat, the second the metal's lobe: primed directions are
refracted into the coat, of relative index eta, as if it were smooth, and D is a little wider than
the metal's own, by what a rough coat scatters on the way in and out. Light bounces back and forth
between the layers and is coloured by the metal each time. How much of it finally leaves is known,
see `alight.bsdfs.microfacets.layered`; the scales s, one for each channel, give the lobe just that
albedo from every side, within 0.002 (within 0.01 in the last degree above the surface). Its
distribution is nearly right under smooth coats, and too narrow at grazing angles under rough ones.

All facets are GGX, of correlated heights, G = 1 / (1 + Lambda_o + Lambda_i), as in pbrt 4. Light
that meets two facets of a layer is lost (single scattering). Black from behind.

Source: the albedo is that of Guo, Hasan and Zhao 2018, Position-Free Monte Carlo Simulation for
Arbitrary Layered BSDFs, which pbrt 4 walks at random (PBR4 section 14.3); Belcour 2018, Efficient
Rendering of Layered Materials using an Atomic Decomposition with Statistical Operators, for one
lobe with the widths of several layers.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import model_validator

from alight.bsdfs.conductors.conductor import OfMetal
from alight.bsdfs.dielectrics.interface import MEDIA, Medium
from alight.bsdfs.flags import REFLECTION
from alight.bsdfs.microfacets.albedo_rows import LEAST_ALPHA, STEPS
from alight.bsdfs.microfacets.albedo_table import place_of, read_plain_curve
from alight.bsdfs.microfacets.layered import CHANCE, CURVES, SCALE, Layers, lobe_alpha, rounds
from alight.bsdfs.rows import rows_at, rows_in_slots
from alight.core.constants import INV_PI
from alight.core.fields import Interval, invalid
from alight.core.fresnel import cos_transmitted, fresnel_dielectric
from alight.core.microfacet import Facets, ggx_density, ggx_visible_area, sample_ggx_visible
from alight.core.parameters import loader, slots_of
from alight.core.vec import Vec3, dot, normalize, quotient, reflect, renormalize
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import PlainColor, Scalar
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, maximum, minimum, sqrt, where

Alpha = Annotated[float, Interval(LEAST_ALPHA, 1.0)]


class CoatedConductor(OfMetal):
    """Lacquered or varnished metal.

    Parameters
    ----------
    metal, eta, k
        As in `alight.bsdfs.conductors.conductor.OfMetal`: relative to vacuum; the coat is accounted
        for.
    int_ior, ext_ior : float in [1, 5] or str, defaults "acrylic" (1.49) and "air"
        Indices of refraction of the coat and outside, which is the lesser one.
    alpha : float, default 0.1
        Roughness of the metal, in [0.001, 1]; at 0.001 its albedo is that of a mirror.
    coat_alpha : float, default 0.001
        Roughness of the coat, likewise.
    thickness : float, default 0
        Optical thickness of the coat at normal incidence, >= 0: the part exp(-thickness) of the
        light passes from layer to layer.
    bounces : int in [1, 1000], default 100
        How many times light may hit the metal.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["coated_conductor"] = "coated_conductor"
    int_ior: Medium = MEDIA["acrylic"]
    ext_ior: Medium = MEDIA["air"]
    alpha: Alpha = 0.1
    coat_alpha: Alpha = LEAST_ALPHA
    thickness: Annotated[float, Interval(0.0, 1e3)] = 0.0
    bounces: Annotated[int, Interval(1, 1000, integer=True)] = 100

    @model_validator(mode="after")
    def _coat_is_denser(self) -> Self:
        if self.int_ior < LEAST_RATIO * self.ext_ior:
            least = LEAST_RATIO * self.ext_ior
            raise invalid(f"int_ior must be >= {least:.6g}, more than outside, got {self.int_ior}")
        return self


#: Index of the coat over that outside, at least.
LEAST_RATIO = 1.01

EXAMPLES = (
    CoatedConductor(coat_alpha=0.12),
    CoatedConductor(metal="copper", alpha=0.3, coat_alpha=0.3, int_ior=1.5),
    CoatedConductor(metal="silver", alpha=1.0, coat_alpha=0.2, int_ior="water"),
    CoatedConductor(eta=(0.2, 1.0, 3.0), k=(9.0, 2.0, 0.0), int_ior="diamond", coat_alpha=0.8),
    CoatedConductor(eta=1e-3, k=5.0, int_ior=1.0101, ext_ior=1.0, alpha=0.2, coat_alpha=0.1,
                    thickness=0.1, bounces=5),
)  # fmt: skip


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: CoatedConductor) -> bool:
    """Every real metal absorbs what it does not reflect."""
    return False


def is_reciprocal(spec: CoatedConductor) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Row(NamedTuple):
    """A row of the table."""

    eta: Scalar
    coat_alpha: Scalar
    alpha: Scalar
    wide: Scalar
    color: PlainColor
    rounds: Annotated[Any, rows_in_slots("rounds")]


SLOTS = slots_of(Row)
_load_row = loader(Row)
#: eta: of the coat over that outside; coat, metal: facets; wide: of the samples that are not the
#: coat's, the part for which the lobe is too wide; rows: see `alight.bsdfs.microfacets.layered`.
Params = namedtuple("CoatedConductorParams", "eta coat metal wide color rows")


def layers_of(spec: CoatedConductor) -> Layers:
    """The layers, each with its index over that of the one above."""
    eta, k = spec.index_of_refraction
    eta, k = ((x / spec.int_ior, y / spec.int_ior, z / spec.int_ior) for x, y, z in (eta, k))
    ior = spec.int_ior / spec.ext_ior
    return Layers(
        ior, spec.coat_alpha, spec.alpha, eta, k, thickness=spec.thickness, bounces=spec.bounces
    )


def pack(spec: CoatedConductor, packer) -> None:
    """Fill the row of one material."""
    layers = layers_of(spec)
    found = rounds(layers)
    packer.numbers("eta", layers.coat_eta)
    packer.numbers("coat_alpha", layers.coat_alpha)
    packer.numbers("alpha", lobe_alpha(layers))
    packer.numbers("wide", found.trapped)
    packer.numbers("color", *found.albedo)
    packer.curve("rounds", found.row)
    packer.numbers("last_rounds", 0)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    row = _load_row(scene, base, surface)
    coat = Facets(row.coat_alpha, row.coat_alpha, lanes(0.0))
    metal = Facets(row.alpha, row.alpha, lanes(0.0))
    rows = rows_at(row.rounds, lanes(0.0), CURVES * STEPS)
    return Params(row.eta, coat, metal, row.wide, row.color, rows)


# ---------------------------------------------------------------- scattering


@kernel
def _mirrored(facets, wo, wi):
    """(cosine, G / G1(wo), pdf) at the facets that mirror wo to wi."""
    wm = normalize(wo + wi)
    seen_o, seen_i = ggx_visible_area(facets, wo), ggx_visible_area(facets, wi)
    pdf = 0.25 * ggx_density(facets, wm) / seen_o
    # sigma = cos (1 + Lambda), put so that nothing is divided by a small cosine.
    kept = wi.z * seen_o / (wi.z * seen_o + wo.z * (seen_i - wi.z))
    return minimum(maximum(dot(wo, wm), 0.0), 1.0), kept, pdf


@kernel
def _refracted(params, w):
    """Direction in the coat, turned over to the side of w."""
    return Vec3(w.x / params.eta, w.y / params.eta, cos_transmitted(w.z, params.eta))


@kernel
def _scale(params, cosine):
    """How much light goes through the coat on one way, and all rounds that belong to it."""
    place = place_of(cosine)
    return Vec3(
        read_plain_curve(params.rows, lanes_u32(SCALE), place),
        read_plain_curve(params.rows, lanes_u32(SCALE + 1), place),
        read_plain_curve(params.rows, lanes_u32(SCALE + 2), place),
    )


@kernel
def _chance_of_coat(params, cosine):
    """Probability of sampling the coat."""
    return read_plain_curve(params.rows, lanes_u32(CHANCE), place_of(cosine))


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # Below the surface, the overhead direction replaces both; the result is not used.
    up = Vec3(0.0, 0.0, 1.0)
    wo, wi = where(above, wo, up), where(above, wi, up)
    cosine, kept, coat_pdf = _mirrored(params.coat, wo, wi)
    fresnel, _ = fresnel_dielectric(cosine, params.eta)
    coat = fresnel * kept * coat_pdf
    inside = _refracted(params, wi)
    _, kept, pdf = _mirrored(params.metal, _refracted(params, wo), inside)
    # Solid angles grow on the way out.
    pdf = pdf * wi.z / (params.eta * params.eta * inside.z)
    f_cos = _scale(params, wo.z) * _scale(params, wi.z) * (kept * pdf) + coat
    chance = _chance_of_coat(params, wo.z)
    pdf = (1.0 - params.wide) * pdf + params.wide * (INV_PI * wi.z)
    pdf = chance * coat_pdf + (1.0 - chance) * pdf
    return where(above, f_cos, 0.0), where(above, pdf, 0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the lobes, chosen by u."""
    front = wo.z > 0.0
    wo = where(front, wo, Vec3(0.0, 0.0, 1.0))
    chance = _chance_of_coat(params, wo.z)
    mirrored = renormalize(reflect(wo, sample_ggx_visible(params.coat, wo, u2)))
    inside = _refracted(params, wo)
    inside = reflect(inside, sample_ggx_visible(params.metal, inside, u2))
    x, y = params.eta * inside.x, params.eta * inside.y
    z2 = 1.0 - x * x - y * y
    # What is trapped fails, in the surface; samples of a wide lobe go to all sides as well.
    leaves = (z2 > 0.0) & (inside.z > 0.0)
    out = where(leaves, Vec3(x, y, sqrt(maximum(z2, 0.0))), Vec3(1.0, 0.0, 0.0))
    wide = u - chance < params.wide * (1.0 - chance)
    wi = where(wide, square_to_cosine_hemisphere(u2), out)
    wi = where(u < chance, mirrored, wi)
    f_cos, pdf = evaluate(params, wo, wi)
    pdf = where(front, pdf, 0.0)
    return wi, quotient(f_cos, pdf), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    return params.color
