r"""Thin dielectric: a pane of glass so thin that light passes straight on.

.. math::
    R = F(\cos\theta_o; \eta), \qquad
    R' = R + \frac{R (1 - R)^2}{1 - R^2} = \frac{2 R}{1 + R}, \qquad T' = 1 - R'

Two parallel interfaces: the second one turns light back to its old direction, and the reflections
between both add up to a geometric series. Two delta lobes. The medium is the same on both sides, so
radiance is not scaled, and both sides look alike.

Source: PBR4 section 9.5.1; Stokes 1862, On the intensity of the light reflected
from or transmitted through a pile of plates.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.dielectrics.interface import SLOTS as SLOTS
from alight.bsdfs.dielectrics.interface import Interface
from alight.bsdfs.dielectrics.interface import albedo as albedo
from alight.bsdfs.dielectrics.interface import features as features
from alight.bsdfs.dielectrics.interface import is_lossless as is_lossless
from alight.bsdfs.dielectrics.interface import load as load
from alight.bsdfs.dielectrics.interface import pack as pack
from alight.bsdfs.dirac import evaluate as evaluate
from alight.bsdfs.flags import DELTA, REFLECTION, TRANSMISSION
from alight.core.fresnel import fresnel_dielectric
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes_u32, where


class ThinDielectric(Interface):
    """Window pane, soap film without its colours.

    Parameters
    ----------
    int_ior, ext_ior, specular_reflectance, specular_transmittance
        As in `alight.bsdfs.dielectrics.interface.Interface`: inside is the pane, outside are both
        sides of it.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["thin_dielectric"] = "thin_dielectric"


EXAMPLES = (
    ThinDielectric(),
    ThinDielectric(int_ior="diamond", ext_ior="vacuum"),
    ThinDielectric(int_ior=1.0, ext_ior=1.5),
    ThinDielectric(specular_reflectance=(0.9, 0.6, 0.2), specular_transmittance=(0.3, 1.0, 0.8)),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_reciprocal(spec: ThinDielectric) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


def relative_ior(spec: ThinDielectric) -> float:
    """Index beyond the pane over that before it."""
    return 1.0


# ---------------------------------------------------------------- scattering


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    once, _ = fresnel_dielectric(absolute(wo.z), params.eta)
    reflectance = 2.0 * once / (1.0 + once)
    reflects = u < reflectance
    wi = where(reflects, Vec3(-wo.x, -wo.y, wo.z), -wo)
    pmf = where(reflects, reflectance, 1.0 - reflectance)
    # The lobe's factor is also its probability, so it cancels.
    weight = where(reflects, params.reflectance, params.transmittance)
    # Not NULL: nothing is there that shadow rays could see through.
    passes = lanes_u32(TRANSMISSION | DELTA)
    return wi, weight, pmf, where(reflects, lanes_u32(REFLECTION | DELTA), passes)
