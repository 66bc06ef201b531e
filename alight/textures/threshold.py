r"""Threshold: 1 where a texture reaches a value, 0 elsewhere, channel by channel.

.. math:: c = [\,t \ge \text{cutoff}\,]

Leaves cut out of a picture have their edges here, after the picture has been interpolated.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.core.field_types import NonNegative, RadianceTexture, Triple
from alight.core.parameters import loader, slots_of
from alight.core.vec import Vec3
from alight.textures.checkerboard import Checkerboard
from alight.textures.model import Number
from alight.textures.nesting import Composed, average, most
from lanewise.jit import kernel
from lanewise.simd import where


class Threshold(Composed):
    """Black and white by a limit.

    Parameters
    ----------
    texture : RadianceTexture
        Texture, or its name.
    cutoff : float >= 0, default 0.5
        Smallest value that becomes 1.
    """

    fields: ClassVar[tuple[str, ...]] = ("texture",)
    type: Literal["threshold"] = "threshold"
    texture: RadianceTexture
    cutoff: NonNegative = 0.5

    def maximum(self) -> Triple:
        """0 where no value reaches the cutoff, else 1."""
        red, green, blue = (float(c >= self.cutoff) for c in most(self.texture))
        return red, green, blue

    def mean(self) -> Triple:
        """The texture's mean, an estimate; above 0 where any value is."""
        pairs = zip(self.maximum(), average(self.texture), strict=True)
        red, green, blue = (high * min(max(mean, 0.01), 1.0) for high, mean in pairs)
        return red, green, blue


EXAMPLES = (
    Threshold(texture=Checkerboard(color0=(0.9, 0.5, 0.1), color1=(0.0, 0.2, 1.0))),
    Threshold(texture=Checkerboard(), cutoff=0.3),
    Threshold(texture=0.5, cutoff=0.75),
)


class Params(NamedTuple):
    """A row of the table."""

    cutoff: Number


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Threshold, packer) -> None:
    """Fill the row of one texture."""
    packer.numbers("cutoff", spec.cutoff)


@kernel
def operate(params, color):
    """1 or 0 in each channel."""
    cutoff = params.cutoff
    return Vec3(
        where(color.x >= cutoff, 1.0, 0.0),
        where(color.y >= cutoff, 1.0, 0.0),
        where(color.z >= cutoff, 1.0, 0.0),
    )
