"""What readers make of textures: pictures, their channels, and sums and products with numbers.

A value is a number, a colour (a list of three numbers) or the description of a texture.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from alight.core.fields import invalid
from alight.outputs.texels import decode_texels
from alight.textures.images import Image, as_image, size_problem

Data = dict[str, Any]
_SQUARES = np.indices((8, 8)).sum(axis=0) % 2 == 0
#: Stands for a picture of colours that is missing: squares of magenta and black.
MISSING = Image(np.where(_SQUARES[..., None], [255, 0, 255], 0).astype(np.uint8))
#: What takes the place of missing files, as a remark says it.
CHECKERED = "squares of magenta and black stand for it"
FLAT = "an even value of 0.5, or a flat normal map, stands for it"
WITHOUT = "the material does without"
DARK = "an even grey sky stands for it"
#: Radiance of a sky whose picture is missing.
GREY_SKY = [0.5] * 3
#: An even picture of numbers: flat as a normal map, the middle of all else.
LEVEL = [0.5, 0.5, 1.0]
#: Normals that are bent nowhere.
FLAT_NORMAL = [0.5, 0.5, 1.0]


def packed_picture(data: bytes | memoryview, tell: Callable[[str], None]) -> Image:
    """Decode a picture that lies inside of another file.

    Parameters
    ----------
    data : bytes or memoryview
        PNG, JPEG or another format that `decode_texels` reads.
    tell : callable
        Told what was changed.

    Raises
    ------
    PydanticCustomError
        If it is larger than textures may be; the size is looked at before it is decoded.
    OSError, ValueError
        If it is broken.
    """
    texels = decode_texels(data, _check_size, tell)
    texels.setflags(write=False)
    return as_image(texels)


def _check_size(width: int, height: int) -> None:
    problem = size_problem(width, height)
    if problem:
        raise invalid(problem)


def bitmap(picture: str | Image, space: str = "auto") -> Data:
    """A picture, by the name of its file or with its texels, in a colour space."""
    data: Data = {"type": "bitmap"}
    data |= {"file": picture} if isinstance(picture, str) else {"pixels": picture}
    return data if space == "auto" else data | {"color_space": space}


def wrapped(u: str, v: str) -> Data:
    """The keys for what is beyond the edges of a picture along u and v."""
    return {"wrap": u} if u == v else {"wrap": u, "wrap_v": v}


def channel(texture: Data, name: str) -> Data:
    """One channel of a texture: r, g, b or a."""
    return {"type": "channel", "texture": texture, "channel": name}


def scaled(factor: float, texture: Data | None, of: str) -> Any:
    """A number times a channel of a texture."""
    if texture is None or factor == 0.0:
        return factor
    return multiplied(factor, channel(texture, of))


def complement(value: float | Data) -> Any:
    """1 minus a number or a texture."""
    if isinstance(value, float):
        return 1.0 - value
    return between(1.0, 0.0, value)


def between(low: float, high: float, share: Data) -> Data:
    """From one number where a texture is 0 to another where it is 1."""
    return {"type": "mix", "a": low, "b": high, "weight": share}


def cut(value: float | Data, cutoff: float) -> Any:
    """1 where a number or texture reaches the cutoff, 0 elsewhere."""
    if isinstance(value, float):
        return float(value >= cutoff)
    return {"type": "threshold", "texture": value, "cutoff": cutoff}


def multiplied(factor: Any, texture: Data | None) -> Any:
    """A number or colour times a texture; the factor itself where there is no texture."""
    if texture is None:
        return factor
    is_one = set(factor) == {1.0} if isinstance(factor, list) else factor == 1.0
    return texture if is_one else {"type": "multiply", "a": factor, "b": texture}


def by_vertices(color: Any) -> Data:
    """A colour or texture times the colours of the vertices, where there are any."""
    return multiplied(color, {"type": "vertex_color", "fallback": 1.0})


def shifted(texture: Data, bias: float | list[float]) -> Data:
    """A texture plus a number or colour."""
    is_zero = set(bias) == {0.0} if isinstance(bias, list) else bias == 0.0
    return texture if is_zero else {"type": "add", "a": texture, "b": bias}


def ranging(texture: Data, low: float, high: float) -> Data:
    """A grey texture from `low`, where it is 0, to `high`, where it is 1."""
    if high < low:
        # No factor may be negative, but a mixture may fall.
        return between(low, high, texture)
    return shifted(multiplied(high - low, texture), low)


def stretched(texture: Data, low: Sequence[float], high: Sequence[float]) -> Data:
    """A texture whose channels run from `low`, where they are 0, to `high`, where they are 1."""
    rises = [above - below for below, above in zip(low, high, strict=True)]
    if min(rises) >= 0.0:
        return shifted(multiplied(rises, texture), list(low))
    parts = [
        multiplied([float(i == k) for i in range(3)], ranging(channel(texture, c), low[k], high[k]))
        for k, c in enumerate("rgb")
    ]
    return {"type": "add", "a": {"type": "add", "a": parts[0], "b": parts[1]}, "b": parts[2]}


def normal_color(normal: Sequence[float]) -> list[float]:
    """The colour by which a normal map bends everywhere to a normal of any length."""
    size = max(1.0, *(abs(part) for part in normal))
    return [0.5 * (part / size + 1.0) for part in normal]


def normals(texture: Data, factor: Sequence[float], bias: Sequence[float]) -> Data:
    """The colours by which a normal map bends as `factor` times a texture plus `bias` points.

    A map takes 2 t - 1 for a normal of any length; so what it is given is (n / m + 1) / 2, with the
    largest size m of any part of n, which keeps it in [0, 1].
    """
    ends = [(b, f + b) for f, b in zip(factor, bias, strict=True)]
    size = max(1.0, *(abs(end) for pair in ends for end in pair))
    low, high = ([0.5 * (end / size + 1.0) for end in part] for part in zip(*ends, strict=True))
    return stretched(texture, low, high)


def product(color: Any, share: float | Data) -> Any:
    """A colour times a part of it, either of which may be a texture."""
    if isinstance(share, dict):
        return multiplied(color, share)
    if share == 1.0:
        return color
    if isinstance(color, list):
        return [share * channel for channel in color]
    if color["type"] == "multiply" and isinstance(color["a"], list):
        return {**color, "a": [share * channel for channel in color["a"]]}
    return multiplied([share] * 3, color)
