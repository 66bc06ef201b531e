"""Boundaries between two clear media: what smooth, thin and rough dielectrics share."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import BeforeValidator

from alight.bsdfs.tints import WHITE, Tint, tint_features
from alight.core.errors import unknown_name
from alight.core.field_types import ColorTexture, IndexOfRefraction
from alight.core.fields import invalid
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.textures.fetch import Scalar
from lanewise.jit import kernel

# Indices at 589.3 nm (sodium D), from the CRC Handbook of Chemistry and Physics and the
# catalogue of Schott AG (bk7: 1.5168, at the green 546 nm line 1.5187).
MEDIA: dict[str, float] = {
    "vacuum": 1.0,
    "air": 1.000277,
    "ice": 1.31,
    "water": 1.333,
    "ethanol": 1.361,
    "fused_quartz": 1.4585,
    "acrylic": 1.49,
    "bk7": 1.5168,
    "amber": 1.55,
    "sapphire": 1.77,
    "diamond": 2.419,
}


def _by_name(value: object) -> object:
    if isinstance(value, str):
        if value not in MEDIA:
            raise invalid(unknown_name("medium", value, MEDIA))
        return MEDIA[value]
    return value


Medium = Annotated[IndexOfRefraction, BeforeValidator(_by_name)]


class Interface(Bsdf):
    """Base class of boundaries between two clear media.

    Parameters
    ----------
    int_ior, ext_ior : float in [1, 5] or str, defaults "bk7" and "air"
        Indices of refraction inside and outside, as numbers or names of `MEDIA`.
    specular_reflectance, specular_transmittance : ColorTexture, defaults 1
        Scale factors for reflected and transmitted light, each channel in [0, 1]; 1 for real media.
    """

    transmissive = True
    int_ior: Medium = MEDIA["bk7"]
    ext_ior: Medium = MEDIA["air"]
    specular_reflectance: ColorTexture = WHITE
    specular_transmittance: ColorTexture = WHITE


def is_lossless(spec: Interface) -> bool:
    """All light that arrives leaves again."""
    return spec.specular_reflectance == spec.specular_transmittance == WHITE


def relative_ior(spec: Interface) -> float:
    """Index inside over that outside."""
    return spec.int_ior / spec.ext_ior


class Params(NamedTuple):
    """A row of the table; those of other models begin with the same fields."""

    eta: Scalar
    reflectance: Tint
    transmittance: Tint


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Interface, packer) -> None:
    """Fill the slots of `Params`."""
    packer.numbers("eta", relative_ior(spec))
    packer.color("reflectance", spec.specular_reflectance)
    packer.color("transmittance", spec.specular_transmittance)


def features(spec: Interface) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return tint_features(spec.specular_reflectance, spec.specular_transmittance)


@kernel
def albedo(params):
    """What is transmitted; nothing is absorbed by real media."""
    return params.transmittance
