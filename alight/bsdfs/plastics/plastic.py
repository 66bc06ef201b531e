r"""Smooth plastic: a matte base under a clear smooth coat.

.. math::
    f(\omega_o, \omega_i) = \rho_s\, F(\cos\theta_o)\, \delta_\text{mirror}(\omega_o, \omega_i)
        + \frac{(1 - F(\cos\theta_o))\,(1 - F(\cos\theta_i))}{\eta^2}\,
          \frac{\rho'}{\pi}, \qquad
    \rho' = \frac{\rho}{1 - \rho R} \;\text{or}\; \frac{\rho}{1 - R}

F is Fresnel's reflectance of the coat, eta = int_ior / ext_ior, and R the part of diffuse light
that the coat reflects back to the base. With `nonlinear`, colours get more saturated with each
round. One delta lobe and one smooth one; black from behind.

Source: the plug-in ``plastic`` of Mitsuba 3 (https://mitsuba.readthedocs.io); PBR4 section 9.3 for
Fresnel's equations. R is exact here, where Mitsuba uses a fit (0.1 % of rho').
"""

from __future__ import annotations

from collections import namedtuple
from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.dielectrics.interface import MEDIA, Medium
from alight.bsdfs.flags import DELTA, DELTA_AND_SMOOTH, REFLECTION
from alight.bsdfs.plastics.coating import (
    base_f_cos,
    base_reflectance,
    chance_of_coat,
    diffuse_reflectance,
)
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture
from alight.core.fields import Truth
from alight.core.fresnel import fresnel_dielectric
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import Scalar, TexturedColor
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, maximum, where


class Coated(Bsdf):
    """Base class of matte surfaces under a clear coat.

    Parameters
    ----------
    int_ior, ext_ior : float in [1, 5] or str, defaults "acrylic" (1.49) and "air"
        Indices of refraction of the coat and outside, as numbers or names of media.
    diffuse_reflectance : ColorTexture, default 0.5
        Albedo of the base, each channel in [0, 1].
    specular_reflectance : ColorTexture, default 1
        Scale factor for the coat's reflection; 1 for real coats.
    nonlinear : bool, default False
        Whether light is coloured by each round inside the coat.
    """

    int_ior: Medium = MEDIA["acrylic"]
    ext_ior: Medium = MEDIA["air"]
    diffuse_reflectance: ColorTexture = (0.5, 0.5, 0.5)
    specular_reflectance: ColorTexture = (1.0, 1.0, 1.0)
    nonlinear: Truth = False

    @property
    def matte(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether its coat reflects less than 1/9 straight on, and its base is not black."""
        black = self.diffuse_reflectance == (0.0, 0.0, 0.0)
        return 0.5 <= self.int_ior / self.ext_ior <= 2.0 and not black


class Plastic(Coated):
    """Polished plastic, glazed ceramics, varnished wood.

    Parameters
    ----------
    int_ior, ext_ior, diffuse_reflectance, specular_reflectance, nonlinear
        As in `Coated`.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["plastic"] = "plastic"


EXAMPLES = (
    Plastic(),
    Plastic(diffuse_reflectance=1.0, nonlinear=True),
    Plastic(int_ior="diamond", diffuse_reflectance=(0.9, 0.5, 0.1), nonlinear=True),
    Plastic(int_ior=1.2, ext_ior=1.5, diffuse_reflectance=1.0, specular_reflectance=0.2),
    Plastic(diffuse_reflectance=0.0, specular_reflectance=(0.9, 0.5, 0.1)),
    Plastic(diffuse_reflectance=0.7, specular_reflectance=0.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Plastic) -> bool:
    """All light that arrives leaves again: the exact R makes it so for both white models."""
    white = (1.0, 1.0, 1.0)
    return spec.diffuse_reflectance == spec.specular_reflectance == white


def is_reciprocal(spec: Plastic) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Row(NamedTuple):
    """A row of the table."""

    diffuse: TexturedColor
    specular: TexturedColor
    eta: Scalar
    nonlinear: Scalar
    internal: Scalar


SLOTS = slots_of(Row)
_load_row = loader(Row)
Params = namedtuple("PlasticParams", "base specular eta internal")


def pack_coat(spec: Coated, packer) -> None:
    """Fill the slots of the base and its coat."""
    packer.color("diffuse", spec.diffuse_reflectance)
    packer.color("specular", spec.specular_reflectance)
    packer.numbers("eta", spec.int_ior / spec.ext_ior)
    packer.numbers("nonlinear", float(spec.nonlinear))


def pack(spec: Plastic, packer) -> None:
    """Fill the row of one material."""
    pack_coat(spec, packer)
    packer.numbers("internal", diffuse_reflectance(spec.ext_ior / spec.int_ior))


def features(spec: Plastic) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return (DELTA_AND_SMOOTH,)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    row = _load_row(scene, base, surface)
    matte = base_reflectance(row.diffuse, row.internal, row.nonlinear)
    return Params(matte, row.specular, row.eta, row.internal)


# ---------------------------------------------------------------- scattering


@kernel
def _chance_of_coat(params, reflected):
    """Probability of sampling the coat's lobe, which reflects the part F of the light."""
    # rho' (1 - R) is what the base reflects of light inside: (1 - R) = (1 - R_outside) / eta^2.
    return chance_of_coat(reflected, params.specular, params.base * (1.0 - params.internal))


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian) of the base."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    reflected, _ = fresnel_dielectric(maximum(wo.z, 0.0), params.eta)
    reflected_i, _ = fresnel_dielectric(maximum(wi.z, 0.0), params.eta)
    through = where(above, (1.0 - reflected) * (1.0 - reflected_i), 0.0)
    f_cos = base_f_cos(params.base, through, params.eta, wi.z)
    pdf = (1.0 - _chance_of_coat(params, reflected)) * (INV_PI * wi.z)
    return f_cos, where(above, pdf, 0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, density or probability of the lobe, flags)."""
    reflected, _ = fresnel_dielectric(maximum(wo.z, 0.0), params.eta)
    chance = _chance_of_coat(params, reflected)
    mirrored = u < chance
    matte = square_to_cosine_hemisphere(u2)
    wi = where(mirrored, Vec3(-wo.x, -wo.y, wo.z), matte)
    front = (wo.z > 0.0) & (wi.z > 0.0)
    # Lobe of the coat: F / chance.
    coat = params.specular * (reflected / where(mirrored, chance, 1.0))
    # Base: the cosine over pi cancels.
    reflected_i, _ = fresnel_dielectric(maximum(matte.z, 0.0), params.eta)
    through = (1.0 - reflected) * (1.0 - reflected_i) / (params.eta * params.eta)
    base = params.base * (through / where(mirrored, 1.0, 1.0 - chance))
    weight = where(front, where(mirrored, coat, base), 0.0)
    pdf = where(mirrored, chance, (1.0 - chance) * (INV_PI * matte.z))
    flags = where(mirrored, lanes_u32(REFLECTION | DELTA), lanes_u32(REFLECTION))
    return wi, weight, where(front, pdf, 0.0), flags


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    reflected, _ = fresnel_dielectric(lanes(1.0), params.eta)
    base = params.base * ((1.0 - params.internal) * (1.0 - reflected))
    return params.specular * reflected + base
