"""Our own distributions against SciPy's, and the tests built on them."""

import math

import numpy as np
import pytest
from scipy import special, stats

from alight.metrics.statistics import (
    f_quantile,
    holm,
    incomplete_beta,
    normal_from_tail,
    student_t_quantile,
    student_t_tail,
    sum_of_squares_tails,
    t_to_z,
    welch,
)

DOFS = [1.0, 2.0, 3.0, 7.5, 31.0, 62.3, 1000.0, 1e6]


@pytest.mark.parametrize("dof", DOFS)
def test_tails_of_student_t_are_right_to_nine_digits(dof):
    # Below 1e-4 SciPy's own values for one degree of freedom are wrong in the ninth digit.
    t = np.concatenate([[0.0], np.logspace(-4, 1.5, 400)])
    truth = 2 * stats.t.sf(t, dof)
    seen = truth > 1e-250
    tolerance = 1e-9 if dof < 1e5 else 2e-8
    np.testing.assert_allclose(student_t_tail(t, dof)[seen], truth[seen], rtol=tolerance)
    np.testing.assert_array_equal(student_t_tail(-t, np.float64(dof)), student_t_tail(t, dof))


def test_one_degree_of_freedom_is_cauchys_distribution():
    t = np.logspace(-8, 6, 100)
    np.testing.assert_allclose(student_t_tail(t, 1.0), 2 / np.pi * np.arctan(1 / t), rtol=1e-12)


def test_infinite_degrees_of_freedom_are_normal():
    t = np.linspace(0, 30, 200)
    np.testing.assert_allclose(student_t_tail(t, math.inf), 2 * stats.norm.sf(t), rtol=1e-12)


def test_incomplete_beta_over_its_whole_range():
    rng = np.random.default_rng(1)
    a, b, x = rng.uniform(0.3, 80, 2000), rng.uniform(0.3, 80, 2000), rng.uniform(0, 1, 2000)
    np.testing.assert_allclose(
        incomplete_beta(a, b, x, 1 - x), special.betainc(a, b, x), rtol=1e-10, atol=1e-280
    )


@pytest.mark.parametrize("dof", [1.0, 3.0, 30.0, 1e9])
@pytest.mark.parametrize("p", [1e-9, 0.025, 0.4, 0.5, 0.975, 1 - 1e-9])
def test_quantiles_of_student_t(dof, p):
    assert student_t_quantile(p, dof) == pytest.approx(stats.t.ppf(p, dof), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("dof", [2.0, 2.3, 8.2, 29.0, 300.0])
def test_a_quantile_needs_a_few_tails(monkeypatch, dof):
    """Where the tail is rounded, no bracket is halved again from one end to the other."""
    asked = []

    def counted(t, nu):
        asked.append(t)
        return student_t_tail(t, nu)

    monkeypatch.setattr("alight.metrics.statistics.student_t_tail", counted)
    student_t_quantile(0.975, dof)
    assert len(asked) <= 10


@pytest.mark.parametrize(("p", "dof"), [(0.0, 3), (1.0, 3), (0.5, 0)])
def test_impossible_quantiles_are_refused(p, dof):
    with pytest.raises(ValueError, match="must lie in"):
        student_t_quantile(p, dof)
    for dofs in ((dof, 3.0), (3.0, dof)) if p == 0.5 else ((3.0, 3.0),):
        with pytest.raises(ValueError, match="must lie in"):
            f_quantile(p, *dofs)


@pytest.mark.parametrize("p", [1e-4, 0.025, 0.3, 0.5, 0.975, 0.9999])
def test_quantiles_of_fisher_are_scipys_and_have_two_sides(p):
    for dof1, dof2 in [(1.0, 3.0), (3.0, 1.0), (7.5, 31.0), (49.0, 1e4), (12.0, 12.0)]:
        found = f_quantile(p, dof1, dof2)
        assert found == pytest.approx(stats.f.ppf(p, dof1, dof2), rel=1e-9)
        # The ratio turned over.
        assert found == pytest.approx(1.0 / f_quantile(1.0 - p, dof2, dof1), rel=1e-9)
    # Many degrees of freedom: a formula.
    for dof1, dof2 in [(51.0, 51.0), (60.0, 180.0), (51.0, 5000.0), (5000.0, 51.0)]:
        tolerance = 3e-4 if 1e-3 < p < 0.999 else 6e-3
        expected = stats.f.ppf(p, dof1, dof2)
        assert f_quantile(p, dof1, dof2) == pytest.approx(expected, rel=tolerance)


def test_incomplete_beta_has_two_sides_and_a_closed_form_for_whole_numbers():
    """I_x(a, b) is the probability of a successes or more in a + b - 1 trials."""
    for a, b, x in [(2.0, 5.0, 0.2), (5.0, 2.0, 0.2), (1.0, 1.0, 0.7), (9.0, 3.0, 0.9)]:
        found = float(incomplete_beta(a, b, x, 1.0 - x))
        assert found == pytest.approx(stats.binom.sf(a - 1, a + b - 1, x), rel=1e-12)
        assert found == pytest.approx(1.0 - float(incomplete_beta(b, a, 1.0 - x, x)), rel=1e-9)
    # Even the longest fractions are summed to their end.
    for a, b in [(1e5, 0.5), (0.5, 1e5), (3e3, 4e3)]:
        for x in (a / (a + b)) * np.array([0.9, 0.999, 1.0]):
            found = float(incomplete_beta(a, b, x, 1.0 - x))
            assert found == pytest.approx(special.betainc(a, b, x), rel=1e-8, abs=1e-250)


def test_z_has_the_tail_of_t():
    t = np.array([-40.0, -2.0, 0.0, 0.3, 5.0, 400.0])
    dof = np.array([62.0, 3.0, 5.0, 8.0, 10.0, 62.0])
    # Above a tail of 1e-300 only: z stops there.
    expected = np.sign(t) * stats.norm.isf(stats.t.sf(np.abs(t), dof))
    np.testing.assert_allclose(t_to_z(t, dof), expected, rtol=1e-9, atol=1e-9)


def test_z_stops_where_tails_vanish():
    z = normal_from_tail(np.array([0.0, 1.0]), np.array([-1.0, 1.0]))
    assert -38 < z[0] < -36
    assert z[1] == 0.0


def test_z_of_equal_noise_is_standard_normal():
    rng = np.random.default_rng(2)
    a, b = rng.normal(3, 1.0, (5, 20_000)), rng.normal(3, 4.0, (9, 20_000))
    t, dof = welch(a.mean(0), a.var(0, ddof=1), 5, b.mean(0), b.var(0, ddof=1), 9)
    assert stats.kstest(t_to_z(t, dof), "norm").pvalue > 0.01


def test_welch_is_scipys():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(40, 100)), rng.normal(0.2, 3.0, size=(32, 100))
    t, dof = welch(a.mean(0), a.var(0, ddof=1), 40, b.mean(0), b.var(0, ddof=1), 32)
    result = stats.ttest_ind(a, b, equal_var=False)
    np.testing.assert_allclose(t, result.statistic)
    np.testing.assert_allclose(student_t_tail(t, dof), result.pvalue, rtol=1e-9)


def test_welch_of_values_without_spread():
    t, dof = welch(
        np.array([1.0, 2.0, 0.0]), np.zeros(3), 8, np.array([1.0, 1.0, 3.0]), np.zeros(3), 8
    )
    assert t.tolist() == [0.0, math.inf, -math.inf]
    assert np.isinf(dof).all()
    assert student_t_tail(t, dof).tolist() == [1.0, 0.0, 0.0]


def test_welch_against_an_exact_value_is_the_one_sample_test():
    a = np.random.default_rng(4).normal(size=12)
    t, dof = welch(a.mean(), a.var(ddof=1), 12, np.float64(0.3), np.float64(0.0), math.inf)
    assert float(dof) == pytest.approx(11)
    assert float(t) == pytest.approx(stats.ttest_1samp(a, 0.3).statistic)


def test_variances_too_small_to_be_squared_still_count():
    _, dof = welch(np.array(1e-160), np.array(1e-200), 8, np.array(0.0), np.array(1e-200), 8)
    assert float(dof) == pytest.approx(14)


@pytest.mark.parametrize("sizes", [(3, 3), (4, 20), (20, 4)])
def test_welch_keeps_its_level_and_has_the_power_of_t(sizes):
    """The side of few observations is the noisy one, or the quiet one."""
    rng, level = np.random.default_rng(5), 0.05
    for deviations in ((1.0, 3.0), (3.0, 1.0)):
        a, b = (s * rng.standard_normal((n, 4000)) for n, s in zip(sizes, deviations, strict=True))
        t, dof = welch(a.mean(0), a.var(0, ddof=1), sizes[0], b.mean(0), b.var(0, ddof=1), sizes[1])
        alarms = (student_t_tail(t, dof) < level).mean()
        # Welch's approximation is good to about a percent even for three observations.
        assert abs(alarms - level) < 0.012 + 4.0 * math.sqrt(level * (1.0 - level) / 4000)


def test_welch_has_the_power_of_t():
    rng, count, trials = np.random.default_rng(6), 10, 4000
    a, b = rng.standard_normal((2, count, trials))
    t, dof = welch(a.mean(0) + 1.0, a.var(0, ddof=1), count, b.mean(0), b.var(0, ddof=1), count)
    dof_of_equals = 2 * (count - 1)
    shift, limit = 1.0 / math.sqrt(2.0 / count), stats.t.ppf(0.975, dof_of_equals)
    power = stats.nct.sf(limit, dof_of_equals, shift) + stats.nct.cdf(-limit, dof_of_equals, shift)
    # Welch pays a little for not knowing that both vary alike.
    assert (student_t_tail(t, dof) < 0.05).mean() == pytest.approx(power - 0.005, abs=0.035)


def test_holm_steps_down():
    # 0.01 <= 0.04/4, 0.013 <= 0.04/3, 0.03 > 0.04/2: stop.
    assert holm([0.03, 0.01, 0.9, 0.013], 0.04) == [False, True, False, True]
    assert holm([], 0.01) == []
    assert holm([math.nan, 0.5], 0.01) == [True, False]
    assert holm([0.5, math.nan, 1e-9], 0.01) == [False, True, True]


def test_sums_of_squares_of_normal_numbers_are_chi_square():
    """Up to the spread that the squares show themselves, if that is larger."""
    z = np.random.default_rng(3).standard_normal(400)
    scale = max(float((z**2).var(ddof=1)), 2.0) / 2.0
    below, above = sum_of_squares_tails(z)
    assert above == pytest.approx(stats.chi2.sf((z**2).sum() / scale, 400 / scale), rel=1e-8)
    assert below + above == pytest.approx(1.0)
    # Even squares spread less than normal numbers' do: chi-square it is.
    assert sum_of_squares_tails(np.full(9, 1.5))[1] == pytest.approx(stats.chi2.sf(9 * 2.25, 9))


def test_one_large_number_is_not_many():
    """100 z of which one is 12: the largest says so, not the sum of squares."""
    z = np.random.default_rng(4).standard_normal(100)
    z[7] = 12.0
    assert stats.chi2.sf((z**2).sum(), 100) < 1e-8
    assert sum_of_squares_tails(z)[1] > 1e-3
