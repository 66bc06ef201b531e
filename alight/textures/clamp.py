r"""Clamp: a texture whose values end at a limit, channel by channel.

.. math:: c = \min(t, \text{high})

Shares of light must not exceed 1. Other programs multiply pictures by factors above 1 and cut what
comes out; here that is said.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.core.field_types import NonNegative, RadianceTexture, Triple
from alight.core.parameters import loader, slots_of
from alight.core.vec import Vec3
from alight.textures.checkerboard import Checkerboard
from alight.textures.model import Number
from alight.textures.multiply import Multiply
from alight.textures.nesting import Composed, average, most
from lanewise.jit import kernel
from lanewise.simd import minimum


class Clamp(Composed):
    """Texture with a largest value.

    Parameters
    ----------
    texture : RadianceTexture
        Texture, or its name.
    high : float >= 0, default 1
        Largest value that is left.
    """

    fields: ClassVar[tuple[str, ...]] = ("texture",)
    type: Literal["clamp"] = "clamp"
    texture: RadianceTexture
    high: NonNegative = 1.0

    def maximum(self) -> Triple:
        """The limit, or the texture's largest value below it."""
        return self._below(most(self.texture))

    def mean(self) -> Triple:
        """The texture's mean, which is too large where much is cut."""
        return self._below(average(self.texture))

    def _below(self, value: Triple) -> Triple:
        red, green, blue = (min(channel, self.high) for channel in value)
        return red, green, blue


EXAMPLES = (
    Clamp(texture=Multiply(a=Checkerboard(color0=(0.9, 0.5, 0.1)), b=1.5)),
    Clamp(texture=Checkerboard(), high=0.3),
    Clamp(texture=2.0),
)


class Params(NamedTuple):
    """A row of the table."""

    high: Number


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Clamp, packer) -> None:
    """Fill the row of one texture."""
    packer.numbers("high", spec.high)


@kernel
def operate(params, color):
    """The colour, cut in each channel."""
    high = params.high
    return Vec3(minimum(color.x, high), minimum(color.y, high), minimum(color.z, high))
