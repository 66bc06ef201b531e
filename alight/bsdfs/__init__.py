"""Scattering at surfaces, one model per file. A new model is one file and one line here."""

from alight.bsdfs import (
    blend,
    conductor,
    dielectric,
    diffuse,
    mask,
    mirror,
    null,
    oren_nayar,
    phong,
    plastic,
    rough_conductor,
    rough_dielectric,
    rough_plastic,
    thin_dielectric,
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
    rough_conductor,
    rough_dielectric,
    thin_dielectric,
    plastic,
    rough_plastic,
    oren_nayar,
    two_sided,
    null,
    blend,
    mask,
)
