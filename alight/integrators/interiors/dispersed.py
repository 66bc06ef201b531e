"""Paths that are followed for one wavelength once they meet a body that disperses light.

Each sample has one wavelength, a dimension of its own of the sampler, and a pure function of the
sample. A path is multiplied by what it does to the channels (`alight.core.wavelengths`) where it
first meets such a body; paths that meet none keep all their colours, and their noise.
"""

from __future__ import annotations

from alight.bsdfs.switch import SPREADS, material_flags
from alight.core.wavelengths import DISPERSIVE, wavelength_at, weights_at
from alight.samplers.sampling import get_1d
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import any_lane, lanes_mask, where

#: Dimension of the wavelength, see `alight.integrators.walk`.
WAVELENGTH = 6


@specialised
def at_wavelength_of(program):
    """``(surface, sampler) -> surface``: a surface as it is at the wavelengths of samples."""
    return _at_wavelength if DISPERSIVE in program.bsdfs else _at_all


@kernel
def _at_all(surface, sampler):
    return surface


@kernel
def _at_wavelength(surface, sampler):
    return replace(surface, wavelength=wavelength_at(get_1d(sampler, WAVELENGTH)))


@specialised
def spreads(program):
    """``(scene, surface) -> mask``: the material, or a part of it, disperses light."""
    return _spreads if DISPERSIVE in program.bsdfs else _never


@kernel
def _spreads(scene, surface):
    return (material_flags(scene, surface.bsdf) & SPREADS) != 0


@kernel
def _never(scene, surface):
    return lanes_mask(False)


@specialised
def meet_dispersion(program):
    """``(scene, surface, path, active) -> path``: paths that are about to be dispersed."""
    return _become_monochromatic if DISPERSIVE in program.bsdfs else _keep_colors


@kernel
def _keep_colors(scene, surface, path, active):
    return path


@kernel
def _become_monochromatic(scene, surface, path, active):
    first = active & ~path.monochromatic & _spreads(scene, surface)
    if any_lane(first):
        weights = weights_at(get_1d(path.sampler, WAVELENGTH))
        beta = where(first, path.beta * weights, path.beta)
        path = replace(path, beta=beta, monochromatic=path.monochromatic | first)
    return path
