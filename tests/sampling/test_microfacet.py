"""Distributions of microfacet normals: normalisation, masking, and sampling of the visible ones."""

import numpy as np
import pytest
from scipy.special import erfc, erfcinv

from alight.compiled.program import Program
from alight.core.microfacet import (
    BECKMANN,
    GGX,
    Facets,
    _halley_step,
    _visible_slope,
    beckmann_density,
    beckmann_visible_area,
    facet_density,
    gaussian_quantile,
    ggx_density,
    ggx_visible_area,
    sample_beckmann_visible,
    sample_ggx_visible,
    sample_visible_facet,
    visible_area,
)
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.sampling.materials import direction, random_numbers
from tests.sampling.statistics import (
    SIDES,
    SIGNIFICANCE,
    chi_square,
    length_error,
    sphere_cells,
    unit_vectors,
)

CELLS = sphere_cells(SIDES[0])
N = 60_000
f = np.float32

MODELS = {
    "ggx": (ggx_density, ggx_visible_area, sample_ggx_visible),
    "beckmann": (beckmann_density, beckmann_visible_area, sample_beckmann_visible),
}
ROUGHNESS = [(0.15, 0.15), (0.5, 0.5), (1.0, 1.0), (0.2, 0.6)]
COSINES = [1.0, 0.7, 0.2, 0.03]

each_model = pytest.mark.parametrize("name", MODELS)
each_roughness = pytest.mark.parametrize("alpha", ROUGHNESS)
each_cosine = pytest.mark.parametrize("cosine", COSINES)


def facets(alpha, beckmann=0.0):
    return Facets(f(alpha[0]), f(alpha[1]), f(beckmann))


def density_at_cells(name, alpha):
    return MODELS[name][0](facets(alpha), Vec3(*CELLS.points))


def stack(v):
    return np.stack([v.x, v.y, v.z])


@each_roughness
@each_model
def test_the_facets_cover_the_surface_once(name, alpha):
    projected = density_at_cells(name, alpha) * CELLS.points[2]
    assert CELLS.integrals(projected).sum() == pytest.approx(1.0, abs=3e-4)


@each_cosine
@each_roughness
@each_model
def test_visible_area_is_the_integral_over_the_facets_that_face_a_direction(name, alpha, cosine):
    area = MODELS[name][1](facets(alpha), Vec3(*direction(cosine)))
    facing = np.maximum(0.0, np.sum(CELLS.points * direction(cosine), axis=0))
    integral = CELLS.integrals(density_at_cells(name, alpha) * facing).sum()
    assert area[0] == pytest.approx(integral, rel=5e-4)
    # What is hidden makes up for the rest: G1 <= 1.
    assert area[0] >= f(cosine) * (1.0 - 1e-7)


@each_cosine
@each_roughness
@each_model
def test_visible_normals_follow_their_density(name, alpha, cosine):
    _, area_of, sample = MODELS[name]
    u, wo = random_numbers(N, 1), Vec3(*direction(cosine))
    wm = stack(sample(facets(alpha), wo, (u[1], u[2])))
    assert length_error(wm) < 3e-7
    assert np.all(wm[2] > 0.0)
    facing = np.maximum(0.0, np.sum(CELLS.points * direction(cosine), axis=0))
    pdf = density_at_cells(name, alpha) * facing / area_of(facets(alpha), wo)
    p = chi_square(CELLS.counts(wm, np.ones(N, bool)), CELLS.integrals(pdf))
    assert p > SIGNIFICANCE


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.03])
@pytest.mark.parametrize("cosine", [1.0, 0.5, 1e-3])
@each_model
def test_narrow_distributions_keep_their_shape(name, alpha, cosine):
    u, wo = random_numbers(N, 3), Vec3(*direction(cosine, azimuth=0.0))
    wm = stack(MODELS[name][2](facets((alpha, alpha)), wo, (u[1], u[2])))
    assert length_error(wm) < 3e-7
    # Slopes in units of alpha. Across wo the distribution is even.
    assert abs(np.mean(wm[1] > 0.0) - 0.5) < 4.5 * 0.5 / np.sqrt(N)
    # Along wo the visible slopes have the density (z - m x) g(x) / sigma, where g is Gaussian, or
    # Student's with two degrees of freedom.
    area = float(MODELS[name][1](facets((alpha, alpha)), wo)[0])
    edges = np.linspace(-12.0, -0.5, 100_001)
    x = 0.5 * (edges[1:] + edges[:-1])
    g = np.exp(-x * x) / np.sqrt(np.pi) if name == "beckmann" else 0.5 / (1.0 + x * x) ** 1.5
    m = alpha * np.sqrt(1.0 - cosine * cosine)
    expected = np.maximum(0.0, cosine - m * x) @ g * (edges[1] - edges[0]) / area
    # Left of the grid g falls as 1 / (2 |x|^3), and its moments are known.
    if name == "ggx":
        expected += (cosine * 0.25 / 144.0 + m * 0.5 / 12.0) / area
    share = np.mean(-wm[0] / wm[2] < -0.5 * alpha)
    assert abs(share - expected) < 4.5 * np.sqrt(expected * (1.0 - expected) / N) + 2e-4


@pytest.mark.parametrize("cosine", [1.0, 0.7, 0.2, 0.01, 1e-4])
def test_visible_slopes_of_beckmann_are_the_inverse_of_their_distribution(cosine):
    u = np.concatenate([np.geomspace(1e-6, 0.01, 200), np.linspace(0.01, 0.999, 800)]).astype(f)
    wo = Vec3(*(direction(cosine, azimuth=0.0) + 0.0 * u))
    wm = sample_beckmann_visible(facets((1.0, 1.0)), wo, (u, np.full(u.shape, 0.5, f)))
    x, m = (-wm.x / wm.z).astype(float), np.sqrt(1.0 - cosine * cosine)
    z = float(f(cosine))
    a = z / max(m, 1e-9)
    area = z + 0.5 * m * np.exp(-a * a) / np.sqrt(np.pi) - 0.5 * z * erfc(a)
    reached = 0.5 * (z * erfc(-x) + m * np.exp(-x * x) / np.sqrt(np.pi)) / area
    np.testing.assert_allclose(reached, u, rtol=1e-5, atol=1e-6)
    # The other slope is at its median.
    np.testing.assert_allclose(wm.y / wm.z, 0.0, atol=1e-6)


def test_each_step_to_a_visible_slope_is_of_the_third_order():
    """From half as far away it ends eight times closer; a step of Newton's only four times."""
    rng, n = np.random.default_rng(4), 2000
    z, m, q = (rng.uniform(low, high, n) for low, high in ((0.3, 1.0), (0.05, 1.0), (0.4, 1.0)))
    x = -erfcinv(q)
    target = z * q + m * np.exp(-x * x) / np.sqrt(np.pi)
    off = [np.abs(_halley_step(z, m, target, q - h) - q).mean() for h in (0.2, 0.1, 0.05)]
    assert off[1] < off[0] / 6.0
    assert off[2] < off[1] / 6.0


def test_gaussian_quantile_is_the_inverse_error_function():
    tail = np.geomspace(1e-8, 0.5, 2000)
    q = np.concatenate([tail, 1.0 + 1e-3 * np.arange(1000)]).astype(f)
    exact = -erfcinv(q.astype(float))
    np.testing.assert_allclose(gaussian_quantile(q), exact, rtol=3e-6, atol=1e-7)


def test_beckmann_visible_area_is_the_error_function_form():
    a = np.linspace(0.01, 4.0, 2000)
    theta = np.arctan(1.0 / (0.5 * a))
    w = Vec3(f(np.sin(theta)), f(0.0 * a), f(np.cos(theta)))
    exact = np.exp(-a * a) / (2.0 * a * np.sqrt(np.pi)) - 0.5 * erfc(a)
    area = beckmann_visible_area(facets((0.5, 0.5)), w)
    # The stated error, and rounding.
    np.testing.assert_allclose(area, np.cos(theta) * (1.0 + exact), rtol=7e-6)


def test_ggx_visible_area_is_its_closed_form():
    theta = np.linspace(0.0, 1.55, 1000)
    w = Vec3(f(np.sin(theta)), f(0.0 * theta), f(np.cos(theta)))
    exact = 0.5 * (np.sqrt(1.0 + (0.3 * np.tan(theta)) ** 2) - 1.0)
    area = ggx_visible_area(facets((0.3, 0.9)), w)
    np.testing.assert_allclose(area, np.cos(theta) * (1.0 + exact), rtol=1e-6)


def test_mixtures_of_both_distributions_take_each_facet_by_its_own():
    both = Program(bsdfs=(GGX, BECKMANN))
    is_beckmann = (np.arange(N) % 3 == 0).astype(f)
    mixed = Facets(f(0.3), f(0.5), is_beckmann)
    u, w = random_numbers(N, 4), unit_vectors(N, 5)
    w[2] = np.abs(w[2])
    arguments = {
        facet_density: (Vec3(*w),),
        visible_area: (Vec3(*w),),
        sample_visible_facet: (Vec3(*w), (u[1], u[2])),
    }
    for kernel, rest in arguments.items():
        values = instantiate(kernel, both, compiled=False)(mixed, *rest)
        for name, mine in ((GGX, is_beckmann == 0.0), (BECKMANN, is_beckmann == 1.0)):
            alone = instantiate(kernel, Program(bsdfs=(name,)), compiled=False)(mixed, *rest)
            for x, y in zip(as_tuple(values), as_tuple(alone), strict=True):
                np.testing.assert_array_equal(x[mine], y[mine])


def as_tuple(value):
    return tuple(stack(value)) if isinstance(value, Vec3) else (value,)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 80.0, 88.0, 89.9])
@pytest.mark.parametrize("alpha", [0.05, 0.5, 1.0])
def test_beckmanns_visible_slopes_have_their_quantiles(angle, alpha):
    """Inverted to 1e-5, at the ends too, where the start must not lie beyond the solution."""
    z, m = np.cos(np.radians(angle)), alpha * np.sin(np.radians(angle))
    u = np.concatenate([np.linspace(0.001, 0.999, 999), 1.0 - 10.0 ** -np.arange(3.0, 6.0)])
    sizes = (np.full(len(u), c, np.float32) for c in (z, m))
    with np.errstate(all="ignore"):
        x = np.asarray(_visible_slope(*sizes, u.astype(np.float32)), float)

    def below(x):
        return z * erfc(-x) + m * np.exp(-x * x) / np.sqrt(np.pi)

    whole = below(z / m) if m > 0.0 else 2.0 * z
    np.testing.assert_allclose(below(x) / whole, u, atol=2e-5)
