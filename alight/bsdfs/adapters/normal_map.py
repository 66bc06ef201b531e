r"""Normal map: replaces the surface's normals by those of a picture.

.. math:: n \propto (c\,(2 r - 1),\; c\,(2 g - 1),\; 2 b - 1)

with the picture's channels r, g, b (read as they are, without a decoding of colours) and the scale
c. x runs along growing u, y along growing v of the picture (of its `uv_set`, after its `to_uv`), z
along the surface's normal, on charts that are mirrored too; with `follow_uv` off, x runs along the
surface's own u, and y is always z times x, as Mitsuba has it. See
`alight.bsdfs.normals.shading_normals` for the rims. Of several maps on one material the innermost
one counts. A coat of `principled` that has normals of its own, or those of the surface, does not
follow (`clearcoat_normal`).

Source: Blinn 1978, Simulation of wrinkled surfaces; glTF 2.0, section 3.9.3, for the scale; the
plug-in ``normalmap`` of Mitsuba 3.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.disney.principled import Principled
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part
from alight.bsdfs.normals.shading_normals import (
    FOLLOWS_UV,
    NORMALS,
    OF_SET,
    TURNED,
    NormalMapRow,
    map_features,
    packed_modes,
)
from alight.bsdfs.normals.tangent_space import UNTURNED, set_of, turn_of
from alight.bsdfs.plastics.plastic import Plastic
from alight.core.field_types import ColorTexture, NestedBsdf, Number
from alight.core.fields import Truth
from alight.core.parameters import slots_of


class NormalMap(Nested):
    """Wrapper that gives a material other normals.

    Parameters
    ----------
    texture : ColorTexture, default (0.5, 0.5, 1)
        The normals; a bitmap needs ``color_space: linear`` if it has 8 or 16 bits.
    scale : float, default 1
        Factor of the slopes; below 0 hills become hollows.
    rims : {"lit", "folded", "black"}, default "lit"
        What to do with normals that turn away from the viewer.
    fading : bool, default True
        Whether light fades out towards the line where the true surface turns away from it.
    follow_uv : bool, default True
        Whether x and y run along the picture's sides; else x along the surface's u, y to its left.
    bsdf : Bsdf or str, default Diffuse()
        The material, or its name.
    """

    bends_normals: ClassVar[bool] = True
    type: Literal["normal_map"] = "normal_map"
    texture: ColorTexture = (0.5, 0.5, 1.0)
    scale: Number = 1.0
    rims: Literal["lit", "folded", "black"] = "lit"
    fading: Truth = True
    follow_uv: Truth = True
    bsdf: NestedBsdf = Diffuse()

    @property
    def parts(self) -> tuple[Part, ...]:
        """The material."""
        return (Part(self.bsdf),)


EXAMPLES = (
    NormalMap(texture=(0.65, 0.4, 0.9), bsdf=Diffuse(reflectance=1.0)),
    NormalMap(texture=(0.8, 0.5, 0.7), rims="black", bsdf=Diffuse(reflectance=(0.9, 0.5, 0.1))),
    NormalMap(texture=(0.3, 0.6, 0.9), rims="folded", bsdf=RoughConductor(alpha=0.3)),
    NormalMap(texture=(0.6, 0.6, 0.9), scale=0.5, bsdf=Plastic(diffuse_reflectance=1.0)),
    NormalMap(texture=(0.75, 0.4, 0.85), bsdf=Principled(
        base_color=(0.8, 0.4, 0.1), clearcoat=0.8, clearcoat_roughness=0.4, sheen_color=0.2,
        clearcoat_normal=(0.35, 0.55, 0.9))),
)  # fmt: skip

SLOTS = slots_of(NormalMapRow)


def pack(spec: NormalMap, packer) -> None:
    """Fill the row of the map."""
    packer.color("texture", spec.texture)
    packer.numbers("scale", spec.scale)
    packer.numbers("modes", _modes(spec))
    packer.numbers("turn", *_turn(spec))


def _modes(spec: NormalMap) -> float:
    return packed_modes(spec) + FOLLOWS_UV * spec.follow_uv + OF_SET * set_of(spec.texture)


def _turn(spec: NormalMap) -> tuple[float, float, float]:
    return turn_of(spec.texture) if spec.follow_uv else UNTURNED


def features(spec: NormalMap) -> tuple[str, ...]:
    """What must be compiled for this map."""
    turned = (TURNED,) if _turn(spec) != UNTURNED else ()
    return (NORMALS, *map_features(spec), *turned)
