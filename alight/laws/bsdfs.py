"""Laws of BSDFs: sampling is unbiased, energy is conserved, declared symmetries hold.

Each law is a function of a `Material` and, the first ones, of the cosine of the viewer's elevation;
it raises `BrokenLawError`. Models may have smooth lobes, delta lobes, or both: densities and values
are about the smooth ones, energy about all.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps

import numpy as np

from alight.bsdfs.flags import DELTA, NULL
from alight.bsdfs.nesting import Nested
from alight.laws.materials import (
    COSINES,
    Material,
    direction,
    random_numbers,
    refracts,
    unit_interval,
)
from alight.laws.report import BrokenLawError, demand, demand_close
from alight.laws.statistics import (
    LARGEST_Z,
    SIDES,
    SIGNIFICANCE,
    SphereCells,
    chi_square,
    length_error,
    sphere_cells,
    unit_vectors,
    z_of_mean,
)

CELLS = sphere_cells(SIDES[0])
N, STEPS = 60_000, 4096


def refined(law: Callable[..., None]) -> Callable[..., None]:
    """Judge a law again on finer grids before it counts as broken: lobes may be narrow."""

    @wraps(law)
    def judged_again(material: Material, cosine: float) -> None:
        for side in SIDES[:-1]:
            try:
                return law(material, cosine, sphere_cells(side))
            except BrokenLawError:
                pass
        return law(material, cosine, sphere_cells(SIDES[-1]))

    return judged_again


# Laws look at one material from one side after the other, at the same directions each.
@lru_cache(maxsize=len(SIDES))
def _values(material: Material, cosine: float, cells: SphereCells):
    """(f_cos, pdf) at the points of the cells."""
    return material.evaluate(direction(cosine), cells.points)


@lru_cache(maxsize=1)
def _samples(material: Material, cosine: float):
    """N independent samples."""
    return material.sample(direction(cosine), random_numbers(N, 1))


@lru_cache(maxsize=1)
def _stepped(material: Material, cosine: float):
    """Samples whose first number steps evenly, so that shares of lobes are exact."""
    return material.sample(direction(cosine), unit_interval(STEPS))


def _smooth(pdf, flags):
    return (pdf > 0.0) & ((flags & DELTA) == 0)


# ---------------------------------------------------------------- sampling


@refined
def samples_follow_their_density(material: Material, cosine: float, cells: SphereCells) -> None:
    """Samples follow their density (chi-square)."""
    wi, _, pdf, flags = _samples(material, cosine)
    _, density = _values(material, cosine, cells)
    demand(np.isfinite(density) & (density >= 0.0), "a density is negative or not finite")
    probabilities = cells.integrals(density)
    total = probabilities.sum()
    demand(total <= 1.0 + 1e-3, f"the density integrates to {total:.5g}, more than 1")
    p = chi_square(cells.counts(wi, _smooth(pdf, flags)), probabilities)
    demand(p > SIGNIFICANCE, f"directions are not distributed like pdf: p = {p:.2g}")


@refined
def density_integrates_to_the_share(material: Material, cosine: float, cells: SphereCells) -> None:
    """The density integrates to the share of successful samples."""
    _, _, pdf, flags = _samples(material, cosine)
    _, density = _values(material, cosine, cells)
    total, share = cells.integrals(density).sum(), _smooth(pdf, flags).astype(float)
    z = z_of_mean(share, total, 2e-4)
    demand(
        abs(z) < LARGEST_Z,
        f"the density integrates to {total:.5g}, but {share.mean():.5g} of samples succeed",
    )


def directions_have_unit_length(material: Material, cosine: float) -> None:
    """Sampled directions have unit length, failed ones too."""
    wi, _, pdf, _ = _samples(material, cosine)
    error = length_error(wi)
    demand(error < 6.0e-7, f"a length is {error:.2g} off")
    demand(np.isfinite(pdf), "a pdf is not finite")


def weight_is_value_over_density(material: Material, cosine: float) -> None:
    """The weight of a sample is f cos / pdf."""
    wo = direction(cosine)
    wi, weight, pdf, flags = _samples(material, cosine)
    f_cos, density = material.evaluate(wo, wi)
    ok = _smooth(pdf, flags)
    # Bent normals turn a direction there and back, which rounds it: most where the cosine is small.
    rtol, atol = (1e-3, 1e-7) if material.is_bent() else (2e-6, 0.0)
    demand_close(pdf[ok], density[ok], "pdf of sample against evaluate", rtol=rtol, atol=atol)
    demand_close(
        (weight * pdf)[:, ok], f_cos[:, ok], "weight * pdf against f cos", rtol=rtol, atol=atol
    )
    demand(~weight[:, pdf <= 0.0].any(), "a failed sample has a weight")
    # A direction that one part of a nested material fails with may be one of another part.
    alone = not isinstance(material.spec, Nested)
    demand(not alone or not f_cos[:, pdf <= 0.0].any(), "f cos > 0 in a direction of pdf 0")


@refined
def mean_weight_is_the_integral(material: Material, cosine: float, cells: SphereCells) -> None:
    """The mean weight is the integral of the value."""
    _, weight, pdf, flags = _samples(material, cosine)
    f_cos, _ = _values(material, cosine, cells)
    smooth = _smooth(pdf, flags)
    for channel in range(3):
        integral = cells.integrals(f_cos[channel]).sum()
        values = np.where(smooth, weight[channel], 0.0).astype(float)
        z = z_of_mean(values, integral, 2e-4)
        demand(abs(z) < LARGEST_Z, f"mean {values.mean():.5g}, integral {integral:.5g}")


def delta_lobes_are_as_likely_as_they_say(material: Material, cosine: float) -> None:
    """The pdf of a delta lobe is its probability, and it has one direction."""
    wi, _, pdf, flags = _stepped(material, cosine)
    delta = (flags & DELTA != 0) & (pdf > 0.0)
    total = 0.0
    for kind in np.unique(flags[delta]):
        here = delta & (flags == kind)
        demand(np.ptp(wi[:, here], axis=1) == 0.0, "a delta lobe has several directions")
        total += float(pdf[here][0])
        share = here.mean()
        demand_close(pdf[here][0], share, "pdf against the share of samples", atol=1.5 / STEPS)
    demand(total <= 1.0 + 1e-6, f"the delta lobes have probability {total:.5g} together")


def pure_delta_models_have_no_value(material: Material, cosine: float) -> None:
    """What scatters into single directions only has value and density 0 elsewhere."""
    if material.is_delta(direction(cosine)):
        f_cos, pdf = material.evaluate(direction(cosine), CELLS.points[:, ::257])
        demand(~f_cos.any() & ~pdf.any(), "evaluate is not 0")


def holes_are_as_likely_as_they_are_open(material: Material, cosine: float) -> None:
    """Samples pass as if nothing was there as often as shadow rays are let through."""
    wo = direction(cosine)
    wi, weight, pdf, flags = _stepped(material, cosine)
    hole = ((flags & NULL) != 0) & (pdf > 0.0)
    demand_close(hole.mean(), material.open_share(), "share of holes", atol=1.5 / STEPS)
    demand(wi[:, hole] == -(wo + 0.0 * wi)[:, hole], "light turns in a hole")
    demand(weight[:, hole] == 1.0, "light is dimmed by a hole")


# ---------------------------------------------------------------- physics


def reflected_power(material: Material, cosine: float, cells: SphereCells = CELLS) -> np.ndarray:
    """Part of the light that arrives along wo and leaves again, (3,).

    By reciprocity it is also what wo receives under a constant sky. Refracted radiance is
    scaled back by eta^2: power, not radiance, is what is conserved.
    """
    scale = material.radiance_scale(cosine, cells.points[2] * cosine < 0.0)
    f_cos, _ = _values(material, cosine, cells)
    smooth = np.array([cells.integrals(f * scale).sum() for f in f_cos])
    _, weight, pdf, flags = _stepped(material, cosine)
    delta = (pdf > 0.0) & ((flags & DELTA) != 0)
    single = weight * material.radiance_scale(cosine, refracts(flags)) * delta
    return smooth + single.mean(1)


@refined
def no_energy_is_created(material: Material, cosine: float, cells: SphereCells) -> None:
    """No more light leaves than arrives."""
    power = reflected_power(material, cosine, cells)
    demand(power <= 1.0 + 6e-4, f"{power.max():.5g} of the light leaves")


def values_are_finite(material: Material, cosine: float) -> None:
    """Values, densities and weights are finite and not negative."""
    f_cos, pdf = _values(material, cosine, CELLS)
    _, weight, sampled, _ = _stepped(material, cosine)
    for name, values in (("f cos", f_cos), ("pdf", pdf), ("weight", weight), ("pdf", sampled)):
        demand(np.isfinite(values) & (values >= 0.0), f"a {name} is negative or not finite")


def light_goes_back_the_way_it_came(material: Material, cosine: float) -> None:
    """Delta lobes are reversible."""
    wo = direction(cosine)
    if not material.is_reciprocal():
        return
    wi, weight, pdf, flags = material.sample(wo, unit_interval(512))
    ok = (pdf > 0.0) & ((flags & DELTA) != 0)
    if not ok.any():
        return
    # From the other end, with the random number that chooses the same lobe.
    again, weight_back, pdf_back, flags_back = material.sample(wi, unit_interval(512))
    same = ok & (flags_back == flags)
    demand(same.sum() >= 0.99 * ok.sum(), "the way back chooses other lobes")
    # At grazing angles the cosine of a refracted ray is the root of a small difference.
    atol = 2e-6 / abs(cosine)
    demand_close(again[:, same], (wo + 0.0 * wi)[:, same], "direction of the way back", atol=atol)
    demand_close(pdf_back[same], pdf[same], "pdf of the way back", atol=atol)
    # f(wo, wi) / eta_i^2 = f(wi, wo) / eta_o^2: the factors 1 / eta^2 of both ways cancel.
    there, back = (weight * pdf)[:, same], (weight_back * pdf_back)[:, same]
    eta2 = material.radiance_scale(cosine, refracts(flags[same]))
    demand_close(there * eta2, back / eta2, "value of the way back", atol=atol)


def models_without_a_back_are_black(material: Material, cosine: float) -> None:
    """A model that is neither two-sided nor lets light through is black from behind."""
    if cosine <= 0.0 or material.has_back():
        return
    below = direction(-cosine)
    demand(~material.evaluate(below, CELLS.points)[0].any(), "f cos > 0 seen from behind")
    _, weight, pdf, _ = material.sample(below, unit_interval(512))
    demand(~weight.any() & ~pdf.any(), "a sample seen from behind has a weight or a pdf")
    f_cos, _ = _values(material, cosine, CELLS)
    demand(~f_cos[:, CELLS.points[2] < 0.0].any(), "light from below comes through")


def light_from_behind_is_as_declared(material: Material, cosine: float) -> None:
    """Smooth light from the other side of the shading normal comes only if that is declared."""
    if material.is_one_sided():
        behind = CELLS.points[2] * cosine < 0.0
        f_cos, _ = _values(material, cosine, CELLS)
        demand(~f_cos[:, behind].any(), "f cos > 0 for light from the other side")


@refined
def power_is_one(material: Material, cosine: float, cells: SphereCells) -> None:
    """All light leaves again."""
    power = reflected_power(material, cosine, cells)
    demand_close(power, 1.0, f"power that leaves at cosine {cosine}", atol=2e-4)


def white_furnace(material: Material) -> None:
    """Where all light is declared to leave again, it does."""
    if not material.is_lossless():
        return
    for cosine in (1.0, 0.9, 0.5, 0.1, 0.01, 1e-3):
        for side in (cosine, -cosine) if material.is_lossless_from_behind() else (cosine,):
            power_is_one(material, side)


def asymmetry(material: Material) -> float:
    """Largest of |f(wo, wi) - f(wi, wo)| over their sum, for directions on the same side."""
    wo, wi = unit_vectors(20_000, 1), unit_vectors(20_000, 2)
    wo[2], wi[2] = np.abs(wo[2]), np.abs(wi[2])
    there, _ = material.evaluate(wo, wi)
    back, _ = material.evaluate(wi, wo)
    there, back = there / wi[2], back / wo[2]
    total = there + back
    return float(np.max(np.abs(there - back)[total > 0.0] / total[total > 0.0], initial=0.0))


def reciprocity_is_as_declared(material: Material) -> None:
    """f(wo, wi) = f(wi, wo) where that is declared, and only there; None declares neither."""
    declared = material.is_reciprocal()
    if declared is None:
        return
    found = asymmetry(material)
    if declared:
        # Rounding of the chord between two directions, through an exponent of 300.
        demand(found < 3e-5, f"both differ by {found:.2g} of their sum")
    else:
        demand(found > 0.5, "declared to be not reciprocal, yet it is")


SAMPLING_LAWS = (
    samples_follow_their_density,
    density_integrates_to_the_share,
    directions_have_unit_length,
    weight_is_value_over_density,
    mean_weight_is_the_integral,
    delta_lobes_are_as_likely_as_they_say,
    holes_are_as_likely_as_they_are_open,
    pure_delta_models_have_no_value,
)
PHYSICS_LAWS = (
    no_energy_is_created,
    values_are_finite,
    light_goes_back_the_way_it_came,
    models_without_a_back_are_black,
    light_from_behind_is_as_declared,
)
#: Laws of (material, cosine), for all of `COSINES`; and of the material alone.
DIRECTIONAL_LAWS = SAMPLING_LAWS + PHYSICS_LAWS
WHOLE_LAWS = (white_furnace, reciprocity_is_as_declared)

__all__ = ["COSINES", "DIRECTIONAL_LAWS", "PHYSICS_LAWS", "SAMPLING_LAWS", "WHOLE_LAWS"]
