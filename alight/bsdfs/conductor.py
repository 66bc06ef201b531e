r"""Smooth metal: a mirror whose reflectance follows Fresnel's equations.

.. math:: \omega_i = (-\omega_{o,x}, -\omega_{o,y}, \omega_{o,z}), \qquad
    \text{weight} = F(\cos\theta_o;\, \eta + i k)

eta + i k is the complex index of refraction against the medium outside (air), one per channel.
One Dirac lobe; black from behind.

Source: PBR4 sections 9.3.6 and 9.4. The table holds measured spectra (Johnson and Christy 1972 for
gold, silver and copper, 1974 for chromium; Rakic 1995 for aluminium; Palik 1985 for tungsten),
weighted with the CIE 1931 curves, converted to linear sRGB and rounded.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, model_validator

from alight.bsdfs.flags import DELTA, REFLECTION
from alight.core.errors import unknown_name
from alight.core.fresnel import fresnel_conductor
from alight.core.jit import kernel
from alight.core.simd import lanes, lanes_u32, lanes_vec3, where
from alight.core.spec import Bsdf, Color, PositiveColor, Triple, invalid
from alight.core.vec import Vec3
from alight.textures.fetch import constant_color

# metal: (eta, k) for red, green and blue
METALS: dict[str, tuple[Triple, Triple]] = {
    "aluminium": ((1.6575, 0.8804, 0.5212), (9.2238, 6.2695, 4.8370)),
    "chromium": ((4.3697, 2.9165, 1.6549), (5.2066, 4.2313, 3.7547)),
    "copper": ((0.2010, 0.9238, 1.1022), (3.9133, 2.4531, 2.1421)),
    "gold": ((0.1430, 0.3753, 1.4421), (3.9830, 2.3856, 1.6034)),
    "silver": ((0.1553, 0.1167, 0.1384), (4.8284, 3.1222, 2.1469)),
    "tungsten": ((4.3708, 3.3003, 2.9984), (3.5006, 2.6049, 2.2732)),
}


def _known(metal: str) -> str:
    if metal not in METALS:
        raise invalid(unknown_name("metal", metal, METALS))
    return metal


class Conductor(Bsdf):
    """Polished metal, by name or by its index of refraction.

    Parameters
    ----------
    metal : str, optional
        A name of `METALS`; not together with `eta` and `k`. Gold where nothing is given.
    eta : PositiveColor, optional
        Real part of the index of refraction.
    k : Color, optional
        Extinction coefficient, the imaginary part.
    """

    type: Literal["conductor"] = "conductor"
    metal: Annotated[str, AfterValidator(_known)] | None = None
    eta: PositiveColor | None = None
    k: Color | None = None

    @model_validator(mode="after")
    def _has_one_index(self) -> Self:
        if self.metal is not None and (self.eta is not None or self.k is not None):
            raise invalid("takes either metal or eta and k, got both")
        if (self.eta is None) != (self.k is None):
            raise invalid("takes eta and k together, got only one of them")
        return self

    @property
    def index_of_refraction(self) -> tuple[Triple, Triple]:
        """Eta and k, three channels each."""
        if self.eta is not None and self.k is not None:
            return self.eta, self.k
        return METALS[self.metal or "gold"]


EXAMPLES = (
    Conductor(),
    Conductor(metal="copper"),
    Conductor(eta=(0.2, 1.0, 3.0), k=(0.0, 2.0, 9.0)),
    Conductor(eta=1.5, k=0.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Conductor) -> bool:
    """Every real metal absorbs what it does not reflect."""
    return False


def is_reciprocal(spec: Conductor) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables

SLOTS = {"eta": 3, "k": 3}
Params = namedtuple("ConductorParams", "eta k")


def pack(spec: Conductor, packer) -> None:
    """Fill the row of one material."""
    eta, k = spec.index_of_refraction
    packer.numbers("eta", *eta)
    packer.numbers("k", *k)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    return Params(constant_color(scene, base, surface), constant_color(scene, base + 3, surface))


# ---------------------------------------------------------------- scattering


@kernel
def evaluate(params, wo, wi):
    """(0, 0): directions that were not sampled from a Dirac lobe never lie in it."""
    return lanes_vec3(0.0), lanes(0.0)


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    front = where(wo.z > 0.0, 1.0, 0.0)
    wi = Vec3(-wo.x, -wo.y, wo.z)
    weight = fresnel_conductor(where(wo.z > 0.0, wo.z, 1.0), params.eta, params.k) * front
    return wi, weight, front, lanes_u32(REFLECTION | DELTA)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    return fresnel_conductor(lanes(1.0), params.eta, params.k)
