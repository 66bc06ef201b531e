"""Vertex colours of a mesh, interpolated over each triangle with its barycentric coordinates.

Shapes without vertex colours show `fallback`.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from alight.core.field_types import Reflectance
from alight.core.parameters import loader, slots_of
from alight.core.spec import Texture
from alight.textures.model import Triplet
from lanewise.jit import kernel
from lanewise.simd import gather, where


class VertexColor(Texture):
    """The colours stored at a mesh's vertices (linear sRGB, each channel in [0, 1]).

    Parameters
    ----------
    fallback : Reflectance, default 0.5
        Colour of shapes that carry none.
    """

    type: Literal["vertex_color"] = "vertex_color"
    fallback: Reflectance = (0.5, 0.5, 0.5)


EXAMPLES = (VertexColor(), VertexColor(fallback=(0.9, 0.1, 0.1)), VertexColor(fallback=0.0))

# Where `scene.shapes.info` says whether a shape has vertex colours (layout: alight/shapes/hit.py).
SHAPE_ROW, FLAGS_COLUMN, HAS_COLORS = 8, 4, 8


class Params(NamedTuple):
    """A row of the table."""

    fallback: Triplet


SLOTS = slots_of(Params)
_load = loader(Params)


def pack(spec: VertexColor, packer) -> None:
    """Fill the row of one texture."""
    packer.color("fallback", spec.fallback)


@kernel
def evaluate(scene, base, surface):
    """The colour that the mesh interpolated, or the fallback."""
    params = _load(scene, base, surface)
    flags = gather(scene.shapes.info, surface.shape * SHAPE_ROW + FLAGS_COLUMN)
    return where((flags & HAS_COLORS) != 0, surface.color, params.fallback)
