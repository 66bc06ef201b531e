"""Shapes, one model per file. A new model is one file and one line here."""

from alight.shapes import cube, curves, cylinder, disk, mesh, plane, rectangle, sphere

MODELS = (
    sphere,
    plane,
    rectangle,
    disk,
    cube,
    mesh,
    cylinder,
    curves,
)
