"""What the renderer takes from the file of a scattering model, and what its kernels return."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from alight.core.registry import Kernel, Record, Records

#: Least number of slots of a material in `materials.data`, see `stride_of`: a power of two.
STRIDE = 16


class BsdfValue(NamedTuple):
    """What `evaluate` returns: f cos theta_i, a `Vec3`, and the density of wi per steradian."""

    f_cos: Any
    pdf: Any


class BsdfSample(NamedTuple):
    """What `sample` returns.

    Attributes
    ----------
    wi : Vec3
        Unit vector.
    weight : Vec3
        f cos theta_i / pdf; 0 where the sample failed.
    pdf : float
        Per steradian; of a delta lobe its probability.
    flags : u32
        See `alight.bsdfs.flags`.
    """

    wi: Any
    weight: Any
    pdf: Any
    flags: Any


class Inside(NamedTuple):
    """A body below a surface, which scatters light alike to all sides.

    Attributes
    ----------
    extinction : Vec3
        Per metre.
    albedo : Vec3
        Share of scattering in it.
    """

    extinction: Any
    albedo: Any


def no_features(spec: Any) -> tuple[str, ...]:
    """Nothing beyond the model's usual path."""
    return ()


def not_lossless(spec: Any) -> bool:
    """Some light is lost."""
    return False


def left_open(spec: Any) -> bool | None:
    """The model does not say."""
    return None


@dataclass(frozen=True, eq=False, kw_only=True)
class BsdfModel(Record):
    """A model that scatters light, or a material made of others, which has no kernels.

    Attributes
    ----------
    SLOTS : mapping of str to int
        Names and widths of the numbers of a material, in the order of its row.
    pack : (spec, packer)
        Fills the row.
    load : kernel ``(scene, base, surface) -> params``
        The parameters at a point of a surface, from the row that begins at `base`.
    evaluate : kernel ``(params, wo, wi) -> BsdfValue``
    sample : kernel ``(params, wo, u, u2) -> BsdfSample``
    albedo : kernel ``(params) -> Vec3``
        A colour, without light and angle.
    features : (spec) -> tuple of str
        What programs must compile for a material beyond the model's usual path.
    inner_index : kernel ``(scene, base, surface) -> float``
        Of models that refract: index of refraction inside over that outside.
    REFRACTING : str
        What programs call it that a material of the model refracts; without it all of them do.
    inside : kernel ``(scene, base, surface) -> Inside``
        Of models of a body that scatters: what is below a point of the surface.
    relative_ior : (spec) -> float
        Of models that light passes bent: index of refraction inside over that outside.
    is_lossless, is_reciprocal : (spec) -> bool
        Whether all light that arrives leaves again, and whether f(wo, wi) = f(wi, wo); None leaves
        the latter open.
    MOST_SENT_OUT : float
        What a white surface sends out at most of the light that it gets.
    """

    SLOTS: Mapping[str, int] = field(default_factory=dict)
    pack: Callable[[Any, Any], None] | None = None
    load: Kernel | None = None
    evaluate: Kernel | None = None
    sample: Kernel | None = None
    albedo: Kernel | None = None
    features: Callable[[Any], tuple[str, ...]] = no_features
    inner_index: Kernel | None = None
    REFRACTING: str = ""
    inside: Kernel | None = None
    relative_ior: Callable[[Any], float] | None = None
    is_lossless: Callable[[Any], bool] = not_lossless
    is_reciprocal: Callable[[Any], bool | None] = left_open
    MOST_SENT_OUT: float = 1.0


#: All models, by name.
BSDFS = Records("bsdfs", BsdfModel)


def stride_of(names: Iterable[str]) -> int:
    """Slots of a material where models of these names occur: more than `STRIDE` if one needs it."""
    widths = [sum(BSDFS[name].SLOTS.values()) for name in names if name in BSDFS]
    return max(STRIDE, 1 << (max(widths, default=1) - 1).bit_length())
