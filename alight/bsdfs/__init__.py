"""Scattering at surfaces, one model per file. A new model is one file and one line here."""

from alight.bsdfs import (
    conductor,
    dielectric,
    diffuse,
    mirror,
    null,
    phong,
    two_sided,
    uniform_scatter,
)

MODELS = (
    diffuse,
    uniform_scatter,
    mirror,
    phong,
    conductor,
    dielectric,
    two_sided,
    null,
)
