"""Phase functions are densities, their samples follow them, and their mean cosine is as said."""

import numpy as np
import pytest
from scipy.stats import chi2

from alight.phases import MODELS

CASES = [(module, example) for module in MODELS for example in module.EXAMPLES]
IDS = [repr(example) for _, example in CASES]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4000)


@pytest.mark.parametrize(("module", "spec"), CASES, ids=IDS)
def test_density_integrates_to_one_with_its_mean_cosine(module, spec):
    value = np.float64(module.density(module.parameter(spec), 1.0 - NODES))
    assert 2 * np.pi * np.sum(WEIGHTS * value) == pytest.approx(1.0, abs=2e-5)
    cosine = 2 * np.pi * np.sum(WEIGHTS * NODES * value)
    assert cosine == pytest.approx(module.mean_cosine(spec), abs=2e-5)


@pytest.mark.parametrize(("module", "spec"), CASES, ids=IDS)
def test_samples_follow_the_density(module, spec):
    """Chi-square over bins that are equally likely, by the integral of the density."""
    count, bins = 400_000, 100
    u = np.random.default_rng(3).random(count).astype(np.float32)
    found = 1.0 - np.float64(module.sample(np.float32(module.parameter(spec)), u))
    assert np.all((found >= -1.0 - 1e-6) & (found <= 1.0 + 1e-6))
    # A grid that is fine at both ends, where sharp lobes are.
    mu = -np.cos(np.linspace(0.0, np.pi, 200_001))
    value = np.full(mu.shape, module.density(module.parameter(spec), 1.0 - mu), np.float64)
    below = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * np.diff(mu))])
    edges = np.interp(np.linspace(0.0, 1.0, bins + 1)[1:-1], below / below[-1], mu)
    counts = np.bincount(np.searchsorted(edges, found), minlength=bins)
    statistic = np.sum((counts - count / bins) ** 2) / (count / bins)
    assert chi2.sf(statistic, bins - 1) > 1e-4


def test_of_a_sharp_peak_no_digit_is_lost():
    """At g = 0.99 half of the light turns by less than 2 degrees."""
    (peak,) = [e for m, e in CASES if getattr(e, "g", 0.0) == 0.99]
    module = next(m for m, e in CASES if e is peak)
    u = np.linspace(0.0, 1.0, 1001)[1:-1]
    g = peak.g
    # The textbook's inverse, in float64.
    mu = (1 + g * g - ((1 - g * g) / (1 - g + 2 * g * u)) ** 2) / (2 * g)
    found = module.sample(np.float32(g), u.astype(np.float32))
    np.testing.assert_allclose(found, 1.0 - mu, rtol=2e-5, atol=1e-8)
