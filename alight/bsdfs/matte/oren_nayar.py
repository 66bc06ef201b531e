r"""Oren-Nayar: a matte surface of tiny Lambertian grooves, flatter than Lambert's law.

.. math::
    f(\omega_o, \omega_i) = \frac{\rho}{\pi} \left( A
        + B \max(0, \cos(\phi_i - \phi_o)) \sin\alpha \tan\beta \right), \\
    A = 1 - \frac{\sigma^2}{2 (\sigma^2 + 0.33)}, \qquad
    B = \frac{0.45 \sigma^2}{\sigma^2 + 0.09}

with alpha the larger and beta the smaller of both angles from the normal, and sigma the standard
deviation of the slopes' angles. This is the authors' qualitative model, without interreflection;
0 degrees is Lambert's law, and a full moon needs about 30. Reciprocal; black from behind.

The largest part of the light that leaves again is rho (A + B / 2), towards grazing angles. Where
A + B / 2 is larger than 1, for sigma below 18.7 degrees (by at most 1.5 %), A and B are divided by
it, so that the surface never creates energy.

Source: Oren and Nayar, Generalization of Lambert's reflectance model, SIGGRAPH 1994, equation 30.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture
from alight.core.fields import Interval
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import Scalar, TexturedColor
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, maximum, where


class OrenNayar(Bsdf):
    """Rough matte surface, as clay, plaster or concrete.

    Parameters
    ----------
    reflectance : ColorTexture, default 0.5
        Albedo of the grooves' walls, each channel in [0, 1].
    sigma : float in [0, 90], degrees, default 20
        Roughness: standard deviation of the walls' angles.
    """

    one_sided: ClassVar[bool] = True
    matte: ClassVar[bool] = True
    type: Literal["oren_nayar"] = "oren_nayar"
    reflectance: ColorTexture = (0.5, 0.5, 0.5)
    sigma: Annotated[float, Interval(0.0, 90.0)] = 20.0

    @property
    def coefficients(self) -> tuple[float, float]:
        """A and B."""
        squared = math.radians(self.sigma) ** 2
        a = 1.0 - 0.5 * squared / (squared + 0.33)
        b = 0.45 * squared / (squared + 0.09)
        scale = max(1.0, a + 0.5 * b)
        return a / scale, b / scale


EXAMPLES = (
    OrenNayar(),
    OrenNayar(reflectance=1.0, sigma=0.0),
    OrenNayar(reflectance=1.0, sigma=12.0),
    OrenNayar(reflectance=(0.9, 0.5, 0.1), sigma=90.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: OrenNayar) -> bool:
    """Only as Lambert's law: grooves hide a part of the light."""
    return spec.reflectance == (1.0, 1.0, 1.0) and spec.sigma == 0.0


def is_reciprocal(spec: OrenNayar) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor
    a: Scalar
    b: Scalar


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: OrenNayar, packer) -> None:
    """Fill the row of one material."""
    a, b = spec.coefficients
    packer.color("reflectance", spec.reflectance)
    packer.numbers("a", a)
    packer.numbers("b", b)


# ---------------------------------------------------------------- scattering


@kernel
def _weight(params, wo, wi):
    """pi f / rho for two directions above the surface."""
    # cos(phi_i - phi_o) sin theta_i sin theta_o is the product of the parts along the surface;
    # sin alpha tan beta divides it by the larger one of the cosines.
    along = maximum(0.0, wo.x * wi.x + wo.y * wi.y)
    return params.a + params.b * along / maximum(maximum(wo.z, wi.z), 1e-9)


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    pdf = where(above, INV_PI * wi.z, 0.0)
    return params.reflectance * (pdf * _weight(params, wo, wi)), pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    wi = square_to_cosine_hemisphere(u2)
    above = (wo.z > 0.0) & (wi.z > 0.0)
    # The cosine and 1 / pi cancel.
    weight = params.reflectance * where(above, _weight(params, wo, wi), 0.0)
    return wi, weight, where(above, INV_PI * wi.z, 0.0), lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light that arrives along the normal."""
    return params.reflectance * params.a
