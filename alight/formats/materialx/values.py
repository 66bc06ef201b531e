r"""What a node gives: numbers, or a texture with a factor and a number for each of its channels.

.. math:: v_i = o_i + f_i\, t_i, \qquad 0 \le t_i \le m_i

Textures hold no negative numbers and are never divided; but sums with numbers, products with them,
and all mixtures of two numbers by a texture stay exact in this form, whatever their signs. It
becomes a texture of alight only where a material takes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from alight.formats.materials.textures import channel, ranging, stretched

Data = dict[str, Any]
_NAMES = "rgb"


@dataclass(frozen=True)
class Plain:
    """The same numbers everywhere, one for each channel."""

    numbers: tuple[float, ...]

    @property
    def width(self) -> int:
        """How many channels it has."""
        return len(self.numbers)

    @property
    def factor(self) -> tuple[float, ...]:
        """Of a texture that is not there."""
        return (0.0,) * self.width

    @property
    def offset(self) -> tuple[float, ...]:
        """The numbers."""
        return self.numbers


@dataclass(frozen=True)
class Varying:
    """A texture.

    Attributes
    ----------
    texture : dict
        Description of the native format; grey where there is one channel.
    factor, offset : tuple of float
        For each channel.
    most : float
        What no channel of the texture exceeds.
    alpha : Value or None
        A fourth channel; None stands for 1.
    is_grey : bool
        Whether the texture has one value for all channels.
    """

    texture: Data
    factor: tuple[float, ...]
    offset: tuple[float, ...]
    most: float = 1.0
    alpha: Value | None = None
    is_grey: bool = False

    @property
    def width(self) -> int:
        """How many channels it has, without the fourth."""
        return len(self.factor)

    @property
    def ends(self) -> list[tuple[float, float]]:
        """Lowest and highest value of each channel."""
        found = []
        for f, o in zip(self.factor, self.offset, strict=True):
            end = o if f == 0.0 else o + f * self.most
            found.append((min(o, end), max(o, end)))
        return found


Value = Plain | Varying


def number(value: float) -> Plain:
    """One number."""
    return Plain((float(value),))


def textured(texture: Data, width: int, most: float = 1.0, alpha: Value | None = None) -> Varying:
    """A texture as it is; a grey one where one channel is wanted."""
    return Varying(texture, (1.0,) * width, (0.0,) * width, most, alpha, width == 1)


def alpha_of(value: Value) -> Value:
    """The fourth channel: 1 where there is none."""
    if isinstance(value, Plain):
        return Plain(value.numbers[3:4] or (1.0,))
    return number(1.0) if value.alpha is None else value.alpha


def channels_of(value: Value) -> int:
    """How many channels a value has, the fourth included."""
    return 4 if isinstance(value, Varying) and value.alpha is not None else value.width


def part(value: Value, index: int) -> Value:
    """One channel; the last one where there are fewer."""
    if isinstance(value, Plain):
        return Plain((value.numbers[min(index, value.width - 1)],))
    if index >= 3:
        return alpha_of(value)
    if value.width == 1:
        return replace(value, alpha=None)
    index = min(index, value.width - 1)
    grey = value.texture if value.is_grey else channel(value.texture, _NAMES[index])
    return Varying(grey, (value.factor[index],), (value.offset[index],), value.most, is_grey=True)


def spread(value: Value, width: int) -> Value:
    """As many channels as wanted, of what has one; the first ones of what has more.

    Of four channels the fourth of a texture stands apart.
    """
    if isinstance(value, Plain):
        numbers = value.numbers
        if len(numbers) == 1:
            return Plain(numbers * width)
        # What lacks an alpha is opaque.
        return Plain((*numbers, *(1.0,) * width)[:width])
    kept = min(width, 3)
    if value.width == 1 and kept > 1:
        alpha = value if width == 4 else None
        factor, offset = value.factor * kept, value.offset * kept
        return replace(value, factor=factor, offset=offset, alpha=alpha)
    if kept == 1 and value.width > 1:
        return part(value, 0)
    factor, offset = value.factor[:kept], value.offset[:kept]
    if len(factor) < kept:
        factor += (0.0,) * (kept - len(factor))
        offset += (0.0,) * (kept - len(offset))
    return replace(value, factor=factor, offset=offset, alpha=value.alpha if width == 4 else None)


def affine(value: Value, factor: Sequence[float], shift: Sequence[float]) -> Value:
    """A value times a number plus another, channel by channel; alpha counts as the fourth."""
    if isinstance(value, Plain):
        rows = zip(value.numbers, factor, shift, strict=False)
        return Plain(tuple(n * f + s for n, f, s in rows))
    alpha = value.alpha
    if alpha is not None and len(factor) > 3:
        alpha = affine(alpha, factor[3:4], shift[3:4])
    return replace(
        value,
        factor=tuple(a * b for a, b in zip(value.factor, factor, strict=False)),
        offset=tuple(a * b + s for a, b, s in zip(value.offset, factor, shift, strict=False)),
        alpha=alpha,
    )


def positive(value: Varying) -> Data:
    """The texture of a value that is nowhere negative, whatever its size.

    Where a channel falls as the texture grows, the texture must not exceed 1.
    """
    low = list(value.offset)
    high = [o + f for f, o in zip(value.factor, value.offset, strict=True)]
    if value.width == 1:
        return ranging(value.texture, low[0], high[0])
    low, high = ([*ends, *(0.0,) * 3][:3] for ends in (low, high))
    if value.is_grey and len(set(low)) == len(set(high)) == 1:
        return ranging(value.texture, low[0], high[0])
    if value.is_grey and value.most <= 1.0:
        return {"type": "mix", "a": low, "b": high, "weight": value.texture}
    return stretched(value.texture, low, high)


def is_positive(value: Varying) -> bool:
    """Whether `positive` gives its texture."""
    falls = min(value.factor) < 0.0
    return min(low for low, _ in value.ends) >= 0.0 and not (falls and value.most > 1.0)


def limited(value: Varying, high: float) -> Data:
    """The texture of a positive value, cut where it exceeds a limit."""
    texture = positive(value)
    if max(top for _, top in value.ends) <= high * (1.0 + 1e-6):
        return texture
    return {"type": "clamp", "texture": texture} | ({} if high == 1.0 else {"high": high})


def parts_of(texture: Any, most: int) -> int:
    """How many textures one is made of; beyond `most` nobody counts."""
    count, stack = 0, [texture]
    while stack and count <= most:
        found = stack.pop()
        if isinstance(found, dict):
            count += 1
            stack += [found[key] for key in ("texture", "a", "b", "weight") if key in found]
    return count
