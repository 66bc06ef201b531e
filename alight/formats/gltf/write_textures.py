"""Textures -> pictures of 8 bits, their samplers, and where they lie on surfaces.

Colours are sRGB-encoded, numbers linear. Picture transforms are those of `read` backwards: with F
turning v over, glTF's map is F M F, which must be a scale, then a rotation, then a shift.
"""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.core.spec import Texture
from alight.core.srgb import encode_srgb
from alight.formats.gltf.planes import Plane, factors_of, placed_alike, plane_of
from alight.formats.gltf.store import Json, Store
from alight.textures.bitmap import Bitmap
from alight.textures.images import Image
from alight.textures.vertex_color import VertexColor

WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}
_CHANNELS = "rgba"
Bytes = NDArray[np.uint8]


class TextureWriter:
    """Writes each picture once.

    Parameters
    ----------
    store : Store

    Attributes
    ----------
    sets : set of int
        Sets of texture coordinates that the material in the making uses.
    has_colors : bool
        Whether it uses the colours of vertices.
    """

    def __init__(self, store: Store) -> None:
        self.store = store
        self.sets: set[int] = set()
        self.has_colors = False
        self._textures: dict[Any, int] = {}

    def base(
        self, value: Any, opacity: Plane | float, has_colors: bool
    ) -> tuple[list[float], Json]:
        """The base colour and its opacity, as factor (4) and texture info.

        Parameters
        ----------
        value : color or texture
        opacity : Plane or float
            Its picture becomes the alpha of the colour's.
        has_colors : bool
            Whether the mesh has colours at its vertices, which tint the base colour.
        """
        factor, parts = factors_of(value)
        tints = [part for part in parts if isinstance(part, VertexColor)]
        if tints:
            parts.remove(tints[0])
            self.has_colors = has_colors
            factor = factor if has_colors else factor * np.array(tints[0].fallback)
        picture, factor = self._picture(factor, parts)
        if isinstance(opacity, Plane) and picture and not placed_alike(picture, opacity.spec):
            self.store.lose("opacity: its picture lies otherwise than that of the colour")
            opacity = opacity.factor * float(opacity.values().mean())
        if isinstance(opacity, Plane):
            texels, scale = self._colors(picture, opacity.spec)
            alpha = np.rint(255.0 * opacity.values()).astype(np.uint8)
            info = self.info(np.dstack([_three(texels), alpha]), opacity.spec)
            return [*_numbers(factor * scale), opacity.factor], info
        if picture is None:
            return [*_numbers(factor), opacity], {}
        texels, scale = self._colors(picture, picture)
        # Where there is an opacity, an alpha of the picture's own would count, too.
        texels = texels if opacity == 1.0 else _three(texels)
        return [*_numbers(factor * scale), opacity], self.info(texels, picture)

    def color(self, value: Any) -> tuple[tuple[float, ...], Json]:
        """A colour as factor (3) and texture info, which is empty without a picture.

        Parameters
        ----------
        value : color or texture
        """
        picture, factor = self._picture(*factors_of(value))
        if picture is None:
            return _numbers(factor), {}
        texels, scale = self._colors(picture, picture)
        return _numbers(factor * scale), self.info(texels, picture)

    def _picture(
        self, factor: NDArray[np.float64], parts: list[Any]
    ) -> tuple[Bitmap | None, NDArray[np.float64]]:
        """The picture among the factors of a colour; the others become their means."""
        picture = next((part for part in parts if isinstance(part, Bitmap)), None)
        for part in parts:
            if part is not picture:
                self.store.lose(f"{part.type_name()} texture: became its mean colour")
                factor = factor * np.array(part.mean())
        return picture, factor

    def number(self, value: Any, channel: str) -> tuple[float, Json]:
        """A number as factor and texture info; `channel` is where the file wants it."""
        plane = plane_of(value)
        if plane is None:
            return self._mean(value), {}
        if not isinstance(plane, Plane):
            return plane, {}
        plane = self.within_one(plane)
        if plane.is_plain and plane.channel == channel:
            return plane.factor, self.info(_whole(plane.spec), plane.spec)
        texels = _grey(self._bytes(plane))
        if channel == "a":
            texels = np.dstack([texels, texels[..., :1]])
        return plane.factor, self.info(texels, plane.spec)

    def within_one(self, plane: Plane) -> Plane:
        """A number with a factor of at most 1, as the file wants it."""
        if plane.factor > 1.0 and plane.spec.pixels is not None:
            self._say_bytes(plane.spec.pixels)
        return plane.within_one()

    def pair(self, blue: Any, green: Any) -> tuple[float, float, Json]:
        """Two numbers that share a picture: the factors of blue and green, and its info."""
        planes = {"b": plane_of(blue), "g": plane_of(green)}
        values = {"b": blue, "g": green}
        factors = {
            c: plane if isinstance(plane, float | int) else 1.0 for c, plane in planes.items()
        }
        for c in "bg":
            if planes[c] is None:
                factors[c] = self._mean(values[c])
        found = {c: self.within_one(p) for c, p in planes.items() if isinstance(p, Plane)}
        if len(found) == 2 and not placed_alike(found["b"].spec, found["g"].spec):
            factors["b"] = self._mean(values["b"])
            del found["b"]
        factors |= {c: plane.factor for c, plane in found.items()}
        if not found:
            return factors["b"], factors["g"], {}
        spec = next(iter(found.values())).spec
        rest = [factors[c] for c in "bg" if c not in found]
        pictures = {plane.spec.pixels for plane in found.values()}
        if (
            len(pictures) == 1
            and all(plane.is_plain and plane.channel == c for c, plane in found.items())
            and not any(rest)
        ):
            return factors["b"], factors["g"], self.info(_whole(spec), spec)
        layers = {c: self._bytes(plane) for c, plane in found.items()}
        white = np.full_like(next(iter(layers.values())), 255)
        texels = np.dstack([white, layers.get("g", white), layers.get("b", white)])
        return factors["b"], factors["g"], self.info(texels, spec)

    def normals(self, spec: Bitmap) -> Json:
        """A picture whose channels are numbers."""
        assert spec.pixels is not None
        if spec.pixels.levels == 255 and not spec.pixels.is_encoded(spec.color_space):
            return self.info(_whole(spec), spec)
        self._say_bytes(spec.pixels)
        linear = np.clip(spec.pixels.linear(spec.color_space), 0.0, 1.0)
        return self.info(np.rint(255.0 * linear).astype(np.uint8), spec)

    def info(self, texels: Bytes, spec: Bitmap) -> Json:
        """The texture info of a picture of 8 bits, that lies as `spec` does."""
        from PIL import Image as Pillow

        texels = np.broadcast_to(texels, (*texels.shape[:2], max(3, texels.shape[2])))
        wraps = spec.wrap, spec.wrap_v or spec.wrap
        key = (Image(np.ascontiguousarray(texels)), *wraps, spec.interpolation)
        if key not in self._textures:
            file = io.BytesIO()
            Pillow.fromarray(np.ascontiguousarray(texels)).save(file, "PNG")
            image = {"bufferView": self.store.view(file.getvalue()), "mimeType": "image/png"}
            sampler = {
                "wrapS": WRAPS[wraps[0]], "wrapT": WRAPS[wraps[1]],
                "magFilter": 9728 if spec.interpolation == "nearest" else 9729,
            }  # fmt: skip
            made = {
                "source": self.store.put("images", image),
                "sampler": self.store.put("samplers", sampler),
            }
            self._textures[key] = self.store.put("textures", made)
        found: Json = {"index": self._textures[key]}
        if spec.uv_set:
            found["texCoord"] = spec.uv_set
        self.sets.add(spec.uv_set)
        self._place(spec, found)
        return found

    def _place(self, spec: Bitmap, found: Json) -> None:
        matrix = np.vstack([spec.to_uv.matrix, [0.0, 0.0, 1.0]])
        if (matrix == np.eye(3)).all():
            return
        steps = decomposed(matrix)
        if steps is None:
            self.store.lose("to_uv: places of pictures on surfaces that shear")
        else:
            self.store.extension(found, "KHR_texture_transform", steps)

    def _colors(self, picture: Bitmap | None, spec: Bitmap) -> tuple[Bytes, float]:
        """sRGB texels of a picture, white without one, and what they are multiplied by."""
        assert spec.pixels is not None
        if picture is None or picture.pixels is None:
            return np.full((spec.pixels.height, spec.pixels.width, 3), 255, np.uint8), 1.0
        image = picture.pixels
        if image.levels == 255 and image.is_encoded(picture.color_space):
            return _whole(picture), 1.0
        self._say_bytes(image)
        linear = image.linear(picture.color_space).astype(np.float64)
        scale = max(1.0, float(linear.max()))
        coded = np.rint(255.0 * encode_srgb(linear / scale)).astype(np.uint8)
        coded = np.broadcast_to(coded, (*coded.shape[:2], 3))
        if image.alpha is not None:
            alpha = np.rint(255.0 * (image.alpha / float(image.levels))).astype(np.uint8)
            coded = np.dstack([coded, alpha])
        return coded, scale

    def _bytes(self, plane: Plane) -> Bytes:
        assert plane.spec.pixels is not None
        self._say_bytes(plane.spec.pixels)
        return np.rint(255.0 * np.clip(plane.values(), 0.0, 1.0)).astype(np.uint8)

    def _say_bytes(self, image: Image) -> None:
        if image.levels != 255:
            self.store.lose("pictures of 16 bits and floats: became 8 bits")

    def _mean(self, value: Any) -> float:
        self.store.lose("a number that varies otherwise than a picture: became its mean")
        return value.mean()[1] if isinstance(value, Texture) else float(value)


def decomposed(matrix: NDArray[np.float64]) -> Json | None:
    """Offset, rotation and scale of KHR_texture_transform; None for maps that shear.

    Parameters
    ----------
    matrix : (3, 3) float64
        Of our (u, v).
    """
    flip = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])
    m = flip @ matrix @ flip
    # m = [[c w, s h], [-s w, c h]]
    width = math.hypot(m[0, 0], m[1, 0])
    angle = math.atan2(-m[1, 0], m[0, 0]) if width > 0.0 else math.atan2(m[0, 1], m[1, 1])
    c, s = math.cos(angle), math.sin(angle)
    height = s * m[0, 1] + c * m[1, 1]
    made = np.array([[c * width, s * height], [-s * width, c * height]])
    if np.abs(made - m[:2, :2]).max() > 1e-6 * max(np.abs(m[:2, :2]).max(), 1e-30):
        return None
    return {"offset": m[:2, 2].tolist(), "rotation": angle, "scale": [width, height]}


def _whole(spec: Bitmap) -> Bytes:
    assert spec.pixels is not None
    return spec.pixels.whole


def _three(texels: Bytes) -> Bytes:
    """Without alpha, in three channels."""
    return np.broadcast_to(texels[..., :3], (*texels.shape[:2], 3))


def _grey(plane: Bytes) -> Bytes:
    return np.repeat(plane[..., None], 3, axis=2)


def _numbers(factor: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(c) for c in factor)
