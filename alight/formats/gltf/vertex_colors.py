"""COLOR_0: the colours of vertices, and their opacity.

Colours are those of the mesh, which the texture `vertex_color` shows. It has no opacity. So that of
a material which is not opaque is held as a further set of texture coordinates, (opacity, 1/2), in
which a ramp from black to white is looked up: linear in between, as the specification asks for.

Source: Khronos Group, glTF 2.0 specification, sections 3.7.2.1 and 3.9.2 ("vertex color").
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.formats.gltf.accessors import read_accessor
from alight.formats.gltf.container import Document
from alight.formats.gltf.values import Item
from alight.textures.images import Image

KEY = "COLOR_0"
#: In the place of the number of a TEXCOORD.
OPACITY_SET = -1
#: Texels have their middles at 1/4 and 3/4.
_RAMP_TO_UV = [[0.5, 0.0, 0.25], [0.0, 1.0, 0.0]]


def color_channels(document: Document, attributes: Item | None, *, is_opaque: bool) -> int:
    """How many channels of the colours play a part: 0 without any, 3, or 4 with opacity."""
    if attributes is None or not attributes.has(KEY):
        return 0
    table = _table(document, attributes)
    translucent = table is not None and table.shape[1] == 4 and bool((table[:, 3] < 1.0).any())
    return 4 if translucent and not is_opaque else 3


def vertex_colors(document: Document, attributes: Item, count: int) -> NDArray[np.float32] | None:
    """Colours (n, 3) of vertices, linear, in [0, 1]; None where there are none."""
    table = _table(document, attributes)
    if table is None:
        return None
    if table.shape != (count, 3) and table.shape != (count, 4):
        text = f"must have {count} rows of 3 or 4 components, got {table.shape}"
        raise attributes.fatal(KEY, text)
    colors = table[:, :3]
    # Not ~(<= 1): numbers that are none are found later, with their row.
    if ((colors < 0.0) | (colors > 1.0)).any():
        document.report.approximate(f"{KEY}: colours of vertices were cut to [0, 1]")
        colors = np.clip(colors, 0.0, 1.0)
    return np.ascontiguousarray(colors, np.float32)


def opacity_coordinates(
    document: Document, attributes: Item, count: int
) -> NDArray[np.float32] | None:
    """The opacity of vertices as texture coordinates (n, 2)."""
    table = _table(document, attributes)
    if table is None or table.shape != (count, 4):
        return None
    opacity = np.clip(table[:, 3], 0.0, 1.0)
    return np.column_stack([opacity, np.full(count, 0.5)]).astype(np.float32)


def opacity_texture(number: int) -> dict[str, Any]:
    """The texture that shows the opacity which is held by a mesh's set with that number."""
    ramp = Image(np.array([[[0], [255]]], np.uint8))
    data: dict[str, Any] = {"type": "bitmap", "pixels": ramp, "color_space": "linear"}
    data |= {"wrap": "clamp", "to_uv": {"matrix": _RAMP_TO_UV}}
    return data | ({"uv_set": number} if number else {})


def _table(document: Document, attributes: Item) -> NDArray[np.floating] | None:
    index = attributes.index(KEY, len(document.list("accessors")), "accessors")
    if index is None:
        return None
    table = read_accessor(document, index)
    if table.dtype.kind != "f":
        table = table.astype(np.float32) / np.float32(np.iinfo(table.dtype).max)
    return table
