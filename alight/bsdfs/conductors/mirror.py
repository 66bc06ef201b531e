r"""Perfect mirror: all light leaves in the mirrored direction.

.. math:: \omega_i = (-\omega_{o,x}, -\omega_{o,y}, \omega_{o,z}), \qquad \text{weight} = \rho

One delta lobe, without Fresnel's dependence on the angle (for metals see `conductor`). Black from
behind.

Source: PBR4 section 9.3.1.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.dirac import evaluate as evaluate
from alight.bsdfs.flags import DELTA, REFLECTION
from alight.core.field_types import ColorTexture
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf, largest_channel
from alight.core.vec import Vec3
from alight.textures.fetch import TexturedColor
from lanewise.jit import kernel
from lanewise.simd import lanes_u32, where


class Mirror(Bsdf):
    """Ideal specular reflector.

    Parameters
    ----------
    reflectance : ColorTexture, default 1
        Reflected part of the light, each channel in [0, 1].
    """

    one_sided: ClassVar[bool] = True
    type: Literal["mirror"] = "mirror"
    reflectance: ColorTexture = (1.0, 1.0, 1.0)

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions."""
        return largest_channel(self.reflectance)


EXAMPLES = (Mirror(), Mirror(reflectance=(0.9, 0.6, 0.2)), Mirror(reflectance=0.0))


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Mirror) -> bool:
    """All light that arrives leaves again."""
    return spec.reflectance == (1.0, 1.0, 1.0)


def is_reciprocal(spec: Mirror) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Mirror, packer) -> None:
    """Fill the row of one material."""
    packer.color("reflectance", spec.reflectance)


# ---------------------------------------------------------------- scattering


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    front = where(wo.z > 0.0, 1.0, 0.0)
    wi = Vec3(-wo.x, -wo.y, wo.z)
    return wi, params.reflectance * front, front, lanes_u32(REFLECTION | DELTA)


@kernel
def albedo(params):
    """Reflected part of the light."""
    return params.reflectance
