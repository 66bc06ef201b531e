r"""Blend of two materials by a weight that may be a texture.

.. math:: f(\omega_o, \omega_i) = (1 - w)\, f_0(\omega_o, \omega_i) + w\, f_1(\omega_o, \omega_i)

One part is chosen with its weight as probability and sampled; the density of the direction is that
of both parts together, so that a narrow lobe of one does not make the other noisy.

Source: Veach and Guibas, Optimally combining sampling techniques, SIGGRAPH 1995 (one-sample model);
the plug-in ``blendbsdf`` of Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.bsdfs.conductors.mirror import Mirror
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part
from alight.core.field_types import NestedBsdfs, UnitTexture


class Blend(Nested):
    """Mixture of two materials.

    Parameters
    ----------
    weight : UnitTexture, default 0.5
        Part of the second material, in [0, 1].
    bsdfs : (2,) Bsdf or str, default (Diffuse(), Mirror())
        The materials, or their names. Together with all that they hold they must not be more than
        `alight.bsdfs.nesting.MOST_LEAVES`.
    """

    weight_field: ClassVar[str] = "weight"
    type: Literal["blend"] = "blend"
    weight: UnitTexture = 0.5
    bsdfs: NestedBsdfs = (Diffuse(), Mirror())

    @property
    def parts(self) -> tuple[Part, ...]:
        """Both materials."""
        return Part(self.bsdfs[0], "rest"), Part(self.bsdfs[1], "weight")


EXAMPLES = (
    Blend(),
    Blend(weight=0.25, bsdfs=(Diffuse(reflectance=1.0), Diffuse(reflectance=(0.9, 0.5, 0.1)))),
)

# Its row holds the weight; the materials have rows of their own.
SLOTS = {"weight": 1}


def pack(spec: Blend, packer) -> None:
    """Fill the row of one material."""
    packer.scalar("weight", spec.weight)
