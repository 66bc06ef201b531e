"""Descriptions of textures and their pictures -> the tables that kernels read.

`texture_info` holds (kind, start in `texture_data`) for each texture; kind is the index of its
model in `alight.textures.MODELS`. For a texture made of others it holds what
`alight.textures.composed` says; the steps follow all textures. `texture_data` begins with a
blank row: lanes that look at no texture, or at one of another kind, read zeros there, from which
every model finds valid indices.

`texels` holds the pictures, each once, in words of 32 bits: three bytes RGB, or floats. Before them
stands a 0 for blank rows. Their texels lie in tiles of TILE x TILE, row by row within a tile and
tile by tile, so that the neighbours of a texel to all sides mostly share its cache line and page;
what a tile has beyond the picture's edge is 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from alight.compiled.packer import Packer
from alight.core.errors import Issue, SceneError
from alight.core.registry import default_of
from alight.core.spec import Texture
from alight.textures.composed import COMPOSED
from alight.textures.images import TILE, Image, decoded_levels
from alight.textures.model import TEXTURES
from alight.textures.nesting import Composed, Value, most
from lanewise.view import View

#: Kernels count words with 31 bits.
MOST_WORDS = 2**31 - 1

#: Words of a cache line, at which every picture begins.
LINE = 16

#: Rows of tiles that are packed at a time: a band of the largest pictures fits the cache.
BAND = 16


class CompiledTextures(NamedTuple):
    """All textures of a scene.

    Attributes
    ----------
    info, data, texels : View
        See above; uint32, float32, uint32.
    names : tuple of str
        Models in use, for `Program.textures`.
    """

    info: View
    data: View
    texels: View
    names: tuple[str, ...]


class TextureTable:
    """Numbers the textures of a scene, and stores each picture once."""

    def __init__(self) -> None:
        self._numbers: dict[Texture, int] = {}
        # A zero comes first. Offsets are written once all is known: the largest pictures
        # fill half of what a process may take.
        self._fill: list[tuple[int, int, Callable[[np.ndarray], None]]] = []
        self._end = 1
        self._starts: dict[object, int] = {}

    def number(self, texture: Texture) -> int:
        """Index + 1 of a texture; equal ones share it."""
        return self._numbers.setdefault(texture, len(self._numbers) + 1)

    def texels(self, image: Image, color_space: str) -> tuple[int, int, int, int]:
        """Store a picture.

        Returns
        -------
        start : int
            Word of its first texel.
        stride, step : int
            Words from texel to texel, and from channel to channel of floats.
        table : int
            Word where the values of 256 levels begin, or 0 where the texels are floats.
        """
        encoded = image.is_encoded(color_space)
        height, width, channels = image.texels.shape
        if image.levels == 255:

            def pack(words: np.ndarray) -> None:
                write_tiles(words, (height, width, 1), lambda a, b: packed(image.texels[a:b]))

            def decode(words: np.ndarray) -> None:
                words[:] = decoded_levels(255, encoded).view(np.uint32)

            start = self._block(image.digest, tiled_size(height, width), pack)
            return start, 1, 0, self._block(encoded, 256, decode)

        def linear(words: np.ndarray) -> None:
            texels = np.ascontiguousarray(image.linear(color_space)).view(np.uint32)
            write_tiles(words, (height, width, channels), lambda a, b: texels[a:b])

        size = tiled_size(height, width) * channels
        start = self._block((image.digest, encoded), size, linear)
        return start, channels, int(channels == 3), 0

    def _block(self, key: object, size: int, write: Callable[[np.ndarray], None]) -> int:
        if key not in self._starts:
            if self._end + size > MOST_WORDS:
                text = f"the pictures of all textures must take at most {MOST_WORDS * 4 >> 30} GB"
                raise SceneError([Issue("textures", text)])
            begin = -(-self._end // LINE) * LINE
            self._starts[key] = begin
            self._fill.append((begin, begin + size, write))
            self._end = begin + size
        return self._starts[key]

    def _texels(self) -> np.ndarray:
        """The words of all pictures."""
        memory = np.zeros(self._end + LINE, np.uint32)
        skip = (-memory.ctypes.data // memory.itemsize) % LINE
        words = memory[skip : skip + self._end]
        for start, end, write in self._fill:
            write(words[start:end])
        return words

    def names(self) -> tuple[str, ...]:
        """Models in use by the textures that have a number, and then their features."""
        every = [spec for one in self._numbers for spec in _steps(one)]
        used = {default_of(Texture).type_name(), *(spec.type_name() for spec in every)}
        features = {name for spec in every for name in TEXTURES[spec.type_name()].features(spec)}
        return (*(name for name in TEXTURES if name in used), *sorted(features))

    def compiled(self, origin: np.ndarray | None = None) -> CompiledTextures:
        """Make the tables of all textures that have a number.

        Parameters
        ----------
        origin : (3,) float64, metres, optional
            Where in the world the origin of rendering space is; there by default.
        """
        names, place = self.names(), np.zeros(3) if origin is None else origin
        slots = [sum(TEXTURES[name].SLOTS.values()) for name in names if name in TEXTURES]
        lists = [_steps(spec) for spec in self._numbers]
        rows = [np.zeros(max(3, *slots), np.float32)]
        starts: dict[Texture, int] = {}
        end = rows[0].size
        for spec in (spec for steps in lists for spec in steps):
            if spec not in starts:
                starts[spec] = end
                rows.append(self._row(spec, place))
                end += rows[-1].size
        heads: list[int] = []
        below: list[int] = []
        for steps in lists:
            words = [w for spec in steps for w in (TEXTURES[spec.type_name()].number, starts[spec])]
            if len(steps) > 1:
                heads += [COMPOSED + len(steps), 2 * len(lists) + len(below)]
                below += words
            else:
                heads += words
        return CompiledTextures(
            View(np.array([*heads, *below] or [0, 0], np.uint32)),
            View(np.concatenate(rows)),
            View(self._texels()),
            names,
        )

    def _row(self, spec: Texture, origin: np.ndarray) -> np.ndarray:
        """The numbers of one texture."""
        if not spec.varies:
            return np.array(spec.maximum(), np.float32)
        model = TEXTURES[spec.type_name()]
        packer = Packer(model.SLOTS, sum(model.SLOTS.values()), self, origin=origin)
        if model.pack is not None:
            model.pack(spec, packer)
        return packer.row


def _steps(spec: Value) -> list[Texture]:
    """The steps that compute a texture, see `alight.textures.nesting`."""
    if isinstance(spec, str):
        raise ValueError(f"the texture name {spec!r} must be resolved before compiling")
    if isinstance(spec, float | int | tuple):
        # Parts may exceed 1: only their product is a share of light.
        return [default_of(Texture).model_copy(update={"color": most(spec)})]
    if not isinstance(spec, Composed):
        return [spec]
    return [*(step for part in spec.ordered for step in _steps(part)), spec]


def tiled_size(height: int, width: int) -> int:
    """Texels of all tiles of a picture."""
    return -(-height // TILE) * -(-width // TILE) * TILE * TILE


def write_tiles(
    words: np.ndarray, shape: tuple[int, int, int], rows_of: Callable[[int, int], np.ndarray]
) -> None:
    """Write a picture in tiles.

    Parameters
    ----------
    words : (`tiled_size` * channels,) uint32
        Zeros, which are filled.
    shape : tuple of int
        Height, width and words a texel.
    rows_of : callable
        ``(first, last) -> (last - first, width, channels) uint32``.
    """
    height, width, channels = shape
    down, across = -(-height // TILE), -(-width // TILE)
    tiles = words.reshape(down, across, TILE, TILE, channels).swapaxes(1, 2)
    for first in range(0, down, BAND):
        last = min((first + BAND) * TILE, height)
        rows = rows_of(first * TILE, last).reshape(last - first * TILE, width, channels)
        beyond = -len(rows) % TILE, -width % TILE
        if any(beyond):
            rows = np.pad(rows, ((0, beyond[0]), (0, beyond[1]), (0, 0)))
        band = tiles[first : first + BAND]
        band[:] = rows.reshape(len(band), TILE, across, TILE, channels)


def packed(texels: np.ndarray) -> np.ndarray:
    """Rows of a picture of bytes as words."""
    words = np.zeros(texels.shape[0] * texels.shape[1], np.uint32)
    pack_bytes(texels, words)
    return words


def pack_bytes(texels: np.ndarray, words: np.ndarray) -> None:
    """Put texels of shape (h, w, 1 or 3) and type uint8 into words: red in the lowest byte."""
    if texels.shape[2] == 1:
        np.multiply(texels.reshape(-1), np.uint32(0x010101), out=words)
        return
    # Each texel with the first byte of the next one, as a little-endian word at every third byte;
    # three times as fast as writing bytes. The last texel has no next one.
    flat = np.ascontiguousarray(texels).reshape(-1)
    overlapping = np.ndarray(words.size - 1, "<u4", flat, strides=(3,))
    np.bitwise_and(overlapping, np.uint32(0xFFFFFF), out=words[:-1])
    red, green, blue = (int(byte) for byte in flat[-3:])
    words[-1] = red | green << 8 | blue << 16
