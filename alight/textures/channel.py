"""One channel of a texture, as a grey.

Pictures that hold a quantity in each channel (glTF keeps roughness in green and metallic in blue)
are told apart with it. Alpha is read from bitmaps that have it, where it is linear always; other
textures are opaque.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.core.field_types import RadianceTexture, Triple
from alight.core.parameters import loader, slots_of
from alight.core.vec import Vec3
from alight.textures.bitmap import Bitmap
from alight.textures.checkerboard import Checkerboard
from alight.textures.images import Image
from alight.textures.model import Number
from alight.textures.nesting import Composed, Value, average, most
from lanewise.jit import kernel
from lanewise.simd import where

CHANNELS = ("r", "g", "b", "a")


class Channel(Composed):
    """One channel of a texture.

    Parameters
    ----------
    texture : RadianceTexture
        Texture, or its name.
    channel : {"r", "g", "b", "a"}, default "r"
        Which one; "a" is the opacity of a bitmap.
    """

    fields: ClassVar[tuple[str, ...]] = ("texture",)
    type: Literal["channel"] = "channel"
    texture: RadianceTexture
    channel: Literal["r", "g", "b", "a"] = "r"

    @property
    def parts(self) -> tuple[Value, ...]:
        """The texture, or the opacity alone as a grey picture."""
        if self.channel != "a":
            return (self.texture,)
        spec = self.texture
        if isinstance(spec, str) or (isinstance(spec, Bitmap) and spec.pixels is None):
            return (spec,)
        alpha = spec.pixels.alpha if isinstance(spec, Bitmap) and spec.pixels else None
        if alpha is None:
            return ((1.0, 1.0, 1.0),)
        assert isinstance(spec, Bitmap)
        return (spec.replaced(pixels=Image(alpha[..., None]), color_space="linear"),)

    def maximum(self) -> Triple:
        """Its largest value."""
        return self._grey(most(self.parts[0]))

    def mean(self) -> Triple:
        """Its mean."""
        return self._grey(average(self.parts[0]))

    def _grey(self, color: Triple) -> Triple:
        value = color[min(CHANNELS.index(self.channel), 2)]
        return value, value, value


EXAMPLES = (
    Channel(texture=Checkerboard(color0=(0.9, 0.5, 0.1), color1=(0.0, 0.2, 1.0))),
    Channel(texture=Checkerboard(color0=(0.9, 0.5, 0.1), color1=(0.0, 0.2, 1.0)), channel="b"),
    Channel(texture=(0.2, 0.4, 0.6), channel="g"),
    Channel(texture=(0.2, 0.4, 0.6), channel="a"),
)


class Params(NamedTuple):
    """A row of the table."""

    index: Number


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Channel, packer) -> None:
    """Fill the row of one texture."""
    # A picture of the opacity is grey: any of its channels will do.
    packer.numbers("index", float(min(CHANNELS.index(spec.channel), 2)))


@kernel
def operate(params, color):
    """The channel three times."""
    index = params.index
    value = where(index == 0.0, color.x, where(index == 1.0, color.y, color.z))
    return Vec3(value, value, value)
