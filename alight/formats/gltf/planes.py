"""Numbers that vary over a surface, taken apart into a factor and one channel of a picture.

glTF has a number as factor times a channel, and keeps several of them in one picture.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.constants import LUMINANCE
from alight.textures.bitmap import Bitmap
from alight.textures.channel import CHANNELS, Channel
from alight.textures.checkerboard import Checkerboard
from alight.textures.multiply import Multiply

#: The channel of a picture that is used as a number: its luminance.
ALL = "all"


class Plane(NamedTuple):
    """A factor times a channel of a picture: "r", "g", "b", "a", or `ALL`."""

    factor: float
    spec: Bitmap
    channel: str

    @property
    def is_plain(self) -> bool:
        """Whether the texels of its picture are linear bytes already."""
        image = self.spec.pixels
        assert image is not None
        coded = image.is_encoded(self.spec.color_space)
        return image.levels == 255 and (self.channel == "a" or not coded)

    def values(self) -> NDArray[np.float64]:
        """The channel, linear: (h, w), factor not applied."""
        image = self.spec.pixels
        assert image is not None
        if self.channel == "a":
            assert image.alpha is not None
            return image.alpha / float(image.levels)
        linear = image.linear(self.spec.color_space).astype(np.float64)
        linear = np.broadcast_to(linear, (*linear.shape[:2], 3))
        return linear @ LUMINANCE if self.channel == ALL else linear[..., "rgb".index(self.channel)]

    def within_one(self) -> Plane:
        """The same with a factor of at most 1: what is above goes into the texels."""
        if self.factor <= 1.0:
            return self
        return Plane(1.0, self._pictured(lambda values: self.factor * values), ALL)

    def texture(self, curve: Callable[[Any], Any]) -> Any:
        """It as a texture, with a curve applied to the texels."""
        picture = self._pictured(curve)
        return Multiply(a=self.factor, b=picture) if self.factor != 1.0 else picture

    def _pictured(self, curve: Callable[[Any], Any]) -> Bitmap:
        texels = np.rint(255.0 * np.clip(curve(self.values()), 0.0, 1.0)).astype(np.uint8)
        return self.spec.replaced(file=None, pixels=texels, color_space="linear")


def placed_alike(a: Bitmap, b: Bitmap) -> bool:
    """Whether two pictures of one size cover a surface alike."""
    assert a.pixels is not None and b.pixels is not None
    sizes = [(spec.pixels.width, spec.pixels.height) for spec in (a, b) if spec.pixels]
    return sizes[0] == sizes[1] and placement(a) == placement(b)


def placement(spec: Bitmap) -> tuple[Any, ...]:
    """How a picture covers a surface."""
    matrix = tuple(spec.to_uv.matrix.ravel().tolist())
    return spec.wrap, spec.wrap_v or spec.wrap, spec.interpolation, matrix, spec.uv_set


def factors_of(value: Any) -> tuple[NDArray[np.float64], list[Any]]:
    """The constant part of a product (three channels), and its textures."""
    if isinstance(value, Multiply):
        (a, left), (b, right) = factors_of(value.a), factors_of(value.b)
        return a * b, left + right
    if isinstance(value, float | int | tuple):
        return np.ones(3) * np.array(value, np.float64), []
    return np.ones(3), [_squares(value) if isinstance(value, Checkerboard) else value]


def _squares(board: Checkerboard) -> Bitmap:
    """A checkerboard as a picture of four texels, its period."""
    colors = np.array([[board.color1, board.color0], [board.color0, board.color1]])
    return Bitmap(
        pixels=colors.astype(np.float32),
        interpolation="nearest",
        to_uv=[{"matrix": (0.5 * board.matrix).tolist()}],
        uv_set=board.uv_set,
    )


def plane_of(value: Any) -> Plane | float | None:
    """A number or a texture as a factor and a channel; None where it is more than that."""
    factor, textures = factors_of(value)
    if not textures:
        return float(factor[0]) if len(set(factor.tolist())) == 1 else float(factor @ LUMINANCE)
    if len(textures) > 1 or len(set(factor.tolist())) > 1:
        return None
    (texture,), scale = textures, float(factor[0])
    if isinstance(texture, Bitmap):
        return Plane(scale, texture, ALL)
    if not isinstance(texture, Channel):
        return None
    inner, parts = factors_of(texture.texture)
    index = CHANNELS.index(texture.channel)
    scale *= 1.0 if texture.channel == "a" else float(inner[index])
    if not parts:
        return scale
    if len(parts) > 1 or not isinstance(parts[0], Bitmap):
        return None
    (picture,) = parts
    if texture.channel == "a" and (picture.pixels is None or picture.pixels.alpha is None):
        return scale
    return Plane(scale, picture, texture.channel)
