r"""Makes a one-sided surface look the same from both sides.

.. math::
    f(\omega_o, \omega_i) = f_\text{nested}(|\omega_{o,z}|, |\omega_{i,z}|)
    \quad \text{if both are on one side, else } 0

Directions below the surface are mirrored at it before the nested model sees them. Models that let
light through have two sides already and are refused; the holes of a mask are not, they are holes
from both sides.

Source: the plug-in ``twosided`` of Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import model_validator

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part, find_transmissive
from alight.core.field_types import NestedBsdf
from alight.core.fields import invalid


class TwoSided(Nested):
    """Wrapper that gives a surface a back like its front.

    Parameters
    ----------
    bsdf : Bsdf or str, default Diffuse()
        What both sides look like: a model that reflects only, or the name of one.
    """

    makes_two_sided: ClassVar[bool] = True
    type: Literal["two_sided"] = "two_sided"
    bsdf: NestedBsdf = Diffuse()

    @model_validator(mode="after")
    def _nested_reflects_only(self) -> Self:
        if isinstance(self.bsdf, TwoSided):
            raise invalid("bsdf must not be two_sided itself")
        found = find_transmissive(self.bsdf, {})
        if found is not None:
            raise invalid(f'bsdf "{found.type_name()}" has two sides already: use it alone')
        return self

    @property
    def parts(self) -> tuple[Part, ...]:
        """The material of both sides."""
        return (Part(self.bsdf),)


EXAMPLES = (
    TwoSided(),
    TwoSided(bsdf=Diffuse(reflectance=(0.9, 0.5, 0.1), sampling="uniform")),
    TwoSided(bsdf=Blend(weight=0.3)),
)
