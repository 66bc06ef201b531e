r"""Gives a one-sided surface a back: one that looks like its front, or another material.

.. math::
    f(\omega_o, \omega_i) = f_\text{side}(|\omega_{o,z}|, |\omega_{i,z}|)
    \quad \text{if both are on one side, else } 0

Directions below the surface are mirrored at it before the nested model sees them. Models that let
light through have two sides already and are refused. The holes of a mask are holes from both sides:
where the sides differ, the mask belongs around them.

Source: the plug-in ``twosided`` of Mitsuba 3 (https://mitsuba.readthedocs.io).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal, Self

from pydantic import model_validator

from alight.bsdfs.adapters.blend import Blend
from alight.bsdfs.matte.diffuse import Diffuse
from alight.bsdfs.nesting import Nested, Part, find_transmissive, has_holes
from alight.bsdfs.plastics.phong import Phong
from alight.core.field_types import NestedBsdf
from alight.core.fields import invalid
from alight.core.spec import Bsdf


class TwoSided(Nested):
    """Wrapper that gives a surface a back.

    Parameters
    ----------
    bsdf : Bsdf or str, default Diffuse()
        What both sides look like: a model that reflects only, or the name of one.
    back : Bsdf or str, optional
        What the back looks like instead; likewise.
    """

    makes_two_sided: ClassVar[bool] = True
    type: Literal["two_sided"] = "two_sided"
    bsdf: NestedBsdf = Diffuse()
    back: NestedBsdf | None = None

    @model_validator(mode="after")
    def _nested_reflects_only(self) -> Self:
        for name, nested in (("bsdf", self.bsdf), ("back", self.back)):
            if isinstance(nested, TwoSided):
                raise invalid(f"{name} must not be two_sided itself")
            problem = None if nested is None else self.problem_of(nested, {})
            if problem:
                raise invalid(f"{name} {problem}")
        return self

    def problem_of(self, nested: Bsdf | str, known: Mapping[str, Bsdf]) -> str | None:
        """Say why a material can be no side of this one; names that are not known pass."""
        called = f'"{nested}" ' if isinstance(nested, str) else ""
        found = find_transmissive(nested, known)
        if found is not None:
            name = f'"{found.type_name()}"'
            name = f"{called}({found.type_name()})" if called else name
            return f"{name} has two sides already: use it alone"
        if self.back is not None and has_holes(nested, known):
            return f"{called}has holes, which are holes from both sides: put the mask around both"
        return None

    @property
    def parts(self) -> tuple[Part, ...]:
        """The material of both sides, or that of each."""
        if self.back is None:
            return (Part(self.bsdf),)
        return Part(self.bsdf, side="front"), Part(self.back, side="back")


EXAMPLES = (
    TwoSided(),
    TwoSided(bsdf=Diffuse(reflectance=(0.9, 0.5, 0.1), sampling="uniform")),
    TwoSided(bsdf=Blend(weight=0.3)),
    TwoSided(bsdf=Phong(exponent=8.0), back=Blend(weight=0.3)),
)
