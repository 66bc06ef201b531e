"""Colours that vary over a surface, one model per file. A new one is one file and one line here."""

from alight.textures import bitmap, checkerboard, constant, vertex_color

MODELS = (
    constant,
    checkerboard,
    bitmap,
    vertex_color,
)
