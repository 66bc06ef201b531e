"""Laws of the integrals without a scene: rules are exact where they must be, errors as theory."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import special, stats

from alight.lab.integrals import (
    INTEGRANDS,
    RADIUS,
    _panel,
    jittered_points,
    orthant_volume,
    product_error,
    product_rule,
    sampler_points,
    sequences,
    sides,
)


@pytest.mark.parametrize("d", [1, 2, 3, 4, 6])
def test_integrands_integrate_to_one(d):
    # A ball of d dimensions, of which 2^-d lies in the first orthant.
    ball = math.pi ** (d / 2) / special.gamma(d / 2 + 1) * RADIUS**d
    assert orthant_volume(d) == pytest.approx(ball / 2**d)
    x = np.random.default_rng(d).random((200_000, d))
    for f in INTEGRANDS.values():
        values = f(x)
        assert values.mean() == pytest.approx(1.0, abs=4.0 * values.std() / math.sqrt(len(x)))
    assert product_error(INTEGRANDS["smooth"], "gauss", 8, d) < 1e-9


@pytest.mark.parametrize(
    ("name", "k", "degree"),
    [("midpoint", 1, 1), ("midpoint", 5, 1), ("simpson", 3, 3), ("simpson", 7, 3),
     ("gauss", 1, 1), ("gauss", 2, 3), ("gauss", 4, 7)],
)  # fmt: skip
def test_product_rules_are_exact_up_to_their_degree_and_not_beyond(name, k, degree):
    nodes, weights = product_rule(name, k)
    assert len(nodes) == len(weights) == k
    assert np.all((nodes >= 0.0) & (nodes <= 1.0))
    for power in range(degree + 1):
        assert weights @ nodes**power == pytest.approx(1.0 / (power + 1), rel=1e-12)
    assert weights @ nodes ** (degree + 1) != pytest.approx(1.0 / (degree + 2), rel=1e-6)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_products_of_rules_are_products_of_sums(d):
    """Of a product of powers the rule's value is that of one dimension to the power d."""
    nodes, weights = product_rule("midpoint", 4)
    one = weights @ nodes**2
    error = product_error(lambda x: np.prod(x**2, axis=-1), "midpoint", 4, d)
    assert error == pytest.approx(abs(one**d - 1.0))


def test_jittered_points_are_one_in_each_cell_and_uniform_within():
    rng = np.random.default_rng(1)
    points = jittered_points(5, 3, 40, rng)
    cells = np.floor(5 * points).astype(int) @ [25, 5, 1]
    assert all(sorted(row) == list(range(125)) for row in cells.tolist())
    within = 5 * points - np.floor(5 * points)
    for i in range(3):
        assert stats.kstest(within[..., i].ravel(), "uniform").pvalue > 1e-4
        # Cells of a replicate know nothing of each other.
        means = within[..., i].mean(axis=1)
        assert means.var() == pytest.approx(1.0 / 12.0 / 125, rel=0.9)


@pytest.mark.parametrize("name", sequences())
@pytest.mark.parametrize("d", [1, 2, 3, 6])
def test_points_of_samplers_are_uniform_and_their_dimensions_independent(name, d):
    points = sampler_points(sequences()[name].EXAMPLES[0], 64, d, 48, 7)
    assert points.shape == (48, 64, d)
    flat = points.reshape(-1, d)
    assert np.all((flat >= 0.0) & (flat < 1.0))
    for i in range(d):
        assert stats.kstest(flat[:, i], "uniform").pvalue > 1e-4
        for j in range(i):
            # Of 3072 independent pairs: four standard errors are 0.07.
            assert abs(np.corrcoef(flat[:, i], flat[:, j])[0, 1]) < 0.08
    # Each replicate has points of its own, each seed too.
    assert len(np.unique(points[:, 0, 0])) > 40
    assert (sampler_points(sequences()[name].EXAMPLES[0], 64, d, 48, 8) != points).any()


@pytest.mark.parametrize("d", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("odd", [False, True])
def test_sides_of_grids_double_the_nodes(d, odd):
    found = sides(d, 4096, odd=odd)
    assert found == sorted(set(found))
    assert all(k**d <= 4096 and (k % 2 or not odd) for k in found)
    assert found[0] == (3 if odd else 2)
    for k, after in pairwise(found):
        fitting = [n for n in range(k + 1, after + 1) if n**d >= 1.9 * k**d and (n % 2 or not odd)]
        assert after == fitting[0]


@pytest.mark.parametrize("integrand", INTEGRANDS)
def test_errors_of_independent_points_are_their_variance_over_n(integrand):
    """The root mean square over replicates, its interval, and the slopes that theory names."""
    d = 2
    panel = _panel(3, integrand, d, 256, 64)
    curves = {curve.name: curve for curve in panel.curves}
    if integrand == "smooth":
        variance = (math.pi**2 / 8.0) ** d - 1.0
    else:
        variance = 1.0 / orthant_volume(d) - 1.0
    one = curves["independent"]
    held = 0
    for n, value, low, high in zip(one.x, one.y, one.low, one.high, strict=True):
        truth = math.sqrt(variance / n)
        # Of 64 squared errors: a standard error of 9 % of the root.
        assert value == pytest.approx(truth, rel=0.36)
        assert low < value < high
        held += low <= truth <= high
    assert held >= len(one.x) - 2
    assert one.slope.low < -0.5 < one.slope.high
    expected = {"independent": -0.5, "jittered": -1.0 if integrand == "smooth" else -0.75}
    for name, slope in expected.items():
        assert curves[name].expected_slope == slope
        assert curves[name].slope.value == pytest.approx(slope, abs=0.15)
    if integrand == "smooth":
        assert curves["sobol"].expected_slope == -1.5
        assert curves["sobol"].slope.value == pytest.approx(-1.5, abs=0.25)
        # A product rule of error h^p falls as N^(-p / d).
        assert curves["midpoint"].slope.value == pytest.approx(-2.0 / d, abs=0.1)
        # Simpson's few nodes are still on their way to it.
        assert curves["simpson"].slope.value < -4.0 / d
