"""How steep the normals of a picture are where a material would have to bend them back.

Of metal and glass a normal map with lit rims bends those normals that would mirror the viewer into
the surface; seen head-on these are the ones that lean by more than 45 degrees. That changes what
the file says, so it is told. What is matte keeps its normals
(`alight.bsdfs.normals.shading_normals`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from alight.core.errors import SceneError
from alight.formats.materials.surfaces import Surface
from alight.scene.files import Files
from alight.scene.images import picture
from alight.textures.images import Image

#: Rows and columns of a picture that are looked at.
_MOST = 256
#: Part of the normals that must be steep for a remark.
LEAST = 0.01


def steep_share(surface: Surface, files: Files) -> float:
    """Part of the normals of a surface that lean by more than 45 degrees and may be bent back.

    Parameters
    ----------
    surface : Surface
    files : Files
        Reads pictures.

    Returns
    -------
    float
        In [0, 1]; 0 where the material is matte, or its picture is none that can be looked at.
    """
    bent, core = surface.bent, surface.core
    if bent is None or bent["type"] != "normal_map" or not isinstance(bent["texture"], dict):
        return 0.0
    if bent["texture"]["type"] != "bitmap":
        return 0.0
    mirrors = [core.get(key, 0.0) != 0.0 for key in ("metallic", "transmission", "iridescence")]
    image = _image(bent["texture"], files) if any(mirrors) else None
    if image is None or image.texels.shape[2] != 3:
        return 0.0
    rows, columns = (-(-size // _MOST) for size in image.texels.shape[:2])
    space = bent["texture"].get("color_space", "auto")
    texels = np.ascontiguousarray(image.texels[::rows, ::columns])
    x, y, z = np.moveaxis(2.0 * Image(texels).linear(space) - 1.0, 2, 0)
    return float((np.hypot(x, y) * abs(bent.get("scale", 1.0)) > np.maximum(z, 0.0)).mean())


def told(surface: Surface, files: Files) -> str:
    """The remark on a surface with steep normals; empty for others."""
    share = steep_share(surface, files)
    if share < LEAST:
        return ""
    return (
        f"{max(1, math.floor(100.0 * share))} % of its normals lean by more than 45 degrees: where "
        "they would mirror the viewer into the surface they are bent back (rims: lit)"
    )


def _image(texture: Any, files: Files) -> Image | None:
    try:
        return texture.get("pixels") or picture(texture["file"], files)
    except SceneError:
        return None  # Building the scene reports it.
