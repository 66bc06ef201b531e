"""Laws of phase functions: densities on the sphere that samples follow, with the mean cosine."""

from __future__ import annotations

import numpy as np

from alight.core.spec import PhaseFunction
from alight.laws.report import demand, demand_close
from alight.laws.statistics import SIGNIFICANCE, chi_square
from alight.phases.model import PHASES

#: Samples, and cells that are equally likely.
N, BINS = 400_000, 100

#: Cosines: a grid that is fine at both ends, where sharp lobes are.
MU = -np.cos(np.linspace(0.0, np.pi, 200_001))


def _density(spec: PhaseFunction, one_minus_cosine: np.ndarray) -> np.ndarray:
    model = PHASES[spec.type_name()]
    value = model.density(np.float32(model.parameter(spec)), one_minus_cosine.astype(np.float32))
    return np.broadcast_to(value, one_minus_cosine.shape).astype(np.float64)


def it_scatters_all_light_with_its_mean_cosine(spec: PhaseFunction) -> None:
    """The density integrates to 1 over the sphere, and its mean cosine is as declared."""
    value = _density(spec, 1.0 - MU)
    demand(np.isfinite(value) & (value >= 0.0), "a density is negative or not finite")
    demand_close(2.0 * np.pi * np.trapezoid(value, MU), 1.0, "integral of the density", atol=2e-5)
    mean = 2.0 * np.pi * np.trapezoid(MU * value, MU)
    declared = PHASES[spec.type_name()].mean_cosine(spec)
    demand_close(mean, declared, "mean cosine against `mean_cosine`", atol=2e-5)


def samples_follow_their_density(spec: PhaseFunction) -> None:
    """Sampled cosines follow the density (chi-square over cells that are equally likely)."""
    model = PHASES[spec.type_name()]
    u = np.random.default_rng(3).random(N).astype(np.float32)
    sampled = model.sample(np.float32(model.parameter(spec)), u)
    found = 1.0 - np.broadcast_to(sampled, N).astype(np.float64)
    demand(np.abs(found) <= 1.0 + 1e-6, "a sampled cosine is beyond 1")
    value = _density(spec, 1.0 - MU)
    below = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * np.diff(MU))])
    edges = np.interp(np.linspace(0.0, 1.0, BINS + 1)[1:-1], below / below[-1], MU)
    counts = np.bincount(np.searchsorted(edges, found), minlength=BINS)
    p = chi_square(counts, np.full(BINS - 1, 1.0 / BINS))
    demand(p > SIGNIFICANCE, f"cosines are not distributed like the density: p = {p:.2g}")


LAWS = (it_scatters_all_light_with_its_mean_cosine, samples_follow_their_density)
