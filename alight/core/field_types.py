"""What the fields of descriptions hold: numbers in ranges, colours, textures, other models."""

from __future__ import annotations

from functools import cache
from typing import Annotated, get_args

from alight.core.fields import Interval, Model, Models, NumberOrTexture, Numbers
from alight.core.spec import Bsdf, Spec, Texture

Number = Annotated[float, Interval()]
NonNegative = Annotated[float, Interval(low=0.0)]
Positive = Annotated[float, Interval(low=0.0, open_ends=True)]
UnitInterval = Annotated[float, Interval(0.0, 1.0)]
Degrees = Annotated[float, Interval()]
FieldOfView = Annotated[float, Interval(0.0, 180.0, open_ends=True)]
# Below 1 lie only X-rays and metals; above 5 no clear material is known.
IndexOfRefraction = Annotated[float, Interval(1.0, 5.0)]
# A sampler's block of strata squared samples stays below 2^20, an integrator's depth below 2^16
# dimensions of 16 per vertex; a filter narrower than 0.1 pixels would sample a point.
Strata = Annotated[int, Interval(1, 1024, integer=True)]
Depth = Annotated[int, Interval(1, 4000, integer=True)]
FilterRadius = Annotated[float, Interval(0.1, 16.0)]

Triple = tuple[float, float, float]
Vector2 = Annotated[tuple[float, float], Numbers(2, Interval())]
Vector3 = Annotated[Triple, Numbers(3, Interval())]
Scale2 = Annotated[tuple[float, float], Numbers(2, Interval(), spread=True)]
Color = Annotated[Triple, Numbers(3, Interval(low=0.0), spread=True)]
PositiveColor = Annotated[Triple, Numbers(3, Interval(low=0.0, open_ends=True), spread=True)]
Reflectance = Annotated[Triple, Numbers(3, Interval(0.0, 1.0), spread=True)]
_NAMED = (str, Texture)  # What may stand for a number: a texture, or the name of one.
ColorTexture = Annotated[
    Triple | Texture | str, Numbers(3, Interval(0.0, 1.0), spread=True, other=_NAMED)
]
RadianceTexture = Annotated[
    Triple | Texture | str, Numbers(3, Interval(low=0.0), spread=True, other=_NAMED)
]
UnitTexture = Annotated[float | Texture | str, NumberOrTexture(Interval(0.0, 1.0), other=_NAMED)]
# Smoother surfaces are mirrors to float32; kernels raise smaller values of textures to it.
SMOOTHEST = 1e-4
Roughness = Annotated[float | Texture | str, NumberOrTexture(Interval(SMOOTHEST, 1), other=_NAMED)]
ScalarTexture = Annotated[float | Texture | str, NumberOrTexture(Interval(low=0.0), other=_NAMED)]
NestedBsdf = Annotated[Bsdf | str, Model("bsdf", "bsdfs", named=True)]
NestedBsdfs = Annotated[tuple[Bsdf | str, ...], Models("bsdf", "bsdfs", named=True)]


@cache
def texture_interval(spec: type[Spec], name: str) -> Interval | None:
    """Range of the values that a texture in a field may have; None if it takes no textures."""
    info = spec.model_fields[name]
    found = [*info.metadata]
    # In ``X | None`` the metadata of X are inside.
    for part in get_args(info.annotation):
        found.extend(getattr(part, "__metadata__", ()))
    return next((item.interval for item in found if Texture in getattr(item, "other", ())), None)
