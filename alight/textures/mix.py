r"""Mixture of two textures by a weight.

.. math:: c = (1 - w)\, a + w\, b

A weight that varies is the luminance of its texture. (a - b)(1 - w) + b is what is computed, so
that weights 0 and 1 give a to the rounding of float32, and b exactly.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.core.constants import LUMINANCE
from alight.core.field_types import RadianceTexture, Triple, UnitTexture
from alight.core.vec import luminance
from alight.textures.checkerboard import Checkerboard
from alight.textures.nesting import Composed, Value, average, most
from lanewise.jit import kernel


class Mix(Composed):
    """Mixture of two textures.

    Parameters
    ----------
    a, b : RadianceTexture, defaults 0 and 1
        What is seen where the weight is 0, and where it is 1.
    weight : UnitTexture, default 0.5
        Part of `b`, in [0, 1].
    """

    fields: ClassVar[tuple[str, ...]] = ("a", "b", "weight")
    type: Literal["mix"] = "mix"
    a: RadianceTexture = (0.0, 0.0, 0.0)
    b: RadianceTexture = (1.0, 1.0, 1.0)
    weight: UnitTexture = 0.5

    def maximum(self) -> Triple:
        """The larger one of each channel."""
        red, green, blue = (max(pair) for pair in zip(most(self.a), most(self.b), strict=True))
        return red, green, blue

    def mean(self) -> Triple:
        """Mixture of the means: right where weight and textures vary independently."""
        share = _grey(average(self.weight))
        pairs = zip(average(self.a), average(self.b), strict=True)
        red, green, blue = ((1.0 - share) * a + share * b for a, b in pairs)
        return red, green, blue


def _grey(color: Value) -> float:
    red, green, blue = most(color)
    return LUMINANCE[0] * red + LUMINANCE[1] * green + LUMINANCE[2] * blue


EXAMPLES = (
    Mix(),
    Mix(a=(0.9, 0.1, 0.0), b=Checkerboard(scale=3.0), weight=0.25),
    Mix(a=0.9, b=0.1, weight=Checkerboard(color0=0.0, color1=1.0, scale=4.0)),
)


@kernel
def operate(params, a, b, weight):
    """The mixture."""
    return b + (a - b) * (1.0 - luminance(weight))
