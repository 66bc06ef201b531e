"""Sampling of every BSDF example draws from the density it says, and weights by it."""

import numpy as np
import pytest

from alight.bsdfs.diffuse import Diffuse
from alight.bsdfs.flags import DELTA
from tests.sampling.materials import (
    Material,
    direction,
    each_example,
    each_smooth_example,
    random_numbers,
)
from tests.sampling.statistics import (
    LARGEST_Z,
    SIGNIFICANCE,
    SphereCells,
    chi_square,
    length_error,
    z_of_mean,
)

CELLS = SphereCells()
N = 60_000


@each_smooth_example
def test_samples_follow_their_density(spec, cosine):
    material, wo = Material(spec), direction(cosine)
    wi, _, pdf, flags = material.sample(wo, random_numbers(N, 1))
    assert not np.any(flags & DELTA)
    _, density = material.evaluate(wo, CELLS.points)
    assert np.all(np.isfinite(density)) and np.all(density >= 0.0)
    probabilities = CELLS.integrals(density)
    assert probabilities.sum() <= 1.0 + 1e-3
    p = chi_square(CELLS.counts(wi, pdf > 0.0), probabilities)
    assert p > SIGNIFICANCE


@each_smooth_example
def test_integral_of_the_density_is_the_share_of_successful_samples(spec, cosine):
    material, wo = Material(spec), direction(cosine)
    _, _, pdf, _ = material.sample(wo, random_numbers(N, 2))
    _, density = material.evaluate(wo, CELLS.points)
    assert (
        abs(z_of_mean((pdf > 0.0).astype(float), CELLS.integrals(density).sum(), 2e-4)) < LARGEST_Z
    )


@each_example
def test_sampled_directions_have_unit_length(spec, cosine):
    wi, _, pdf, _ = Material(spec).sample(direction(cosine), random_numbers(N, 3))
    # Failed samples too: an integrator may normalise nothing.
    assert length_error(wi) < 6.0e-7
    assert np.all(np.isfinite(pdf))


@each_smooth_example
def test_weight_is_value_over_density(spec, cosine):
    material, wo = Material(spec), direction(cosine)
    wi, weight, pdf, _ = material.sample(wo, random_numbers(N, 4))
    f_cos, density = material.evaluate(wo, wi)
    np.testing.assert_allclose(pdf, density, rtol=2e-6)
    ok = pdf > 0.0
    np.testing.assert_allclose((weight * pdf)[:, ok], f_cos[:, ok], rtol=2e-6)
    assert not weight[:, ~ok].any() and not f_cos[:, ~ok].any()


@each_smooth_example
def test_mean_weight_is_the_integral_of_the_value(spec, cosine):
    material, wo = Material(spec), direction(cosine)
    _, weight, _, _ = material.sample(wo, random_numbers(N, 5))
    f_cos, _ = material.evaluate(wo, CELLS.points)
    for channel in range(3):
        integral = CELLS.integrals(f_cos[channel]).sum()
        assert abs(z_of_mean(weight[channel].astype(float), integral, 2e-4)) < LARGEST_Z


@pytest.mark.parametrize("m", [0, 1, 2, 8])
def test_uniform_sampling_of_diffuse_has_the_variance_that_its_page_states(m):
    wo, variances = direction(0.7), {}
    for sampling in ("cosine", "uniform"):
        wi, weight, _, _ = Material(Diffuse(sampling=sampling)).sample(wo, random_numbers(N, 6))
        estimate = weight[0].astype(float) * wi[2].astype(float) ** m
        variances[sampling] = estimate.var() / estimate.mean() ** 2
    assert variances["cosine"] == pytest.approx(m * m / (4.0 * (m + 1.0)), rel=0.05, abs=1e-9)
    assert variances["uniform"] == pytest.approx((m + 1.0) ** 2 / (2.0 * m + 3.0), rel=0.05)
