"""Pictures computed anew, texel by texel, where no texture of alight computes the same.

That is exact at the centres of texels, and needs that all pictures of an expression lie on the
surface in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import SceneError
from alight.formats.materials.textures import channel
from alight.formats.materialx.values import Data, Plain, Value, Varying
from alight.scene.files import Files
from alight.scene.images import picture
from alight.textures.images import Image

Rows = NDArray[np.float64]
#: Texels of the largest picture that is computed anew, and of what is in memory at a time.
MOST_TEXELS, AT_A_TIME = 2**24, 2**18
#: Largest number that a picture may hold, and least: texels are counted from the least one on, and
#: where one is divided by nothing the float32 of the others must still tell them apart.
_LARGEST, _LEAST = 1e15, -1e4
_MAPPING = ("to_uv", "wrap", "wrap_v", "uv_set", "interpolation")


class NotBakedError(ValueError):
    """An expression that holds more than pictures that lie alike."""


def baked(function: Callable[..., Rows], values: list[Value], files: Files, width: int) -> Varying:
    """The picture of what a function makes of values.

    Parameters
    ----------
    function : callable
        Of `alight.formats.materialx.pointwise`.
    values : list of Value
        Of the same number of channels, or of one.
    files : Files
        Reads pictures.
    width : int
        Channels that are wanted: 1 or 3.

    Raises
    ------
    NotBakedError
        If the values hold patterns, or pictures that lie in different ways.
    """
    bitmaps = [b for v in values if isinstance(v, Varying) for b in _bitmaps(v.texture)]
    if not bitmaps:
        raise NotBakedError("there is no picture")
    first = bitmaps[0]
    mapping = {key: first[key] for key in _MAPPING if key in first}
    images = {}
    for bitmap in bitmaps:
        if {key: bitmap[key] for key in _MAPPING if key in bitmap} != mapping:
            raise NotBakedError("pictures lie in different ways")
        images[_key(bitmap)] = _image(bitmap, files)
    sizes = {(image.height, image.width) for image in images.values()}
    if len(sizes) > 1:
        raise NotBakedError("pictures have different sizes")
    ((height, columns),) = sizes
    if height * columns > MOST_TEXELS:
        raise NotBakedError(f"pictures of more than {MOST_TEXELS} texels are not computed anew")
    result = np.zeros((height, columns, 1 if width == 1 else 3), np.float32)
    step = max(1, AT_A_TIME // columns)
    for start in range(0, height, step):
        rows = slice(start, min(start + step, height))
        texels = {key: _texels(image, rows) for key, image in images.items()}
        count = (rows.stop - rows.start) * columns
        arrays = [_value(value, texels, count) for value in values]
        with np.errstate(all="ignore"):
            found = np.broadcast_to(function(*arrays), (count, max(a.shape[1] for a in arrays)))
        found = np.clip(np.nan_to_num(found), _LEAST, _LARGEST)[:, : result.shape[2]]
        if 1 < found.shape[1] < result.shape[2]:
            found = np.pad(found, ((0, 0), (0, result.shape[2] - found.shape[1])))
        result[rows] = found.reshape(rows.stop - rows.start, columns, -1)
    low = min(float(result.min()), 0.0)
    if low < 0.0:
        result -= np.float32(low)
    pixels = Image(np.ascontiguousarray(result))
    data: Data = {"type": "bitmap", "pixels": pixels, "color_space": "linear", **mapping}
    kept = 1 if width == 1 else 3
    texture = channel(data, "r") if kept == 1 else data
    most = max(float(result.max()), 1e-9)
    return Varying(texture, (1.0,) * kept, (low,) * kept, most, None, kept == 1)


def _bitmaps(texture: Any) -> Iterator[Data]:
    if not isinstance(texture, dict):
        return
    if texture["type"] == "bitmap":
        yield texture
        return
    if texture["type"] not in ("channel", "multiply", "add", "mix", "clamp", "threshold"):
        raise NotBakedError(f"{texture['type']} is no picture")
    for key in ("texture", "a", "b", "weight"):
        if key in texture:
            yield from _bitmaps(texture[key])


def texels_of(texture: Data) -> int:
    """How many texels a picture has that was computed."""
    image = next(_bitmaps(texture))["pixels"]
    return image.width * image.height


def _key(bitmap: Data) -> tuple[Any, str]:
    return bitmap.get("pixels") or bitmap["file"], bitmap.get("color_space", "auto")


def _image(bitmap: Data, files: Files) -> Image:
    """Linear texels, decoded where they are used."""
    try:
        image = bitmap.get("pixels") or picture(bitmap["file"], files)
    except SceneError:
        # Building the scene reports it.
        raise NotBakedError("a picture cannot be read") from None
    return image


def _texels(image: Image, rows: slice) -> Image:
    alpha = None if image.alpha is None else np.ascontiguousarray(image.alpha[rows])
    return Image(np.ascontiguousarray(image.texels[rows]), alpha)


def _value(value: Value, texels: dict[Any, Image], count: int) -> Rows:
    if isinstance(value, Plain):
        return np.broadcast_to(np.array(value.numbers), (count, value.width))
    rows = _evaluated(value.texture, texels)
    wide = np.broadcast_to(rows, (count, max(rows.shape[1], value.width)))[:, : value.width]
    return wide * np.array(value.factor) + np.array(value.offset)


def _evaluated(texture: Any, texels: dict[Any, Image]) -> Rows:
    """What a texture shows at each texel, shape (n, 1) or (n, 3)."""
    if not isinstance(texture, dict):
        return np.array(texture, np.float64).reshape(1, -1)
    kind = texture["type"]
    if kind == "bitmap":
        image = texels[_key(texture)]
        linear = image.linear(texture.get("color_space", "auto"))
        return linear.reshape(-1, linear.shape[2]).astype(np.float64)
    if kind == "channel" and texture["channel"] == "a":
        return _opacity(texels[_key(texture["texture"])])
    if kind == "channel":
        rows = _evaluated(texture["texture"], texels)
        return rows[:, [min("rgb".index(texture["channel"]), rows.shape[1] - 1)]]
    if kind == "clamp":
        return np.minimum(_evaluated(texture["texture"], texels), texture.get("high", 1.0))
    if kind == "threshold":
        rows = _evaluated(texture["texture"], texels)
        return (rows >= texture["cutoff"]).astype(np.float64)
    a, b = _evaluated(texture["a"], texels), _evaluated(texture["b"], texels)
    if kind == "mix":
        share = _evaluated(texture["weight"], texels)[:, :1]
        return (a - b) * (1.0 - share) + b
    return a * b if kind == "multiply" else a + b


def _opacity(image: Image) -> Rows:
    if image.alpha is None:
        return np.ones((image.width * image.height, 1))
    return image.alpha.reshape(-1, 1) / float(image.levels)
