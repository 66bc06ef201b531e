r"""Bump map: shading normals from a height field.

.. math::
    n \propto \left( \frac{\partial p}{\partial u} + z\, c\, \frac{\partial h}{\partial u} \right)
        \times \left( \frac{\partial p}{\partial v}
        + z\, c\, \frac{\partial h}{\partial v} \right)

with the height h, its luminance if it is a colour, the scale c and the surface's normal z. So c h
is a height in metres where the surface's point p is. See `alight.bsdfs.normals.shading_normals` for
the rims. Of several maps on one material the innermost one counts.

Source: Blinn 1978, Simulation of wrinkled surfaces; the plug-in ``bumpmap`` of Mitsuba 3.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part
from alight.bsdfs.normals.shading_normals import (
    HEIGHTS,
    IS_HEIGHT,
    BumpMapRow,
    map_features,
    packed_modes,
)
from alight.core.field_types import NestedBsdf, Number
from alight.core.fields import Interval, NumberOrTexture, Truth
from alight.core.parameters import slots_of
from alight.core.spec import Texture
from alight.textures import VARYING

Height = Annotated[float | Texture | str, NumberOrTexture(Interval(), other=(str, Texture))]


class BumpMap(Nested):
    """Wrapper that gives a material the normals of a relief.

    Parameters
    ----------
    texture : float or texture, default 0
        The height; a bitmap needs ``color_space: linear`` if it has 8 or 16 bits.
    scale : float, metres, default 1
        Scale of the height; below 0 hills become hollows.
    rims : {"lit", "folded", "black"}, default "lit"
        What to do with normals that turn away from the viewer.
    fading : bool, default True
        Whether light fades out towards the line where the true surface turns away from it.
    bsdf : Bsdf or str, default Diffuse()
        The material, or its name.
    """

    bends_normals: ClassVar[bool] = True
    type: Literal["bump_map"] = "bump_map"
    texture: Height = 0.0
    scale: Number = 1.0
    rims: Literal["lit", "folded", "black"] = "lit"
    fading: Truth = True
    bsdf: NestedBsdf = Diffuse()

    @property
    def parts(self) -> tuple[Part, ...]:
        """The material."""
        return (Part(self.bsdf),)


EXAMPLES = (
    BumpMap(),
    BumpMap(texture=VARYING, scale=0.01, bsdf=Diffuse(reflectance=1.0)),
    BumpMap(texture=VARYING, rims="black", fading=False, bsdf=Diffuse(reflectance=0.5)),
)

SLOTS = slots_of(BumpMapRow)


def pack(spec: BumpMap, packer) -> None:
    """Fill the row of the map."""
    packer.scalar("texture", spec.texture)
    packer.numbers("scale", spec.scale)
    packer.numbers("modes", packed_modes(spec) + IS_HEIGHT)


def features(spec: BumpMap) -> tuple[str, ...]:
    """What must be compiled for this map."""
    return (HEIGHTS, *map_features(spec))
