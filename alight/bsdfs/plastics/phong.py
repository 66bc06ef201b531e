r"""Modified Phong: a diffuse part and a lobe around the mirrored direction.

.. math::
    f(\omega_o, \omega_i) = \frac{\rho_d}{\pi}
        + \rho_s \frac{n + 2}{2\pi} \max(0, \cos\alpha)^n

with alpha the angle between `wi` and the mirrored `wo`. The factor (n + 2) / (2 pi) bounds the
reflected part by rho_d + rho_s, which must not exceed 1, so the surface never creates energy.
Reciprocal; black from behind.

Source: Lafortune and Willems, Using the modified Phong reflectance model for physically based
rendering, report CW 197, K.U. Leuven (1994).
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple, Self

from pydantic import model_validator

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_PI, INV_TWO_PI
from alight.core.energy import energy_problem
from alight.core.field_types import ColorTexture, ScalarTexture
from alight.core.fields import invalid
from alight.core.frame import frame_from_normal, to_world
from alight.core.maths import exp, expm1, log1p
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, length_squared, luminance, quotient
from alight.core.warps import direction_around_z, square_to_cosine_hemisphere
from alight.textures.fetch import TexturedColor, TexturedScalar
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, where


class Phong(Bsdf):
    """Glossy surface with an exponent.

    Parameters
    ----------
    diffuse : ColorTexture, default 0.5
        Reflectance of the matte part.
    specular : ColorTexture, default 0.3
        Reflectance of the lobe; diffuse + specular is at most 1 in each channel.
    exponent : ScalarTexture >= 0, default 30
        Sharpness n of the lobe; 0 is the widest.
    """

    shares: ClassVar[tuple[str, ...]] = ("diffuse", "specular")
    one_sided: ClassVar[bool] = True
    type: Literal["phong"] = "phong"
    diffuse: ColorTexture = (0.5, 0.5, 0.5)
    specular: ColorTexture = (0.3, 0.3, 0.3)
    exponent: ScalarTexture = 30.0

    @model_validator(mode="after")
    def _conserves_energy(self) -> Self:
        problem = energy_problem(**{name: getattr(self, name) for name in self.shares})
        if problem:
            raise invalid(problem)
        return self


EXAMPLES = (
    Phong(),
    Phong(diffuse=0.0, specular=1.0, exponent=1.0),
    Phong(diffuse=(0.6, 0.2, 0.1), specular=0.4, exponent=300.0),
    Phong(diffuse=0.0, specular=0.8, exponent=0.0),
    Phong(diffuse=0.9, specular=0.0, exponent=10.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Phong) -> bool:
    """Only without the lobe: a part of it always lies below the surface."""
    return spec.diffuse == (1.0, 1.0, 1.0)


def is_reciprocal(spec: Phong) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    diffuse: TexturedColor
    specular: TexturedColor
    exponent: TexturedScalar


SLOTS = slots_of(Params)
load = loader(Params)

#: Sharper lobes than this (0.001 degrees) are narrower than rounding errors of directions.
SHARPEST = 1e10


def pack(spec: Phong, packer) -> None:
    """Fill the row of one material."""
    packer.color("diffuse", spec.diffuse)
    packer.color("specular", spec.specular)
    n = spec.exponent
    packer.scalar("exponent", min(n, SHARPEST) if isinstance(n, float) else n)


# ---------------------------------------------------------------- scattering


@kernel
def _chance_of_lobe(params):
    """Probability of sampling the lobe: its part of the reflected luminance."""
    lobe, matte = luminance(params.specular), luminance(params.diffuse)
    both = lobe + matte
    return where(both > 0.0, lobe / where(both > 0.0, both, 1.0), 0.0)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # 1 - cos alpha from the chord: exact to rounding for narrow lobes, where the cosine is not.
    n = params.exponent
    one_minus_cos = 0.5 * length_squared(wi - Vec3(-wo.x, -wo.y, wo.z))
    power = exp(n * log1p(where(one_minus_cos < 1.0, -one_minus_cos, 0.0)))
    lobe = where(above & (one_minus_cos < 1.0), INV_TWO_PI * power, 0.0)
    matte = where(above, INV_PI, 0.0)
    f = params.diffuse * matte + params.specular * ((n + 2.0) * lobe)
    chance = _chance_of_lobe(params)
    pdf = (1.0 - chance) * (matte * wi.z) + chance * ((n + 1.0) * lobe)
    return f * wi.z, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the two parts, chosen by u."""
    # The density cos^n alpha has the distribution 1 - cos^(n + 1) alpha.
    one_minus_cos = -expm1(log1p(-u2[0]) / (params.exponent + 1.0))
    axis = Vec3(-wo.x, -wo.y, wo.z)
    s, t = frame_from_normal(axis)
    glossy = to_world(s, t, axis, direction_around_z(one_minus_cos, u2[1]))
    wi = where(u < _chance_of_lobe(params), glossy, square_to_cosine_hemisphere(u2))
    f_cos, pdf = evaluate(params, wo, wi)
    return wi, quotient(f_cos, pdf), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of the light, as if none of the lobe lay below the surface."""
    return params.diffuse + params.specular
