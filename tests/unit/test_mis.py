"""Weights of multiple importance sampling."""

import numpy as np
import pytest

from alight.core.mis import balance_heuristic, power_heuristic

f = np.float32
HUGE, TINY = 3e38, 1e-38


@pytest.mark.parametrize(("heuristic", "power"), [(balance_heuristic, 1), (power_heuristic, 2)])
def test_weights_are_the_closed_form(heuristic, power):
    rng = np.random.default_rng(1)
    a, b = np.exp(rng.normal(size=(2, 10_000))).astype(f)
    exact = a.astype(float) ** power / (a.astype(float) ** power + b.astype(float) ** power)
    np.testing.assert_allclose(heuristic(a, b), exact, rtol=5e-7)


@pytest.mark.parametrize("heuristic", [balance_heuristic, power_heuristic])
def test_both_weights_add_up_to_one_for_all_densities(heuristic):
    values = f([0.0, TINY, 1e-20, 1e-3, 1.0, 7.0, 1e20, HUGE, np.inf])
    a, b = (v.ravel() for v in np.meshgrid(values, values))
    with np.errstate(all="raise", under="ignore"):
        there, back = heuristic(a, b), heuristic(b, a)
    np.testing.assert_allclose(there + back, 1.0, rtol=2e-7)
    assert np.all((there >= 0.0) & (there <= 1.0))


@pytest.mark.parametrize("heuristic", [balance_heuristic, power_heuristic])
def test_the_only_possible_technique_gets_all(heuristic):
    values = f([TINY, 1.0, HUGE, np.inf])
    np.testing.assert_array_equal(heuristic(values, np.zeros_like(values)), 1.0)
    np.testing.assert_array_equal(heuristic(np.zeros_like(values), values), 0.0)


def test_power_heuristic_squares():
    assert power_heuristic(f(3.0), f(1.0)) == f(0.9)
    assert balance_heuristic(f(3.0), f(1.0)) == f(0.75)
