"""Laws of the materials of a scene, as they are used: with their parameters and textures.

Directions are drawn and values evaluated by the kernels of the renderer in plain Python. Of
textured materials a few places of the texture are looked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from alight.bsdfs.flags import DELTA
from alight.core.spec import Bsdf
from alight.laws import bsdfs
from alight.laws.materials import Material, direction
from alight.laws.report import judged
from alight.laws.scene.findings import Finding
from alight.laws.statistics import SphereCells, chi_square, sphere_cells, z_of_mean
from alight.textures.fetch import is_textured

#: Directions of the viewer, as cosines; the last one is for materials with a back.
COSINES = (0.9, 0.25, -0.5)
#: Where textured materials are looked at, as (u, v).
PLACES = ((0.13, 0.21), (0.61, 0.47), (0.87, 0.92))
#: Samples for each direction.
N = 40_000
#: More different materials than this are not all looked at.
MOST = 32

#: A p-value below this is worked out again on the finer grid: lobes may be narrow.
_DOUBTFUL = 0.01
#: Integrals over two fine grids differ by more than this only where neither resolves the lobes.
_RESOLVED = 1e-3

_EXACT = (
    bsdfs.directions_have_unit_length,
    bsdfs.weight_is_value_over_density,
    bsdfs.delta_lobes_are_as_likely_as_they_say,
    bsdfs.pure_delta_models_have_no_value,
    bsdfs.values_are_finite,
    bsdfs.no_energy_is_created,
    bsdfs.light_goes_back_the_way_it_came,
    bsdfs.models_without_a_back_are_black,
)


def check_materials(specs: dict[str, Bsdf], seed: int) -> Iterator[Finding]:
    """Judge every material of a scene.

    Parameters
    ----------
    specs : dict of str to Bsdf
        By the name to show.
    seed : int
        Of the random numbers.
    """
    for number, (name, spec) in enumerate(specs.items()):
        if number == MOST:
            left = len(specs) - MOST
            yield Finding("materials", "all laws", detail=f"{left} more were not looked at")
            return
        plain = Material(spec)
        textured = is_textured(plain.program)
        rng = np.random.default_rng((seed, 1, number))
        for u, v in PLACES if textured else PLACES[:1]:
            material = Material(spec, uv=(u, v))
            where = f" at ({u:g}, {v:g})" if textured else ""
            yield from _of_one(f"material {name}{where}", material, rng)


def _of_one(part: str, material: Material, rng: np.random.Generator) -> Iterator[Finding]:
    cosines = COSINES if material.has_back() else COSINES[:-1]
    for cosine in cosines:
        yield from sampling_findings(part, material, cosine, rng)
    laws = [(law, cosine) for law in _EXACT for cosine in cosines]
    results = [judged(law, f"cosine {cosine:g}", material, cosine) for law, cosine in laws]
    if material.is_lossless():
        results.append(judged(bsdfs.white_furnace, "white furnace", material))
    if material.is_reciprocal():
        results.append(judged(bsdfs.reciprocity_is_as_declared, "reciprocity", material))
    # One line for what holds; each that does not gets its own.
    for result in results:
        if result.problem:
            detail = f"{result.example}: {result.problem}"
            yield Finding(part, result.law, holds=False, detail=detail)
    good = sum(not result.problem for result in results)
    if good:
        furnace = ", furnace" if material.is_lossless() else ""
        back = ", reciprocity" if material.is_reciprocal() else ""
        law = f"unit directions, weights, energy{furnace}{back}"
        yield Finding(part, law, holds=True, detail=f"{good} checks")


def sampling_findings(
    part: str, material: Material, cosine: float, rng: np.random.Generator
) -> Iterator[Finding]:
    """Whether samples follow their density, and whether their mean weight is the integral.

    Both integrals over the sphere are sums over a grid: on a second, finer one where the first
    speaks against the material, and not judged where even that does not resolve the lobes.
    """
    wo = direction(cosine)
    wi, weight, pdf, flags = material.sample(wo, rng.random((3, N), np.float32))
    smooth = (pdf > 0.0) & ((flags & DELTA) == 0)
    density, mean, total = _judge(material, wo, wi, weight, smooth, bsdfs.CELLS)
    if min(density, mean) < _DOUBTFUL:
        density, mean, total = _judge(material, wo, wi, weight, smooth, sphere_cells(128))
        if abs(_integral(material, wo) - total) > _RESOLVED:
            detail = "a lobe is too narrow for the grid of directions"
            yield Finding(part, f"samples follow their density, cosine {cosine:g}", detail=detail)
            return
    share = smooth.mean()
    if total == share == 0.0:
        # Delta lobes only: nothing here is spread over directions.
        return
    yield Finding(
        part,
        f"samples follow their density (chi-square), cosine {cosine:g}",
        p=density,
        detail=f"the density integrates to {total:.4g}; share of samples with one: {share:.4g}",
    )
    yield Finding(part, f"mean weight is the integral of the value, cosine {cosine:g}", p=mean)


def _integral(material: Material, wo: np.ndarray) -> float:
    """Of the density, over a grid that has no point in common with the others."""
    cells = sphere_cells(90)
    _, density = material.evaluate(wo, cells.points)
    return float(cells.integrals(density).sum())


def _judge(
    material: Material,
    wo: np.ndarray,
    wi: np.ndarray,
    weight: np.ndarray,
    smooth: np.ndarray,
    cells: SphereCells,
) -> tuple[float, float, float]:
    """(p of the chi-square, p of the mean weight, integral of the density)."""
    f_cos, density = material.evaluate(wo, cells.points)
    probabilities = cells.integrals(density)
    p_density = chi_square(cells.counts(wi, smooth), probabilities)
    integral = cells.integrals(f_cos.mean(0)).sum()
    values = np.where(smooth, weight.mean(0), 0.0).astype(float)
    z = z_of_mean(values, integral, 2e-4 * max(1.0, float(integral)))
    p_mean = math.erfc(abs(float(z)) / math.sqrt(2.0))
    return p_density, p_mean, float(probabilities.sum())
