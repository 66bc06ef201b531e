"""Constant texture: one colour everywhere, for naming a colour that many materials share."""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.core.field_types import Reflectance, Triple
from alight.core.spec import Texture


class Constant(Texture):
    """The same colour everywhere.

    Parameters
    ----------
    color : Reflectance, default 0.5
        Linear sRGB, each channel in [0, 1].
    """

    varies: ClassVar[bool] = False
    type: Literal["constant"] = "constant"
    color: Reflectance = (0.5, 0.5, 0.5)

    def maximum(self) -> Triple:
        """Largest value of each channel."""
        return self.color


EXAMPLES = (Constant(), Constant(color=(0.9, 0.5, 0.1)), Constant(color=0.0))
