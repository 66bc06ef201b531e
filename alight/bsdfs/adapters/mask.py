r"""Mask: a material with holes, through which light passes straight on.

.. math:: f(\omega_o, \omega_i) = \alpha f_\text{nested}(\omega_o, \omega_i)
    + (1 - \alpha)\, f_\text{null}(\omega_o, \omega_i)

The opacity alpha may be a texture (leaves, fences); between 0 and 1 the surface is a veil. Paths go
through the holes, and rays that look for a light are dimmed by them. For `path` and `direct` a hole
is the end of an edge, as any surface; `volpath` does not count it.

Source: the plug-in ``mask`` of Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.dielectrics.null import Null
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part
from alight.core.field_types import NestedBsdf, UnitTexture


class Mask(Nested):
    """Material with holes.

    Parameters
    ----------
    opacity : UnitTexture, default 0.5
        Part of the light that meets the material, in [0, 1].
    bsdf : Bsdf or str, default Diffuse()
        The material, or its name.
    """

    weight_field: ClassVar[str] = "opacity"
    transmissive = True
    type: Literal["mask"] = "mask"
    opacity: UnitTexture = 0.5
    bsdf: NestedBsdf = Diffuse()

    @property
    def parts(self) -> tuple[Part, ...]:
        """The holes and the material."""
        return Part(Null(), "rest", is_hole=True), Part(self.bsdf, "weight")


EXAMPLES = (Mask(), Mask(opacity=0.8, bsdf=Diffuse(reflectance=1.0)))

# Its row holds the opacity; the material has a row of its own.
SLOTS = {"opacity": 1}


def pack(spec: Mask, packer) -> None:
    """Fill the row of one material."""
    packer.scalar("opacity", spec.opacity)
