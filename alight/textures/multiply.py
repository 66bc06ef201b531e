r"""Product of two textures, channel by channel.

.. math:: c = a\, b

With a number or colour for one of them it scales the other, as the factors of glTF do.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.core.field_types import RadianceTexture, Triple
from alight.textures.checkerboard import Checkerboard
from alight.textures.nesting import Composed, average, most
from lanewise.jit import kernel


class Multiply(Composed):
    """Product of two textures.

    Parameters
    ----------
    a, b : RadianceTexture, default 1
        Textures, names of them, colours or numbers.
    """

    commutes: ClassVar[bool] = True
    type: Literal["multiply"] = "multiply"
    a: RadianceTexture = (1.0, 1.0, 1.0)
    b: RadianceTexture = (1.0, 1.0, 1.0)

    def maximum(self) -> Triple:
        """Product of the largest values, which no value exceeds."""
        return _product(most(self.a), most(self.b))

    def mean(self) -> Triple:
        """Product of the means: right where the two vary independently of each other."""
        return _product(average(self.a), average(self.b))


def _product(a: Triple, b: Triple) -> Triple:
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


EXAMPLES = (
    Multiply(),
    Multiply(a=Checkerboard(scale=4.0), b=(0.9, 0.5, 0.1)),
    Multiply(a=0.5, b=Multiply(a=Checkerboard(scale=0.5), b=Checkerboard(scale=(3.0, 1.0)))),
)


@kernel
def operate(params, a, b):
    """The product."""
    return a * b
