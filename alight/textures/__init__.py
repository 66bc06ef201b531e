"""Colours that vary over a surface, one model per file. A new one is one file and one line here."""

from alight.textures import (
    add,
    bitmap,
    channel,
    checkerboard,
    clamp,
    constant,
    mix,
    multiply,
    noise,
    threshold,
    vertex_color,
)

MODELS = (
    constant,
    checkerboard,
    bitmap,
    vertex_color,
    noise,
    multiply,
    add,
    mix,
    channel,
    threshold,
    clamp,
)

#: One that is not the same everywhere, for examples of other families.
VARYING = checkerboard.Checkerboard()

#: The same colour everywhere: what a number is where a texture is wanted.
DEFAULT = constant.Constant()
