r"""Lambertian reflection: the same radiance in every direction.

.. math:: f(\omega_o, \omega_i) = \rho / \pi \quad \text{if both directions are above the surface}

Black from behind. `sampling` chooses how directions are drawn, not what the surface looks like:
``cosine`` cancels the cosine of the rendering equation (weight = albedo), ``uniform`` is its naive
twin (weight = 2 albedo cos theta). Where the light is cos^m theta_i, m >= 0, the variances of one
sample, relative to the mean squared, are

.. math::
    V_\text{cosine} = \frac{m^2}{4 (m + 1)}, \qquad
    V_\text{uniform} = \frac{(m + 1)^2}{2 m + 3}:

none against 1/3 under a constant sky, 1/8 against 4/5 for m = 1, half for bright spots overhead
(the ratio tends to 2). A small light at elevation 90 degrees - theta has the ratio 2 cos theta, so
only light that grazes the surface, by less than 30 degrees, favours the uniform one.

Source: Lambert, Photometria (1760); PBR4 section 9.2 and appendix A.5.3.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_PI, INV_TWO_PI
from alight.core.field_types import ColorTexture
from alight.core.noise_only import NoiseOnly
from alight.core.parameters import Slots, loader, slots_of
from alight.core.spec import Bsdf, largest_channel
from alight.core.warps import square_to_cosine_hemisphere, square_to_uniform_hemisphere
from alight.textures.fetch import TexturedColor, scalar
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, lanes, lanes_u32, where


class Diffuse(Bsdf):
    """Matte surface.

    Parameters
    ----------
    reflectance : ColorTexture, default 0.5
        Albedo, each channel in [0, 1].
    sampling : {"cosine", "uniform"}, default "cosine"
        Density of the sampled directions over the hemisphere.
    """

    one_sided: ClassVar[bool] = True
    matte: ClassVar[bool] = True
    type: Literal["diffuse"] = "diffuse"
    reflectance: ColorTexture = (0.5, 0.5, 0.5)
    sampling: Annotated[Literal["cosine", "uniform"], NoiseOnly()] = "cosine"

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions."""
        albedo = largest_channel(self.reflectance)
        return albedo if albedo is None or self.sampling == "cosine" else 2.0 * albedo


EXAMPLES = (
    Diffuse(),
    Diffuse(reflectance=(0.9, 0.5, 0.1), sampling="uniform"),
    Diffuse(reflectance=1.0),
    Diffuse(reflectance=0.0),
)


# ---------------------------------------------------------------- laws, checked for every example

#: What programs call the naive sampling.
UNIFORM = "diffuse:uniform"


def is_lossless(spec: Diffuse) -> bool:
    """All light that arrives leaves again."""
    return spec.reflectance == (1.0, 1.0, 1.0)


def is_reciprocal(spec: Diffuse) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


@specialised
def _uniform(program):
    return scalar if UNIFORM in program.bsdfs else _never


@kernel
def _never(scene, slot, surface):
    return 0.0


class Params(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor
    uniform: Annotated[Any, Slots(_uniform)]


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Diffuse, packer) -> None:
    """Fill the row of one material."""
    packer.color("reflectance", spec.reflectance)
    packer.numbers("uniform", float(spec.sampling == "uniform"))


def features(spec: Diffuse) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return (UNIFORM,) if spec.sampling == "uniform" else ()


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    cosine = where(above, INV_PI * wi.z, 0.0)
    pdf = where(params.uniform > 0.0, where(above, INV_TWO_PI, 0.0), cosine)
    return params.reflectance * cosine, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    wi = square_to_cosine_hemisphere(u2)
    pdf = INV_PI * wi.z
    # (rho / pi) cos / (cos / pi): the cosine cancels.
    scale = lanes(1.0)
    if any_lane(params.uniform > 0.0):
        naive = params.uniform > 0.0
        wi = where(naive, square_to_uniform_hemisphere(u2), wi)
        pdf = where(naive, INV_TWO_PI, pdf)
        # (rho / pi) cos / (1 / 2 pi).
        scale = where(naive, 2.0 * wi.z, 1.0)
    above = (wo.z > 0.0) & (wi.z > 0.0)
    weight = params.reflectance * where(above, scale, 0.0)
    return wi, weight, where(above, pdf, 0.0), lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of the light."""
    return params.reflectance
