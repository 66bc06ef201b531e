"""Laws of the laboratory's intervals and tests: coverage and level on both sides, and SciPy."""

import math
from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from alight.lab.statistics.intervals import (
    bootstrap_ratio,
    exponential,
    fit_slope,
    holm_adjusted,
    leave_one_out,
    log_mean,
    log_ratio,
    log_slope,
    mean_interval,
    positive_interval,
    quantile,
)
from alight.metrics.estimate import Estimate
from alight.metrics.statistics import holm


def within_chance(hits, trials, probability):
    """Whether a count is that of a probability: four standard errors on either side."""
    return abs(hits - trials * probability) <= 4.0 * math.sqrt(
        trials * probability * (1.0 - probability)
    )


def share_below_and_above(estimates, truth):
    """How many intervals lie above the truth, and how many below it."""
    low, high = (np.array([getattr(e, end) for e in estimates]) for end in ("low", "high"))
    return int((low > truth).sum()), int((high < truth).sum())


# ---------------------------------------------------------------------------- one arm


@pytest.mark.parametrize("count", [2, 3, 5, 17])
def test_intervals_of_a_mean_are_students_and_miss_on_either_side_alike(count):
    rng = np.random.default_rng(count)
    samples = rng.normal(3.0, 2.0, (3000, count))
    low, high = stats.t.interval(0.95, count - 1, samples[0].mean(), stats.sem(samples[0]))
    found = mean_interval(samples[0])
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-9)
    above, below = share_below_and_above([mean_interval(x) for x in samples], 3.0)
    assert within_chance(above, 3000, 0.025)
    assert within_chance(below, 3000, 0.025)


@pytest.mark.parametrize("dof", [1.0, 2.0, 3.5, 9.0, 31.0, 99.0])
def test_quantiles_of_two_digits_are_scipys(dof):
    assert quantile(dof) == pytest.approx(stats.t.ppf(0.975, dof), rel=1e-9)


def test_quantiles_of_more_digits_are_near_and_end_in_the_normal_one():
    for dof in (1.234, 17.77, 123.4, 4567.0):
        fewer, more = stats.t.ppf(0.975, [0.95 * dof, 1.05 * dof])
        assert more < quantile(dof) < fewer
    assert quantile(math.inf) == pytest.approx(stats.norm.ppf(0.975), rel=1e-6)


def test_means_without_one_are_those_of_the_others():
    values = np.random.default_rng(1).random((3, 7))
    expected = [np.delete(values, i, axis=1).mean(axis=1) for i in range(7)]
    np.testing.assert_allclose(leave_one_out(values), np.stack(expected, axis=1))


def jackknife(function, *arrays):
    """Value and variance by leaving out replicate after replicate."""
    count = len(arrays[0])
    without = np.array([function(*(np.delete(a, i) for a in arrays)) for i in range(count)])
    variance = (count - 1) / count * ((without - without.mean()) ** 2).sum()
    return function(*arrays), variance


def test_sums_and_differences_of_logarithms_know_that_replicates_belong_together():
    rng = np.random.default_rng(2)
    a = rng.gamma(4.0, size=9)
    # What costs twice as much has half the error: the cost hardly varies.
    b = (1.0 + 0.1 * rng.random(9)) / a
    both = log_mean(a) + log_mean(b)
    expected = jackknife(lambda x, y: math.log(x.mean() * y.mean()), a, b)
    assert (both.value, both.variance) == pytest.approx(expected, rel=1e-9)
    assert both.variance < 0.8 * (log_mean(a).variance + log_mean(b).variance)
    low, high = both.interval()[1:]
    assert high - low == pytest.approx(2.0 * stats.t.ppf(0.975, 8) * math.sqrt(expected[1]))


def test_scaling_laws_of_a_logarithm():
    x = np.random.default_rng(3).gamma(9.0, size=12)
    one, scaled, more = log_mean(x), log_mean(8.0 * x), log_mean(np.tile(x, 4))
    assert scaled.value - one.value == pytest.approx(math.log(8.0))
    assert scaled.variance == pytest.approx(one.variance, rel=1e-9)
    # Four times the replicates, half the standard error (and S - 1 for S).
    assert more.variance / one.variance == pytest.approx(11.0 / 47.0, rel=0.02)


def test_a_mean_of_what_is_positive_has_a_positive_interval():
    x = np.array([0.1, 0.2, 1.9])
    found = positive_interval(x)
    assert found == pytest.approx(np.exp(log_mean(x).interval()))
    assert found.low > 0.0 > mean_interval(x).low
    assert found.low * found.high == pytest.approx(found.value**2)
    # One replicate holds all that is positive: no logarithm, but an interval.
    mixed = np.array([-1.0, 4.0, -1.0])
    assert positive_interval(mixed) == mean_interval(mixed)
    with pytest.raises(ValueError, match="not positive"):
        log_mean(np.array([-0.5, 4.0, 0.3, -1.0, 0.1]))


def test_exponentials_keep_their_order_and_are_finite():
    found = exponential(Estimate(20.0, -3.0, 1e5))
    assert found[:2] == pytest.approx((math.exp(20.0), math.exp(-3.0)))
    assert found.value < found.high < math.inf


# ---------------------------------------------------------------------------- two arms


def arms(rng, paired, spread=1e-3, sizes=(4, 9), scales=(1.0, 3.0)):
    """Numbers that hardly vary: their logarithm is linear, and the jackknife is the t test."""
    if paired:
        common = rng.standard_normal(sizes[0])
        a, b = (common + rng.standard_normal((2, sizes[0])) * np.array(scales)[:, None]) * spread
        return 1.0 + a, 1.0 + b
    return tuple(
        1.0 + spread * scale * rng.standard_normal(n)
        for n, scale in zip(sizes, scales, strict=True)
    )


@pytest.mark.parametrize("paired", [False, True])
@pytest.mark.parametrize("sizes", [(3, 3), (4, 4), (3, 12), (12, 3)])
def test_ratios_are_the_t_tests_of_scipy(paired, sizes):
    rng = np.random.default_rng(sum(sizes) + paired)
    a, b = arms(rng, paired, 1e-6, sizes)
    test = stats.ttest_rel(a, b) if paired else stats.ttest_ind(a, b, equal_var=False)
    found = log_ratio(log_mean(a), log_mean(b), paired=paired)
    assert found.p_value == pytest.approx(test.pvalue, rel=1e-4)
    expected = np.array([a.mean() - b.mean(), *test.confidence_interval()])
    width = expected[2] - expected[1]
    # Degrees of freedom of intervals have two digits.
    assert np.array(found.estimate) - 1.0 == pytest.approx(expected, abs=0.01 * width)
    other = log_ratio(log_mean(b), log_mean(a), paired=paired)
    assert other.estimate == pytest.approx([1.0 / found.estimate[i] for i in (0, 2, 1)], rel=1e-12)
    assert other.p_value == pytest.approx(found.p_value, rel=1e-9)


@pytest.mark.parametrize("paired", [False, True])
def test_p_values_of_equal_arms_are_uniform_and_intervals_cover(paired):
    rng, p_values, estimates = np.random.default_rng(5), [], []
    for _ in range(1000):
        a, b = arms(rng, paired, sizes=(4, 4) if paired else (8, 8))
        found = log_ratio(log_mean(2.0 * a), log_mean(b), paired=paired)
        estimates.append(found.estimate)
        p_values.append(log_ratio(log_mean(a), log_mean(b), paired=paired).p_value)
    assert stats.kstest(p_values, "uniform").pvalue > 0.001
    above, below = share_below_and_above(estimates, 2.0)
    assert within_chance(above, 1000, 0.025)
    assert within_chance(below, 1000, 0.025)


@pytest.mark.parametrize("paired", [False, True])
def test_the_power_is_that_of_the_t_test(paired):
    """A difference of three standard errors is found as often as the noncentral t says."""
    rng, count, trials = np.random.default_rng(6), 6, 600
    shift = 3.0 * math.sqrt(2.0 / count) * 1e-3
    found = 0
    for _ in range(trials):
        a, b = arms(rng, paired, sizes=(count, count), scales=(1.0, 1.0))
        found += log_ratio(log_mean(a + shift), log_mean(b), paired=paired).p_value < 0.05
    dof = count - 1 if paired else 2 * (count - 1)
    critical = stats.t.ppf(0.975, dof)
    power = stats.nct.sf(critical, dof, 3.0) + stats.nct.cdf(-critical, dof, 3.0)
    assert within_chance(found, trials, power)


def test_noise_that_is_known_adds_to_the_variance_and_costs_no_degrees_of_freedom():
    rng = np.random.default_rng(7)
    a, b = arms(rng, True, sizes=(5, 5))
    for extra in (1e-8, 1e-6, 1e-4):
        found = log_ratio(log_mean(a), log_mean(b), paired=True, extra_variance=extra)
        own = np.var(np.log(a) - np.log(b), ddof=1) / 5
        variance = own + extra
        # Satterthwaite: variance^2 / dof = own^2 / 4 + extra^2 / infinity.
        dof = 4.0 * (variance / own) ** 2
        t = (log_mean(a).value - log_mean(b).value) / math.sqrt(variance)
        assert found.p_value == pytest.approx(2.0 * stats.t.sf(abs(t), dof), rel=1e-3)
        width = 0.5 * math.log(found.estimate.high / found.estimate.low)
        assert width == pytest.approx(stats.t.ppf(0.975, dof) * math.sqrt(variance), rel=0.01)


def test_a_difference_without_spread_is_certain_and_one_of_known_noise_is_normal():
    ones = np.ones(4)
    apart = log_ratio(log_mean(2.0 * ones), log_mean(ones))
    assert (apart.estimate, apart.p_value) == (pytest.approx((2.0, 2.0, 2.0)), 0.0)
    assert log_ratio(log_mean(ones), log_mean(ones)).p_value == 1.0
    found = log_ratio(log_mean(1.1 * ones), log_mean(ones), extra_variance=0.01)
    assert found.p_value == pytest.approx(2.0 * stats.norm.sf(math.log(1.1) / 0.1), rel=1e-6)
    assert math.log(found.estimate.high / 1.1) == pytest.approx(0.1959964, rel=1e-5)


# ---------------------------------------------------------------------------- many tests


def test_holm_is_the_closed_test_of_bonferroni():
    """The adjusted p-value is the largest of Bonferroni's over all families that have the test."""
    rng = np.random.default_rng(8)
    for size in (1, 2, 3, 5):
        for _ in range(20):
            p = rng.random(size) ** 3
            families = [c for n in range(1, size + 1) for c in combinations(range(size), n)]
            expected = [
                min(1.0, max(len(c) * min(p[j] for j in c) for c in families if i in c))
                for i in range(size)
            ]
            found = holm_adjusted(p.tolist())
            assert found == pytest.approx(expected)
            assert [q <= 0.05 for q in found] == holm(p.tolist(), 0.05)


def test_the_level_of_a_family_is_kept_and_used():
    p = np.random.default_rng(9).random((4000, 10))
    alarms = sum(min(holm_adjusted(row.tolist())) < 0.05 for row in p)
    assert within_chance(alarms, 4000, 1.0 - (1.0 - 0.05 / 10) ** 10)
    # One that is false is always found; the other nine are then a family of nine.
    p[:, 3] = 1e-9
    alarms = sum(np.delete(holm_adjusted(row.tolist()), 3).min() < 0.05 for row in p)
    assert within_chance(alarms, 4000, 1.0 - (1.0 - 0.05 / 9) ** 9)


# ---------------------------------------------------------------------------- bootstrap-t


@pytest.mark.parametrize("paired", [False, True])
def test_the_bootstrap_is_as_wide_as_the_jackknife_for_arms_that_share_their_noise(paired):
    rng = np.random.default_rng(10)
    common = 0.3 * rng.standard_normal(80)
    a, b = np.exp(common + 0.03 * rng.standard_normal((2, 80)))
    # One replicate is slow where its error is small: what it costs varies less than both.
    upper, lower = [a, 2.0 / a**0.5], [b, 1.0 / b**0.5]
    costs = [log_mean(one[0]) + log_mean(one[1]) for one in (upper, lower)]
    jack = log_ratio(*costs, paired=paired).estimate
    boot = bootstrap_ratio(upper, lower, 5, paired=paired)
    assert boot.value == pytest.approx(jack.value)
    ratio = math.log(boot.high / boot.low) / math.log(jack.high / jack.low)
    assert 0.85 < ratio < 1.2


def bootstrap_t(rng, upper, lower, paired):
    """Ends of the interval of a log ratio of means, relative to it, by 40 000 plain resamples."""

    def studentised(a, b):
        a, b = a / a.mean(axis=-1, keepdims=True), b / b.mean(axis=-1, keepdims=True)
        if paired:
            return (a - b).std(axis=-1, ddof=1) / math.sqrt(a.shape[-1])
        return np.sqrt(sum(one.var(axis=-1, ddof=1) / one.shape[-1] for one in (a, b)))

    first = rng.integers(0, len(upper), (40_000, len(upper)))
    second = first if paired else rng.integers(0, len(lower), (40_000, len(lower)))
    a, b = upper[first], lower[second]
    moved = np.log(a.mean(axis=1) / b.mean(axis=1)) - math.log(upper.mean() / lower.mean())
    t, own = moved / studentised(a, b), studentised(upper, lower)
    return np.quantile(t, 0.975) * own, -np.quantile(t, 0.025) * own


def long_tail(count, width):
    """Log-normal numbers without chance."""
    return np.exp(width * stats.norm.ppf((np.arange(count) + 0.5) / count))


@pytest.mark.parametrize(
    ("upper", "lower", "paired"),
    [
        (long_tail(20, 1.5), np.ones(20), False),
        (np.ones(20), long_tail(20, 1.5), False),
        (long_tail(9, 0.7), long_tail(24, 1.2), False),
        (long_tail(20, 1.5), long_tail(20, 0.8), True),
        (long_tail(20, 1.5), long_tail(20, 0.8)[::-1], True),
    ],
    ids=["above", "below", "both", "together", "against"],
)
def test_the_bootstrap_reaches_farther_to_where_the_data_are_skewed(upper, lower, paired):
    """Of few long-tailed numbers the mean is more often far too small than far too large."""
    down, up = bootstrap_t(np.random.default_rng(11), upper, lower, paired)
    found = [bootstrap_ratio([upper], [lower], seed, paired=paired) for seed in range(10)]
    ups = [math.log(one.high / one.value) for one in found]
    downs = [math.log(one.value / one.low) for one in found]
    assert np.mean(ups) == pytest.approx(up, rel=0.06)
    assert np.mean(downs) == pytest.approx(down, rel=0.06)
    assert not 0.9 < up / down < 1.1
    # Resamples are enough: another seed moves an end by some percent of the width.
    assert max(np.std(ups), np.std(downs)) < 0.1 * (up + down)


def test_the_bootstrap_misses_on_either_side_alike():
    rng, estimates, trials = np.random.default_rng(12), [], 300
    for seed in range(trials):
        a, b = rng.standard_exponential((2, 24))
        estimates.append(bootstrap_ratio([3.0 * a], [b], seed))
    above, below = share_below_and_above(estimates, 3.0)
    assert within_chance(above, trials, 0.03)
    assert within_chance(below, trials, 0.03)


# ---------------------------------------------------------------------------- slopes


def test_slopes_are_least_squares_and_their_error_the_jackknife():
    rng = np.random.default_rng(13)
    x = np.array([4.0, 16.0, 64.0, 256.0])[:, None] * np.exp(0.1 * rng.standard_normal((4, 7)))
    y = 5.0 / x**0.8 * np.exp(0.3 * rng.standard_normal((4, 7)))

    def slope(without):
        keep = [i for i in range(7) if i != without]
        return np.polyfit(np.log(x[:, keep].mean(axis=1)), np.log(y[:, keep].mean(axis=1)), 1)[0]

    rest = np.array([slope(i) for i in range(7)])
    width = stats.t.ppf(0.975, 6) * math.sqrt(6 / 7 * ((rest - rest.mean()) ** 2).sum())
    found, value = log_slope(x, y), slope(None)
    assert found.value == pytest.approx(value)
    assert found.high - found.low == pytest.approx(2.0 * width)
    # Units do not matter, powers do.
    assert log_slope(60.0 * x, 7.0 * y) == pytest.approx(found)
    assert fit_slope(np.log(x), np.log(y)) == pytest.approx(
        [np.polyfit(np.log(x[:, i]), np.log(y[:, i]), 1)[0] for i in range(7)]
    )


def test_slopes_cover_on_both_sides():
    rng, trials = np.random.default_rng(14), 800
    x = np.repeat(np.array([4.0, 16.0, 64.0])[:, None], 5, axis=1)
    noise = 1.0 + 0.02 * rng.standard_normal((trials, 3, 5))
    estimates = [log_slope(x, x**-1.3 * one) for one in noise]
    above, below = share_below_and_above(estimates, -1.3)
    assert within_chance(above, trials, 0.025)
    assert within_chance(below, trials, 0.025)


@pytest.mark.parametrize("y", [[[1.0, 2.0]], [[1.0, 2.0], [0.5, -0.1]]])
def test_slopes_of_too_little_are_unknown(y):
    assert math.isnan(log_slope(np.ones((len(y), 2)), np.array(y)).value)
