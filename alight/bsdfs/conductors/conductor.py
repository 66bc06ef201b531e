r"""Smooth metal: a mirror whose reflectance follows Fresnel's equations.

.. math:: \omega_i = (-\omega_{o,x}, -\omega_{o,y}, \omega_{o,z}), \qquad
    \text{weight} = \rho F(\cos\theta_o;\, \eta + i k)

eta + i k is the complex index of refraction against the medium outside (air), one per channel.
One delta lobe; black from behind.

Source: PBR4 sections 9.3.6 and 9.4. The table `METALS` holds measured spectra: Johnson and Christy
1974 (Phys. Rev. B 9) for cobalt, iron, palladium and titanium; for the others those of Palik,
Handbook of Optical Constants of Solids (1985, volume II 1991), in the tabulation that Mitsuba 3
ships. Each spectrum, linear between its points, was weighted with the CIE 1931 curves from 360 to
830 nm, divided by the integral of the second one and converted to linear sRGB, without adaptation
to its white (a constant n becomes (1.205, 0.948, 0.909) n), as Mitsuba 3 does in its RGB modes.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, NamedTuple, Self

from pydantic import AfterValidator, model_validator

from alight.bsdfs.dirac import evaluate as evaluate
from alight.bsdfs.flags import DELTA, REFLECTION
from alight.bsdfs.tints import WHITE, Tint, tint_features
from alight.core.errors import unknown_name
from alight.core.field_types import Color, ColorTexture, PositiveColor, Triple
from alight.core.fields import invalid
from alight.core.fresnel import fresnel_conductor
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf, largest_channel
from alight.core.vec import Vec3
from alight.textures.fetch import PlainColor
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, where

# metal: (eta, k) for red, green and blue
METALS: dict[str, tuple[Triple, Triple]] = {
    "aluminium": ((1.6575, 0.8804, 0.5212), (9.2238, 6.2695, 4.8370)),
    "beryllium": ((4.1850, 3.1850, 2.7841), (3.8355, 3.0101, 2.8690)),
    "chromium": ((4.3697, 2.9165, 1.6549), (5.2065, 4.2313, 3.7547)),
    "cobalt": ((2.6890, 1.9301, 1.5444), (5.0426, 3.5985, 2.9222)),
    "copper": ((0.2010, 0.9237, 1.1022), (3.9133, 2.4530, 2.1421)),
    "gold": ((0.1430, 0.3753, 1.4420), (3.9830, 2.3856, 1.6034)),
    "iridium": ((3.0863, 2.0822, 1.6179), (5.5922, 4.0671, 3.2673)),
    "iron": ((3.5145, 2.7698, 2.3017), (3.6950, 2.7861, 2.4930)),
    "lithium": ((0.2658, 0.1956, 0.2209), (3.5402, 2.3111, 1.6686)),
    "mercury": ((2.3989, 1.4400, 0.9096), (6.3276, 4.3719, 3.4218)),
    "molybdenum": ((4.4840, 3.5251, 2.7763), (4.1114, 3.4208, 3.1506)),
    "nickel": ((2.3673, 1.6634, 1.4671), (4.4988, 3.0502, 2.3454)),
    "niobium": ((3.4201, 2.7901, 2.3956), (3.4414, 2.7377, 2.5797)),
    "palladium": ((2.1381, 1.5374, 1.2592), (5.1871, 3.6143, 2.8956)),
    "potassium": ((0.0640, 0.0464, 0.0382), (2.1042, 1.3489, 0.9131)),
    "rhodium": ((2.5858, 1.8602, 1.5543), (6.7823, 4.7030, 3.9761)),
    "silver": ((0.1553, 0.1167, 0.1384), (4.8284, 3.1222, 2.1469)),
    "sodium": ((0.0603, 0.0561, 0.0620), (3.1793, 2.1125, 1.5790)),
    "tantalum": ((2.0627, 2.3929, 2.6279), (2.4084, 1.7415, 1.9470)),
    "titanium": ((3.2754, 2.3798, 2.0247), (4.5723, 3.2245, 2.7278)),
    "tungsten": ((4.3708, 3.3002, 2.9984), (3.5006, 2.6049, 2.2732)),
    "vanadium": ((4.2776, 3.5130, 2.7611), (3.4913, 2.8895, 3.1115)),
}


def _known(metal: str) -> str:
    if metal not in METALS:
        raise invalid(unknown_name("metal", metal, METALS))
    return metal


class OfMetal(Bsdf):
    """Base class of what is made of metal, by name or by index of refraction.

    Parameters
    ----------
    metal : str, optional
        A name of `METALS`; not together with `eta` and `k`. Gold where nothing is given.
    eta : PositiveColor, optional
        Real part of the index of refraction.
    k : Color, optional
        Extinction coefficient, the imaginary part.
    """

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


class Metallic(OfMetal):
    """Base class of bare metals.

    Parameters
    ----------
    metal, eta, k
        As in `OfMetal`.
    specular_reflectance : ColorTexture, default 1
        Scale factor for reflected light, each channel in [0, 1]; 1 for real metals.
    """

    specular_reflectance: ColorTexture = WHITE


class Conductor(Metallic):
    """Polished metal, by name or by its index of refraction.

    Parameters
    ----------
    metal, eta, k, specular_reflectance
        As in `Metallic`.
    """

    one_sided: ClassVar[bool] = True
    type: Literal["conductor"] = "conductor"

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions."""
        # Fresnel's factor is 1 at most.
        return largest_channel(self.specular_reflectance)


EXAMPLES = (
    Conductor(),
    Conductor(metal="copper"),
    Conductor(eta=(0.2, 1.0, 3.0), k=(0.0, 2.0, 9.0)),
    Conductor(eta=1.5, k=0.0),
    Conductor(metal="silver", specular_reflectance=(0.9, 0.6, 0.2)),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Conductor) -> bool:
    """Every real metal absorbs what it does not reflect."""
    return False


def is_reciprocal(spec: Conductor) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    eta: PlainColor
    k: PlainColor
    tint: Tint


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Conductor, packer) -> None:
    """Fill the row of one material."""
    pack_metal(spec, packer)


def pack_metal(spec: Metallic, packer) -> None:
    """Fill the slots of `Params`."""
    eta, k = spec.index_of_refraction
    packer.numbers("eta", *eta)
    packer.numbers("k", *k)
    packer.color("tint", spec.specular_reflectance)


def features(spec: Conductor) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return tint_features(spec.specular_reflectance)


# ---------------------------------------------------------------- scattering


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, probability of the lobe, flags)."""
    front = where(wo.z > 0.0, 1.0, 0.0)
    wi = Vec3(-wo.x, -wo.y, wo.z)
    fresnel = fresnel_conductor(where(wo.z > 0.0, wo.z, 1.0), params.eta, params.k)
    return wi, params.tint * fresnel * front, front, lanes_u32(REFLECTION | DELTA)


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    return params.tint * fresnel_conductor(lanes(1.0), params.eta, params.k)
