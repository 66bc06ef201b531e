"""Descriptions of textures and their pictures -> the tables that kernels read.

`texture_info` holds (kind, start in `texture_data`) for each texture; kind is the index of its
model in `alight.textures.MODELS`. `texture_data` begins with a blank row: lanes that look at no
texture, or at one of another kind, read zeros there, from which every model finds valid indices.

`texels` holds the pictures, each once, in words of 32 bits: three bytes RGB, or floats. Before them
stands a 0 for blank rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from alight.compiled.packer import Packer
from alight.core.errors import Issue, SceneError
from alight.core.registry import Models, Numbers
from alight.core.spec import Texture
from alight.core.view import View
from alight.textures.images import Image, decoded_levels

#: Kernels count words with 31 bits.
MOST_WORDS = 2**31 - 1


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
        self._blocks: list[np.ndarray] = [np.zeros(1, np.uint32)]
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
        if image.levels == 255:
            start = self._block(image.digest, lambda: packed_bytes(image.texels))
            table = self._block(encoded, lambda: decoded_levels(255, encoded).view(np.uint32))
            return start, 1, 0, table
        channels = image.texels.shape[2]
        key = (image.digest, encoded)
        start = self._block(key, lambda: image.linear(color_space).view(np.uint32).ravel())
        return start, channels, int(channels == 3), 0

    def _block(self, key: object, make: Callable[[], np.ndarray]) -> int:
        if key not in self._starts:
            start, block = sum(block.size for block in self._blocks), make()
            if start + block.size > MOST_WORDS:
                text = f"the pictures of all textures must take at most {MOST_WORDS * 4 >> 30} GB"
                raise SceneError([Issue("textures", text)])
            self._starts[key] = start
            self._blocks.append(block)
        return self._starts[key]

    def compiled(self) -> CompiledTextures:
        """Make the tables of all textures that have a number."""
        kinds, models = Numbers("textures"), Models("textures")
        used = {"constant", *(spec.type_name() for spec in self._numbers)}
        slots = [getattr(models[name], "SLOTS", {}) for name in used]
        rows = [np.zeros(max(1, *(sum(s.values()) for s in slots)), np.float32)]
        info, start = [], rows[0].size
        for spec in self._numbers:
            model = models[spec.type_name()]
            packer = Packer(model.SLOTS, sum(model.SLOTS.values()), self)
            model.pack(spec, packer)
            info += [kinds[spec.type_name()], start]
            rows.append(packer.row)
            start += packer.size
        return CompiledTextures(
            View(np.array(info or [0, 0], np.uint32)),
            View(np.concatenate(rows)),
            View(np.concatenate(self._blocks)),
            tuple(name for name in kinds if name in used),
        )


def packed_bytes(texels: np.ndarray) -> np.ndarray:
    """Put texels of shape (h, w, 1 or 3) and type uint8 into words: red in the lowest byte."""
    channels = (0, 1, 2) if texels.shape[2] == 3 else (0, 0, 0)
    red, green, blue = (texels[..., i].astype(np.uint32) for i in channels)
    return (red | green << 8 | blue << 16).ravel()
