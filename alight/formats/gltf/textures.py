"""Textures of materials -> textures of the native format.

Texture coordinates are turned over when meshes are read (v upwards), and so is what a transform
does to them: F M F, F turning v over. Where minification filters blur what is far away, many
samples do the same, so filters play no part but for ``NEAREST`` magnification.

Source: Khronos Group, glTF 2.0 specification, sections 3.8 and 3.9; KHR_texture_transform. Its
rotation is counter-clockwise as pictures are seen, the only way its first example comes out right.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from alight.core.errors import SceneError
from alight.formats.gltf.accessors import view_bytes
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item
from alight.formats.materials.textures import (
    CHECKERED,
    MISSING,
    WITHOUT,
    bitmap,
    packed_picture,
    wrapped,
)
from alight.formats.reading.reach import OutOfReachError
from alight.textures.images import Image

Data = dict[str, Any]
WRAPS = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
NEAREST = 9728
_FLIP = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])
#: Extensions that name another picture for a texture.
OTHER_SOURCES = ("KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds")
WEBP = "EXT_texture_webp"
#: What to do where there is no other.
WAYS_OUT = {
    "KHR_texture_basisu": "write PNG: ktx extract --transcode rgba8 IN.ktx2 OUT.png (KTX-Software) "
    "for each picture, or export the file again without KTX2",
    "EXT_texture_avif": "write PNG: gltf-transform png IN OUT --formats '*'",
    "MSFT_texture_dds": "write PNG, with any program that reads DDS, and name that file instead",
}


class Textures:
    """Builds textures, and decodes each picture once.

    Parameters
    ----------
    document : Document

    Attributes
    ----------
    sets : tuple of int
        The sets of texture coordinates that the material in the making uses, in the order that
        meshes with it will have: the set 0 of ours is the first of them.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.sets: tuple[int, ...] = ()
        self._pictures: dict[int, Image | str | None] = {}

    def bitmap(self, owner: Item, key: str, *, is_color: bool) -> Data | None:
        """The picture that an object names, as a description; None where there is none.

        Parameters
        ----------
        owner, key
            Where the texture info stands.
        is_color : bool
            Whether it is sRGB-encoded, as colours are.
        """
        info = owner.object(key)
        if info is None:
            return None
        textures = self.document.list("textures")
        index = info.index("index", len(textures), "textures")
        if index is None:
            if not info.has("index"):
                info.wrong("", "needs an index")
            return None
        picture = self._picture_of(textures[index])
        if picture is None or (picture is MISSING and not is_color):
            return None
        data = bitmap(picture, "auto" if is_color else "linear")
        data |= self._sampler(textures[index])
        matrix = transform(info)
        if matrix is not None:
            data["to_uv"] = {"matrix": matrix}
        number = self.coordinates(owner, key)
        if number in self.sets[1:]:
            data["uv_set"] = self.sets.index(number)
        return data

    def coordinates(self, owner: Item, key: str) -> int:
        """Which set of texture coordinates a texture info asks for."""
        info = owner.object(key)
        if info is None:
            return 0
        extension = info.extension("KHR_texture_transform")
        if extension is not None and extension.has("texCoord"):
            return extension.integer("texCoord", 0, 0, 15)
        return info.integer("texCoord", 0, 0, 15)

    def _sampler(self, texture: Item) -> Data:
        samplers = self.document.list("samplers")
        index = texture.index("sampler", len(samplers), "samplers")
        if index is None:
            return {}
        sampler = samplers[index]
        wraps = []
        for key in ("wrapS", "wrapT"):
            number = sampler.integer(key, 10497)
            if number not in WRAPS:
                listed = ", ".join(f"{n} ({word})" for n, word in WRAPS.items())
                sampler.wrong(key, f"must be one of {listed}, got {number}")
            wraps.append(WRAPS.get(number, "repeat"))
        keys = wrapped(*wraps)
        if sampler.integer("magFilter", 0) == NEAREST:
            keys["interpolation"] = "nearest"
        return keys

    def _picture_of(self, texture: Item) -> Image | str | None:
        images = self.document.list("images")
        index = texture.index("source", len(images), "images")
        webp = texture.extension(WEBP)
        if index is None and webp is not None:
            index = webp.index("source", len(images), "images")
        named = texture.object("extensions")
        other = [n for n in OTHER_SOURCES if named is not None and named.has(n)]
        if index is None:
            if other:
                text = f"{other[0]} is not covered and the texture names no other picture"
                texture.wrong("extensions", f"{text}; {WAYS_OUT[other[0]]}")
            elif not texture.has("source") and (webp is None or not webp.has("source")):
                texture.wrong("", "needs a source")
            return None
        if other or (webp is not None and texture.has("source")):
            other = other or [WEBP]
            self.document.report.drop(f"{other[0]}: the PNG or JPEG beside it is used")
        if index not in self._pictures:
            self._pictures[index] = self._picture(images[index])
        return self._pictures[index]

    def _picture(self, image: Item) -> Image | str | None:
        """A decoded picture, or the name of a file."""
        self.document.report.count("pictures")
        try:
            if image.has("uri"):
                found = self.document.located(image, image.text("uri"))
                if isinstance(found, Path):
                    return self.document.reach.name_of(found)
                data: bytes | memoryview = found
            else:
                data, _ = view_bytes(self.document, image, "bufferView")
            report = self.document.report
            return packed_picture(data, lambda text: report.approximate(f"{image.pointer}: {text}"))
        except OutOfReachError as error:
            self.document.report.lacks_at(
                image.name, image.at("uri"), error, f"{CHECKERED}, or {WITHOUT}"
            )
            return MISSING if self.document.report.lenient else None
        except PydanticCustomError as error:
            image.wrong("", f"the picture {error.message()}")
        except (OSError, ValueError) as error:
            if isinstance(error, SceneError):
                raise
            image.wrong("", f"the picture {' '.join(str(error).split())[:200] or 'is broken'}")
        return None


def transform(info: Item) -> list[list[float]] | None:
    """The map of our (u, v) that KHR_texture_transform asks for; None for the identity."""
    extension = info.extension("KHR_texture_transform")
    if extension is None:
        return None
    x, y = extension.numbers("offset", (0.0, 0.0))
    width, height = extension.numbers("scale", (1.0, 1.0))
    angle = extension.number("rotation", 0.0)
    c, s = math.cos(angle), math.sin(angle)
    moved = np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])
    turned = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    matrix = _FLIP @ moved @ turned @ np.diag([width, height, 1.0]) @ _FLIP
    return None if np.array_equal(matrix, np.eye(3)) else matrix[:2].tolist()
