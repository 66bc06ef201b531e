r"""Sum of two textures, channel by channel.

.. math:: c = a + b
"""

from __future__ import annotations

from typing import ClassVar, Literal

from alight.core.field_types import RadianceTexture, Triple
from alight.core.spec import Texture
from alight.textures.checkerboard import Checkerboard
from alight.textures.nesting import Composed, average, most
from lanewise.jit import kernel


class Add(Composed):
    """Sum of two textures.

    Parameters
    ----------
    a, b : RadianceTexture, default 0
        Textures, names of them, colours or numbers.
    """

    commutes: ClassVar[bool] = True
    type: Literal["add"] = "add"
    a: RadianceTexture = (0.0, 0.0, 0.0)
    b: RadianceTexture = (0.0, 0.0, 0.0)

    def maximum(self) -> Triple:
        """Sum of the largest values, which no value exceeds."""
        return _sum(most(self.a), most(self.b))

    def mean(self) -> Triple:
        """Mean of each channel."""
        return _sum(average(self.a), average(self.b))

    @property
    def mean_is_exact(self) -> bool:
        """Where those of both parts are."""
        return all(not isinstance(p, Texture) or p.mean_is_exact for p in self.parts)


def _sum(a: Triple, b: Triple) -> Triple:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


EXAMPLES = (Add(), Add(a=Checkerboard(scale=4.0), b=(0.1, 0.5, 0.0)))


@kernel
def operate(params, a, b):
    """The sum."""
    return a + b
