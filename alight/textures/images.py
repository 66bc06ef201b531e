"""Pictures that descriptions hold: whole numbers or floats, checked once and never changed.

A description with the fields `file` (str or None) and `pixels` (`Pixels` or None) takes its picture
from either. Before a scene is compiled each file is read once, and the picture takes its place.

In scene files small pictures can be written out, top row first: numbers, which are linear,
``[[0.5, 1], [[1, 0, 0], 2]]``; or texts with one hexadecimal word for each texel,
``["ff8000 000000"]``, of 2, 6 or 8 digits (8 bits, grey, RGB or RGB and opacity) or twice as many
(16 bits).
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import core_schema

from alight.core.errors import show_value
from alight.core.field_types import Triple
from alight.core.fields import LARGEST, invalid
from alight.core.spec import Spec
from alight.core.srgb import decode_srgb

#: Limits of one picture: floats count its columns exactly, and it takes at most 0.8 GB.
MOST_SIDE, MOST_TEXELS = 2**16, 2**26

#: Sides of the tiles that texels lie in once compiled, see `alight.compiled.textures`.
TILE = 4


@dataclass(frozen=True, eq=False)
class Image:
    """A picture, top row first.

    Parameters
    ----------
    texels : (h, w, c) uint8, uint16 or float32
        Read-only; c is 1 (grey) or 3 (RGB). Floats are finite and in [0, 1e15].
    alpha : (h, w), type of the texels, optional
        Opacity, linear; None where all is opaque.

    Attributes
    ----------
    digest : str
        SHA-256 of texels, type and shape; pictures with equal digests are equal.
    """

    texels: NDArray[Any]
    alpha: NDArray[Any] | None = None
    digest: str = field(init=False)

    def __post_init__(self) -> None:
        """Freeze the texels."""
        self.texels.setflags(write=False)
        digest = hashlib.sha256(f"{self.texels.dtype}{self.texels.shape}".encode())
        digest.update(self.texels.data)
        if self.alpha is not None:
            self.alpha.setflags(write=False)
            digest.update(b"alpha")
            digest.update(self.alpha.data)
        object.__setattr__(self, "digest", digest.hexdigest())

    def __eq__(self, other: object) -> bool:
        """Compare the contents."""
        return isinstance(other, Image) and self.digest == other.digest

    def __hash__(self) -> int:
        """Hash the contents."""
        return hash(self.digest)

    def __repr__(self) -> str:
        """Name the contents, for messages and for the hash of a scene's content."""
        return f"Image({self.width}x{self.height}, {self.texels.dtype}, {self.digest})"

    @property
    def whole(self) -> NDArray[Any]:
        """The texels, with alpha as fourth channel where there is any."""
        if self.alpha is None:
            return self.texels
        spread = np.broadcast_to(self.texels, (self.height, self.width, 3))
        return np.concatenate([spread, self.alpha[..., None]], axis=2)

    @property
    def width(self) -> int:
        """Texels in a row."""
        return self.texels.shape[1]

    @property
    def height(self) -> int:
        """Rows."""
        return self.texels.shape[0]

    @property
    def levels(self) -> int:
        """Largest whole number that a texel can hold; 1 for floats."""
        kind = self.texels.dtype
        return int(np.iinfo(kind).max) if kind.kind == "u" else 1

    def is_encoded(self, color_space: str) -> bool:
        """Whether texels are sRGB-encoded: as said, or with "auto" if they are whole numbers."""
        return color_space == "srgb" or (color_space == "auto" and self.levels > 1)

    def linear(self, color_space: str = "auto") -> NDArray[np.float32]:
        """Decode all texels.

        Parameters
        ----------
        color_space : {"auto", "srgb", "linear"}

        Returns
        -------
        (h, w, c) float32
        """
        encoded = self.is_encoded(color_space)
        if self.levels > 1:
            return decoded_levels(self.levels, encoded)[self.texels]
        return decode_srgb(self.texels).astype(np.float32) if encoded else self.texels

    @cached_property
    def _largest(self) -> NDArray[Any]:
        # Along whole rows first: numbers side by side are compared many at a time.
        width, channels = self.texels.shape[1:]
        rows = self.texels.reshape(-1, width * channels).max(axis=0)
        return rows.reshape(1, width, channels).max(axis=1, keepdims=True)

    def maximum(self, color_space: str = "auto") -> Triple:
        """Largest linear value of each channel."""
        return _triple(Image(self._largest).linear(color_space)[0, 0])

    def mean(self, color_space: str = "auto") -> Triple:
        """Mean of each channel, linear."""
        return _triple(self.linear(color_space).mean(axis=(0, 1), dtype=np.float64))

    def plain(self) -> list[Any]:
        """Write the texels out as scene files hold them."""
        texels = self.whole
        if self.levels > 1:
            digits = 2 * texels.dtype.itemsize
            return [
                " ".join("".join(f"{c:0{digits}x}" for c in texel) for texel in row)
                for row in texels.tolist()
            ]
        rows = [[[float(str(c)) for c in texel] for texel in row] for row in texels]
        return [[t[0] if len(t) == 1 else t for t in row] for row in rows]


def _triple(channels: NDArray[Any]) -> Triple:
    red, green, blue = np.broadcast_to(channels, 3).tolist()
    return red, green, blue


def decoded_levels(levels: int, encoded: bool) -> NDArray[np.float32]:
    """Linear values of the whole numbers 0 to `levels`, sRGB-encoded or not."""
    values = np.arange(levels + 1) / levels
    return (decode_srgb(values) if encoded else values).astype(np.float32)


def as_image(value: object) -> Image:
    """Make a picture of an array, of nested lists, or of rows of hexadecimal words.

    Parameters
    ----------
    value : Image, array or list
        Shape (h, w) or (h, w, c), c from 1 to 4 (of 2 and 4 channels the last is alpha): uint8 and
        uint16 as they are, booleans as 0 and 255, floats as float32.

    Raises
    ------
    PydanticCustomError
        If it is no picture, too large, or holds numbers that are no amounts of light.
    """
    if isinstance(value, Image):
        return value
    if isinstance(value, list | tuple):
        value = _from_words(value) if value and isinstance(value[0], str) else _from_lists(value)
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "biuf":
        found = f"an array of {value.dtype}" if isinstance(value, np.ndarray) else show_value(value)
        raise invalid(f"must be an array of numbers, got {found}")
    array = value[..., None] if value.ndim == 2 else value
    if array.ndim != 3 or array.shape[2] not in (1, 2, 3, 4) or 0 in array.shape:
        raise invalid(f"must have the shape (h, w) or (h, w, 3), got {value.shape}")
    problem = size_problem(array.shape[1], array.shape[0])
    if problem:
        raise invalid(problem)
    return Image(_as_texels(array[..., : 1 if array.shape[2] < 3 else 3]), _alpha_of(array))


def _alpha_of(array: NDArray[Any]) -> NDArray[Any] | None:
    """The last of 2 or 4 channels, unless it is opaque everywhere."""
    if array.shape[2] not in (2, 4):
        return None
    alpha = _as_texels(array[..., -1:])[..., 0]
    opaque = np.iinfo(alpha.dtype).max if alpha.dtype.kind == "u" else 1.0
    if (alpha >= opaque).all():
        return None
    if alpha.dtype.kind == "f" and alpha.max() > 1.0:
        raise invalid(f"alpha must be at most 1, got {alpha.max():g}")
    return np.ascontiguousarray(alpha)


def size_problem(width: int, height: int) -> str | None:
    """Say so if a picture has no texels or too many."""
    if 1 <= width <= MOST_SIDE and 1 <= height <= MOST_SIDE and width * height <= MOST_TEXELS:
        return None
    return (
        f"must have 1 to {MOST_SIDE} rows and columns and at most {MOST_TEXELS} texels, "
        f"got {width} x {height}"
    )


def _as_texels(array: NDArray[Any]) -> NDArray[Any]:
    if array.dtype == np.bool_:
        return np.ascontiguousarray(array, np.uint8) * np.uint8(255)
    if array.dtype in (np.uint8, np.uint16):
        return _kept(array)
    if array.dtype.kind in "iu":
        raise invalid(f"whole numbers must be uint8 or uint16, got {array.dtype}")
    with np.errstate(over="ignore", invalid="ignore"):
        bad = ~((array >= 0.0) & (array <= LARGEST))
    if bad.any():
        y, x, c = (int(i) for i in np.argwhere(bad)[0])
        count = int(bad.any(axis=2).sum())
        more = f"; {count} texels are wrong" if count > 1 else ""
        raise invalid(
            f"texels must be finite, >= 0 and at most {LARGEST:g}, "
            f"got {array[y, x, c]} in row {y}, column {x}{more}"
        )
    return _kept(array.astype(np.float32, copy=False))


def _kept(array: NDArray[Any]) -> NDArray[Any]:
    """A copy that nobody can change; read-only arrays are used as they are."""
    return np.array(array, order="C") if array.flags.writeable else np.ascontiguousarray(array)


def _from_lists(rows: Any) -> NDArray[np.float64]:
    """Numbers from nested lists; grey texels among RGB ones are spread."""
    count = sum(len(row) if isinstance(row, list | tuple) else 1 for row in rows)
    widths = {len(row) if isinstance(row, list | tuple) else -1 for row in rows}
    if len(widths) != 1 or min(widths) < 1 or count > MOST_TEXELS:
        raise invalid("must be a list of rows of equal length, each a list of texels")
    flat = [texel for row in rows for texel in row]
    is_grey = not any(isinstance(texel, list | tuple) for texel in flat)
    with_alpha = any(isinstance(texel, list | tuple) and len(texel) == 4 for texel in flat)
    channels = 1 if is_grey else 4 if with_alpha else 3
    texels = [_texel(texel, channels) for texel in flat]
    return np.array(texels, np.float64).reshape(len(rows), -1, channels)


def _texel(texel: object, channels: int) -> list[float]:
    parts = list(texel) if isinstance(texel, list | tuple) else [texel] * channels
    numbers = [p for p in parts if isinstance(p, int | float) and not isinstance(p, bool)]
    # Python's whole numbers may be larger than any float.
    fits = all(isinstance(x, float) or abs(x) < 1e300 for x in numbers)
    if len(numbers) != channels or len(parts) != channels or not fits:
        raise invalid(f"texels must be a number or a list of 3 numbers, got {show_value(texel)}")
    return [float(x) for x in numbers]


def _from_words(rows: Any) -> NDArray[Any]:
    words = [row.lower().split() if isinstance(row, str) else [] for row in rows]
    digits = {len(word) for row in words for word in row}
    if (
        len({len(row) for row in words}) != 1
        or len(digits) != 1
        or not digits <= {2, 4, 6, 8, 12, 16}
    ):
        raise invalid(
            "rows must have equally many words, each of 2, 6 or 8 (or 4, 12 or 16) "
            "hexadecimal digits"
        )
    text = "".join(word for row in words for word in row)
    if not re.fullmatch(r"[0-9a-f]+", text):
        raise invalid("texels must be hexadecimal digits 0-9 and a-f")
    (count,) = digits
    kind, channels = (">u1", count // 2) if count in (2, 6, 8) else (">u2", count // 4)
    numbers = np.frombuffer(bytes.fromhex(text), kind)
    return numbers.astype(kind.replace(">", "=")).reshape(len(words), -1, channels)


@dataclass(frozen=True)
class PixelsField:
    """Metadata of a field that holds an `Image`."""

    def check(self, value: object) -> Image:
        """Accept what `as_image` takes."""
        return as_image(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Build pydantic's schema from `check`."""
        return core_schema.no_info_plain_validator_function(self.check)


Pixels = Annotated[Image, PixelsField()]


def holds_image(spec: Spec) -> bool:
    """Whether a description has the fields `file` and `pixels`."""
    return {"file", "pixels"} <= set(type(spec).model_fields)


def source_problem(spec: Any) -> str | None:
    """Say so unless exactly one of `file` and `pixels` is given."""
    if spec.file is not None and spec.pixels is not None:
        return "takes either file or pixels, got both"
    return "needs a file, or pixels" if spec.file is None and spec.pixels is None else None
