"""Sampling of every BSDF example draws from the density it says, and weights by it."""

import pytest

from alight.bsdfs.diffuse import Diffuse
from alight.laws import bsdfs as laws
from alight.laws.materials import Material, direction, random_numbers
from tests.sampling.materials import each_example


@each_example
def test_samples_follow_their_density(spec, cosine):
    laws.samples_follow_their_density(Material(spec), cosine)


@each_example
def test_integral_of_the_density_is_the_share_of_successful_samples(spec, cosine):
    laws.density_integrates_to_the_share(Material(spec), cosine)


@each_example
def test_sampled_directions_have_unit_length(spec, cosine):
    laws.directions_have_unit_length(Material(spec), cosine)


@each_example
def test_weight_is_value_over_density(spec, cosine):
    laws.weight_is_value_over_density(Material(spec), cosine)


@each_example
def test_mean_weight_is_the_integral_of_the_value(spec, cosine):
    laws.mean_weight_is_the_integral(Material(spec), cosine)


@pytest.mark.parametrize("m", [0, 1, 2, 8])
def test_uniform_sampling_of_diffuse_has_the_variance_that_its_page_states(m):
    wo, variances = direction(0.7), {}
    for sampling in ("cosine", "uniform"):
        wi, weight, _, _ = Material(Diffuse(sampling=sampling)).sample(
            wo, random_numbers(60_000, 6)
        )
        estimate = weight[0].astype(float) * wi[2].astype(float) ** m
        variances[sampling] = estimate.var() / estimate.mean() ** 2
    assert variances["cosine"] == pytest.approx(m * m / (4.0 * (m + 1.0)), rel=0.05, abs=1e-9)
    assert variances["uniform"] == pytest.approx((m + 1.0) ** 2 / (2.0 * m + 3.0), rel=0.05)
