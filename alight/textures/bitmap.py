r"""Bitmap: the texels of a picture, interpolated.

The picture covers the unit square of (s, t), which are the surface's (u, v) after `to_uv`: s runs
along the rows, **t upwards**, so that (0, 0) is the lower left corner of the picture, as in OBJ
files. Texel (x, y), y counted downwards from the top, has its centre at

.. math:: s = \frac{x + 1/2}{w}, \qquad t = 1 - \frac{y + 1/2}{h}

Between four centres values are interpolated linearly ("bilinear"), or the texel that (s, t) lies in
is taken ("nearest"). Outside the square the picture is repeated, mirrored at its edges, or
continued by the texels of its border; the interpolation at the border reaches over it likewise.

Texels are decoded before they are interpolated: 8 and 16 bits are sRGB, floats are linear, unless
`color_space` says otherwise ("linear" for what is no colour: roughness, opacity, weights). Alpha is
left to `channel`. As a reflectance or another share of light the values must not exceed 1, as for
numbers.

In memory a texel of 8 bits a channel takes 4 bytes, of 16 bits or float 4 bytes a channel; equal
pictures are stored once. Mitsuba's `bitmap` is the same, but its t runs downwards.

Source: PBR4 section 10.4 (without filtering); IEC 61966-2-1 for sRGB.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from alight.core.field_types import Triple
from alight.core.fields import invalid
from alight.core.parameters import Slots, loader, slots_of
from alight.core.spec import Texture
from alight.core.uv_sets import UvSet, set_features
from alight.core.vec import Vec3
from alight.textures.images import TILE, Pixels, source_problem
from alight.textures.model import Flag, Number
from alight.textures.uv import IDENTITY, LookupPoint, ToUv
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    bits_float,
    float_bits,
    floor,
    gather,
    lanes_vec3,
    maximum,
    minimum,
    to_uint,
    where,
)


class Bitmap(Texture):
    """Picture on a surface.

    Parameters
    ----------
    file : str, optional
        PNG, JPEG, WebP, EXR, HDR, PFM, NPY, BMP, TGA or TIFF file, relative to the scene file; not
        with `pixels`.
    pixels : (h, w) or (h, w, 3) uint8, uint16 or float, optional
        The picture itself, top row first; in scene files lists, see `alight.textures.images`.
    color_space : {"auto", "srgb", "linear"}, default "auto"
        What texels are encoded with; auto: whole numbers sRGB, floats linear.
    interpolation : {"bilinear", "nearest"}, default "bilinear"
        Between the centres of texels.
    wrap : {"repeat", "mirror", "clamp"}, default "repeat"
        Outside of the picture.
    wrap_v : {"repeat", "mirror", "clamp"}, optional
        Below and above it, if that differs from the sides.
    to_uv : step or list of steps, default none
        From the surface's (u, v) to the picture, see `alight.textures.uv`.
    uv_set : int in [0, 7], default 0
        Which of a mesh's sets of (u, v): 0 its `uvs`, the others its `more_uvs`.
    """

    type: Literal["bitmap"] = "bitmap"
    file: str | None = None
    pixels: Pixels | None = None
    color_space: Literal["auto", "srgb", "linear"] = "auto"
    interpolation: Literal["bilinear", "nearest"] = "bilinear"
    wrap: Literal["repeat", "mirror", "clamp"] = "repeat"
    wrap_v: Literal["repeat", "mirror", "clamp"] | None = None
    to_uv: ToUv = IDENTITY
    uv_set: UvSet = 0

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        problem = source_problem(self)
        if problem:
            raise invalid(problem)
        return self

    def set_of_coordinates(self) -> int:
        """The one that it names."""
        return self.uv_set

    def lookup(self) -> np.ndarray:
        """The matrix of `to_uv`."""
        return self.to_uv.matrix

    def maximum(self) -> Triple:
        """Largest value of each channel; 0 as long as the file has not been read."""
        return (0.0, 0.0, 0.0) if self.pixels is None else self.pixels.maximum(self.color_space)

    def mean(self) -> Triple:
        """Mean of each channel over the picture; 0 as long as the file has not been read."""
        return (0.0, 0.0, 0.0) if self.pixels is None else self.pixels.mean(self.color_space)

    @property
    def mean_is_exact(self) -> bool:
        """Where no edge goes on for ever."""
        return "clamp" not in (self.wrap, self.wrap_v or self.wrap)


_CORNERS = np.array(
    [[[255, 0, 0], [0, 255, 0], [40, 40, 200]], [[0, 0, 0], [9, 99, 199], [255] * 3]]
)

EXAMPLES = (
    Bitmap(pixels=_CORNERS.astype(np.uint8)),
    Bitmap(pixels=np.array([[0.25]]), interpolation="nearest", wrap="clamp"),
    Bitmap(
        pixels=(257 * _CORNERS).astype(np.uint16),
        color_space="linear",
        wrap="mirror",
        to_uv=[{"scale": [3.0, -0.5]}, {"rotate": 30.0}, {"translate": [0.25, -7.0]}],
    ),
    Bitmap(pixels=np.array([[[0.1, 0.2, 0.3], [1.0, 0.0, 0.5]]]), wrap="clamp"),
    Bitmap(pixels=np.array([[0.25, 0.5], [0.75, 1.0]]), wrap="mirror", wrap_v="clamp"),
)

REPEAT, MIRROR, CLAMP = 0.0, 1.0, 2.0
_WRAPS = {"repeat": REPEAT, "mirror": MIRROR, "clamp": CLAMP}
#: Entered into `Program.textures` where the two ways to wrap differ.
TWO_WRAPS = "two_wraps"


@kernel
def _word_at(scene, slot, surface):
    return float_bits(gather(scene.materials.texture_data, slot))


Word = Annotated[Any, Slots(_word_at)]


class Layout(NamedTuple):
    """Where texels lie, see `alight.compiled.textures.TextureTable.texels`."""

    start: Word
    stride: Word
    step: Word
    table: Word


class Params(NamedTuple):
    """A row of the table: size in texels, and the numbers of the ways to wrap."""

    point: LookupPoint
    width: Number
    height: Number
    bilinear: Flag
    wrap: Number
    layout: Annotated[Any, Slots(loader(Layout), {"layout": 4})]
    wrap_v: Number


SLOTS = slots_of(Params)
_load = loader(Params)


def features(spec: Bitmap) -> tuple[str, ...]:
    """What kernels must be written for."""
    wraps = () if spec.wrap_v in (None, spec.wrap) else (TWO_WRAPS,)
    return (*wraps, *set_features(spec.uv_set))


def pack(spec: Bitmap, packer) -> None:
    """Fill the row of one texture."""
    assert spec.pixels is not None
    packer.numbers("to_uv", *spec.to_uv.matrix.ravel())
    packer.numbers("width", spec.pixels.width)
    packer.numbers("height", spec.pixels.height)
    packer.numbers("bilinear", float(spec.interpolation == "bilinear"))
    packer.numbers("wrap", _WRAPS[spec.wrap])
    packer.texels("layout", spec.pixels, spec.color_space)
    packer.numbers("wrap_v", _WRAPS[spec.wrap_v or spec.wrap])
    packer.numbers("uv_set", float(spec.uv_set))


@kernel
def _folded(s, wrap):
    """The coordinate in [0, 1] that shows the same; NaN stays."""
    # Fractions are taken before sizes multiply them: exact, however far from the square.
    repeated = s - floor(s)
    half = 0.5 * s
    twice = 2.0 * (half - floor(half))
    mirrored = where(twice > 1.0, 2.0 - twice, twice)
    clamped = where(s < 0.0, 0.0, where(s > 1.0, 1.0, s))
    return where(wrap == REPEAT, repeated, where(wrap == MIRROR, mirrored, clamped))


@kernel
def _neighbours(f, size, bilinear, wrap):
    """Columns left and right of f in [0, 1] (u32), and the weight of the right one."""
    last = size - 1.0
    x = where(bilinear, f * size - 0.5, f * size)
    left = floor(x)
    weight = where(bilinear, x - left, 0.0)
    right = left + 1.0
    # Mirrored and continued pictures show the texel of the border once more.
    repeats = wrap == REPEAT
    before = where(repeats, last, 0.0)
    after = where(repeats, 0.0, last)
    left = where(left < 0.0, before, minimum(left, last))
    right = where(right > last, after, right)
    # maximum(NaN, 0) is 0: indices are valid whatever the coordinates are.
    return to_uint(maximum(left, 0.0)), to_uint(maximum(right, 0.0)), weight


@kernel
def _between(x, y, a, b, c, d):
    """Interpolate linearly; where all four are equal the result is the same number."""
    upper = a + x * (b - a)
    lower = c + x * (d - c)
    return upper + y * (lower - upper)


@kernel
def _in_tiles(x, y, across):
    """Number of the texel in column x and row y, of a picture that is `across` tiles wide."""
    tile = (y >> 2) * across + (x >> 2)
    return (tile << 4) + ((y & 3) << 2) + (x & 3)


@kernel
def _small(texels, texel, red):
    """Colour of a word of three bytes; the table of their 256 values begins at `red`."""
    word = gather(texels, texel)
    return Vec3(
        bits_float(gather(texels, red + (word & 255))),
        bits_float(gather(texels, red + ((word >> 8) & 255))),
        bits_float(gather(texels, red + ((word >> 16) & 255))),
    )


@kernel
def _large(texels, texel, step):
    """Colour of floats `step` words apart: 1, or 0 where they are grey."""
    return Vec3(
        bits_float(gather(texels, texel)),
        bits_float(gather(texels, texel + step)),
        bits_float(gather(texels, texel + 2 * step)),
    )


@specialised
def _wrap_v(program):
    """``(params) -> number`` of the way to wrap t."""
    return _own_wrap if TWO_WRAPS in program.textures else _same_wrap


@kernel
def _own_wrap(params):
    return params.wrap_v


@kernel
def _same_wrap(params):
    return params.wrap


@kernel
def evaluate(scene, base, surface):
    """The picture's colour at (u, v)."""
    params, texels = _load(scene, base, surface), scene.materials.texels
    (s, t), (start, stride, step, table) = params.point, params.layout
    wrap, wrap_v = params.wrap, _wrap_v(params)
    x0, x1, x = _neighbours(_folded(s, wrap), params.width, params.bilinear, wrap)
    # t runs upwards, rows run downwards.
    y0, y1, y = _neighbours(1.0 - _folded(t, wrap_v), params.height, params.bilinear, wrap_v)

    across = (to_uint(params.width) + (TILE - 1)) >> 2
    a = start + stride * _in_tiles(x0, y0, across)
    b = start + stride * _in_tiles(x1, y0, across)
    c = start + stride * _in_tiles(x0, y1, across)
    d = start + stride * _in_tiles(x1, y1, across)
    small = table != 0
    value = lanes_vec3(0.0)
    if any_lane(small):
        value = _between(
            x,
            y,
            _small(texels, a, table),
            _small(texels, b, table),
            _small(texels, c, table),
            _small(texels, d, table),
        )
    if any_lane(~small):
        large = _between(
            x,
            y,
            _large(texels, a, step),
            _large(texels, b, step),
            _large(texels, c, step),
            _large(texels, d, step),
        )
        value = where(small, value, large)
    return value
