"""Distributions of microfacet normals: normalisation, masking, and sampling of the visible ones."""

import numpy as np
import pytest
from scipy.special import erfc

from alight.core.microfacet import (
    beckmann_distribution,
    beckmann_lambda,
    ggx_distribution,
    ggx_lambda,
    sample_beckmann,
    sample_ggx_visible,
    smith_g1,
    smith_g2,
    visible_normal_pdf,
)
from alight.core.vec3 import Vec3
from tests.sampling.materials import direction, random_numbers
from tests.sampling.statistics import SIGNIFICANCE, SphereCells, chi_square, length_error

CELLS = SphereCells()
N = 60_000
f = np.float32

MODELS = {
    "ggx": (ggx_distribution, ggx_lambda),
    "beckmann": (beckmann_distribution, beckmann_lambda),
}
ROUGHNESS = [(0.15, 0.15), (0.5, 0.5), (1.0, 1.0), (0.2, 0.6)]
COSINES = [1.0, 0.7, 0.2, 0.03]

each_model = pytest.mark.parametrize("name", MODELS)
each_roughness = pytest.mark.parametrize("alpha", ROUGHNESS)
each_cosine = pytest.mark.parametrize("cosine", COSINES)


def distribution_at_cells(name, alpha):
    return MODELS[name][0](Vec3(*CELLS.points), f(alpha[0]), f(alpha[1]))


@each_roughness
@each_model
def test_the_facets_cover_the_surface_once(name, alpha):
    projected = distribution_at_cells(name, alpha) * CELLS.points[2]
    assert CELLS.integrals(projected).sum() == pytest.approx(1.0, abs=3e-4)


@each_cosine
@each_roughness
@each_model
def test_the_visible_facets_look_as_large_as_the_surface(name, alpha, cosine):
    wo = Vec3(*direction(cosine))
    g1 = smith_g1(MODELS[name][1](wo, f(alpha[0]), f(alpha[1])))
    facing = np.maximum(0.0, np.sum(CELLS.points * direction(cosine), axis=0))
    seen = CELLS.integrals(distribution_at_cells(name, alpha) * facing).sum() * g1[0]
    assert seen == pytest.approx(cosine, rel=1e-3)


@each_cosine
@each_roughness
def test_ggx_visible_normals_follow_their_density(alpha, cosine):
    ax, ay = f(alpha[0]), f(alpha[1])
    u, wo = random_numbers(N, 1), Vec3(*direction(cosine))
    wm = sample_ggx_visible(wo, ax, ay, (u[1], u[2]))
    wm = np.stack([wm.x, wm.y, wm.z])
    assert length_error(wm) < 3e-7
    assert np.all(wm[2] > 0.0)
    lambda_o = ggx_lambda(wo, ax, ay)
    pdf = visible_normal_pdf(wo, Vec3(*CELLS.points), distribution_at_cells("ggx", alpha), lambda_o)
    assert CELLS.integrals(pdf).sum() == pytest.approx(1.0, abs=1e-3)
    p = chi_square(CELLS.counts(wm, np.ones(N, bool)), CELLS.integrals(pdf))
    assert p > SIGNIFICANCE


@each_roughness
def test_beckmann_normals_follow_their_density(alpha):
    u = random_numbers(N, 2)
    wm = sample_beckmann(f(alpha[0]), f(alpha[1]), (u[1], u[2]))
    wm = np.stack([wm.x, wm.y, wm.z])
    assert length_error(wm) < 3e-7
    pdf = distribution_at_cells("beckmann", alpha) * CELLS.points[2]
    p = chi_square(CELLS.counts(wm, np.ones(N, bool)), CELLS.integrals(np.maximum(pdf, 0.0)))
    assert p > SIGNIFICANCE


def test_beckmann_lambda_is_the_error_function_form():
    a = np.linspace(0.01, 4.0, 2000)
    theta = np.arctan(1.0 / (0.5 * a))
    w = Vec3(f(np.sin(theta)), f(0.0 * a), f(np.cos(theta)))
    # The stated 6e-6, and rounding of exp(-a^2) for a^2 up to 16.
    exact = np.exp(-a * a) / (2.0 * a * np.sqrt(np.pi)) - 0.5 * erfc(a)
    np.testing.assert_allclose(beckmann_lambda(w, f(0.5), f(0.5)), exact, rtol=2e-5)


def test_ggx_lambda_is_its_closed_form():
    theta = np.linspace(0.0, 1.55, 1000)
    w = Vec3(f(np.sin(theta)), f(0.0 * theta), f(np.cos(theta)))
    exact = 0.5 * (np.sqrt(1.0 + (0.3 * np.tan(theta)) ** 2) - 1.0)
    np.testing.assert_allclose(ggx_lambda(w, f(0.3), f(0.9)), exact, rtol=2e-5, atol=1e-12)


@each_model
def test_rough_directions_see_less(name):
    lambda_of = MODELS[name][1]
    w = Vec3(*(np.concatenate([direction(c) for c in COSINES], axis=1)))
    values = lambda_of(w, f(0.4), f(0.4))
    assert values[0] < 1e-6 and np.all(np.diff(values) > 0.0)
    both = smith_g2(values, values)
    # Seen from both directions at once: more than if the heights were independent.
    assert np.all(both <= smith_g1(values))
    assert np.all(both >= smith_g1(values) ** 2)
