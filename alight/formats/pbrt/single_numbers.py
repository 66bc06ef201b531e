"""The numbers that pbrt finds in a coloured picture, where a texture of type ``float`` names one.

pbrt 4 interpolates the opacity of a PNG or OpenEXR file that has one, which passes through the
curve of the encoding as colours do, and else the mean of the three channels. What it does not
interpolate (``point``, and ``EWA``, which adds texels up) is red. Other files lose their opacity.
pbrt 3 takes the luminance of what the file holds, and decodes that; opacity plays no part. Both
take grey pictures as they are, and drop the opacity beside a single channel.

Source: pbrt 4, ``MIPMap::Bilerp``, ``MIPMap::Texel`` and ``Image::Read``; pbrt 3,
``ImageTexture::convertIn``.
"""

from __future__ import annotations

import numpy as np

from alight.core.constants import LUMINANCE
from alight.core.srgb import decode_srgb
from alight.textures.images import Image

#: Filters of pbrt 4 that interpolate between texels.
INTERPOLATING = ("bilinear", "trilinear")
#: Files whose opacity it keeps.
WITH_OPACITY = (".png", ".exr", ".qoi")


def numbers_in(image: Image, file: str, color_space: str, kind: str, old: bool) -> Image | None:
    """The picture of numbers in place of a coloured one; None where that shows the same.

    Parameters
    ----------
    image : Image
    file : str
        Its name.
    color_space : {"auto", "linear"}
        How its texels are encoded, as of `alight.textures.bitmap.Bitmap`.
    kind : str
        The filter.
    old : bool
        Whether the file is one of pbrt 3.
    """
    texels = image.texels
    if texels.shape[2] == 1:
        return None
    alpha = image.alpha if file.lower().endswith(WITH_OPACITY) else None
    if alpha is not None and not old and kind in INTERPOLATING:
        return _grey(Image(alpha[..., None]).linear(color_space)[..., 0])
    if (texels == texels[..., :1]).all():
        return None
    if old:
        encoded = texels.astype(np.float64) @ np.array(LUMINANCE) / image.levels
        return _grey(decode_srgb(encoded) if image.is_encoded(color_space) else encoded)
    linear = image.linear(color_space)
    return _grey(linear.mean(axis=2) if kind in INTERPOLATING else linear[..., 0])


def _grey(values: np.ndarray) -> Image:
    return Image(np.ascontiguousarray(values[..., None], np.float32))
