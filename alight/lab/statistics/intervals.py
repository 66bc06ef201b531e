r"""What replicates say about an arm: intervals, speed-ups, slopes.

An arm has S independent replicates, each with a squared error d_i and a time t_i. The logarithm of
what an error costs, log(mean d) + log(mean t), is smooth in both means, so the jackknife gives its
standard error, and Student's t with S - 1 degrees of freedom (Welch's for two arms) an interval:
Tukey 1958; Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapter 11. Their
bootstrap-t (section 12.5) is the cross-check: it knows about skewness, and nothing about normality.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from alight.metrics.estimate import Estimate
from alight.metrics.statistics import student_t_quantile, student_t_tail

#: Of two-sided intervals.
LEVEL = 0.95

#: Resamples of the bootstrap-t.
RESAMPLES = 999


@dataclass(frozen=True)
class Statistic:
    """A number worked out from S replicates, with its jackknife pseudo-values.

    Attributes
    ----------
    value : float
    pseudo : ndarray of float64, shape (S,)
        S times `value` minus (S - 1) times the value without replicate i: they behave like
        independent observations of it.
    """

    value: float
    pseudo: np.ndarray

    @property
    def variance(self) -> float:
        """Of `value`."""
        return float(self.pseudo.var(ddof=1)) / len(self.pseudo)

    def interval(self) -> Estimate:
        """95 % t interval."""
        return _t_interval(self.value, self.variance, len(self.pseudo) - 1)

    def __add__(self, other: Statistic) -> Statistic:
        """Sum of two numbers of the same replicates."""
        return Statistic(self.value + other.value, self.pseudo + other.pseudo)


@dataclass(frozen=True)
class Ratio:
    """A ratio of two arms.

    Attributes
    ----------
    estimate : Estimate
    p_value : float
        Of "the ratio is 1".
    """

    estimate: Estimate
    p_value: float


def leave_one_out(values: np.ndarray) -> np.ndarray:
    """Means over all replicates but one, along the last axis."""
    values = np.asarray(values, np.float64)
    return (values.sum(axis=-1, keepdims=True) - values) / (values.shape[-1] - 1)


def log_mean(values: np.ndarray) -> Statistic:
    """Logarithm of the mean.

    Parameters
    ----------
    values : ndarray, shape (S,)
        S >= 2.

    Raises
    ------
    ValueError
        If the mean, with or without any one replicate, is not positive.
    """
    values = np.asarray(values, np.float64)
    count, mean, rest = len(values), float(values.mean()), leave_one_out(values)
    if not (mean > 0.0 and (rest > 0.0).all()):
        raise ValueError("the mean is not positive")
    return Statistic(math.log(mean), count * math.log(mean) - (count - 1) * np.log(rest))


def mean_interval(values: np.ndarray) -> Estimate:
    """Mean with its 95 % t interval."""
    values = np.asarray(values, np.float64)
    return Statistic(float(values.mean()), values).interval()


def positive_interval(values: np.ndarray) -> Estimate:
    """Mean of what is positive, with an interval that is so too if the data allow it."""
    try:
        return exponential(log_mean(values).interval())
    except ValueError:
        return mean_interval(values)


def exponential(estimate: Estimate) -> Estimate:
    """The exponential of an estimate of a logarithm."""
    return Estimate(*(math.exp(min(v, 700.0)) for v in estimate))


def log_ratio(
    upper: Statistic, lower: Statistic, *, paired: bool = False, extra_variance: float = 0.0
) -> Ratio:
    """The ratio of two positive numbers from the statistics of their logarithms.

    Parameters
    ----------
    upper, lower : Statistic
    paired : bool
        Whether replicate i of both used the same seed.
    extra_variance : float
        Of the difference of the logarithms, from what both sides share: the reference's noise.
    """
    difference = upper.value - lower.value
    if paired:
        own = Statistic(difference, upper.pseudo - lower.pseudo).variance
        dof = len(upper.pseudo) - 1.0
    else:
        a, b = upper.variance, lower.variance
        own = a + b
        n_a, n_b = len(upper.pseudo) - 1, len(lower.pseudo) - 1
        # Shares, not squares: those underflow.
        share = a / own if own > 0.0 else 0.5
        dof = 1.0 / (share**2 / n_a + (1.0 - share) ** 2 / n_b)
    variance = own + extra_variance
    if variance == 0.0:
        p = 1.0 if difference == 0.0 else 0.0
        return Ratio(exponential(Estimate(difference, difference, difference)), p)
    # Welch and Satterthwaite: the part that is known exactly takes no degrees of freedom.
    dof = dof * (variance / own) ** 2 if own > 0.0 else math.inf
    p = float(student_t_tail(difference / math.sqrt(variance), dof))
    return Ratio(exponential(_t_interval(difference, variance, dof)), p)


def holm_adjusted(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values by Holm's step-down rule: below 5 % means "at 5 % over all of them".

    Source: Holm, A simple sequentially rejective multiple test procedure (1979).
    """
    adjusted, largest = [math.nan] * len(p_values), 0.0
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, p_values[i] * (len(p_values) - rank)))
        adjusted[i] = largest
    return adjusted


def bootstrap_ratio(
    upper: Sequence[np.ndarray],
    lower: Sequence[np.ndarray],
    seed: int,
    *,
    paired: bool = False,
    powers: tuple[Sequence[float], Sequence[float]] | None = None,
) -> Estimate:
    """Bootstrap-t interval of a ratio of products of powers of means.

    Parameters
    ----------
    upper, lower : sequence of ndarray, shape (S,)
        Observations of each factor, as squared errors and times.
    seed : int
    paired : bool
        Whether replicate i of both is drawn together.
    powers : (sequence of float, sequence of float), optional
        Of the means of each factor; 1 by default.

    Returns
    -------
    Estimate
        NaN where a resample has no positive mean.
    """
    rng = np.random.default_rng(seed)
    above, below = np.asarray(upper, np.float64), np.asarray(lower, np.float64)
    exponents = powers or (np.ones(len(above)), np.ones(len(below)))
    index = rng.integers(0, above.shape[1], (RESAMPLES, above.shape[1]))
    other = index if paired else rng.integers(0, below.shape[1], (RESAMPLES, below.shape[1]))
    with np.errstate(invalid="ignore", divide="ignore"):
        value, error = _log_product(above[:, None, :], below[:, None, :], exponents, paired)
        values, errors = _log_product(above[:, index], below[:, other], exponents, paired)
        t = (values - value) / errors
    if not (np.isfinite(t).all() and np.isfinite(value).all()):
        return Estimate(math.nan, math.nan, math.nan)
    low, high = np.quantile(t, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    centre, width = float(value[0]), float(error[0])
    return exponential(Estimate(centre, centre - high * width, centre - low * width))


def _log_product(
    above: np.ndarray,
    below: np.ndarray,
    powers: tuple[Sequence[float], Sequence[float]],
    paired: bool,
) -> tuple:
    """Log ratio of products of powers of means and its standard error by linearisation.

    Arrays have the shape (factors, resamples, S).
    """
    means_a, means_b = above.mean(axis=2), below.mean(axis=2)
    power_a, power_b = (np.asarray(one, np.float64) for one in powers)
    value = power_a @ np.log(means_a) - power_b @ np.log(means_b)
    # Influence of each replicate on the logarithm of the product.
    a = np.tensordot(power_a, above / means_a[..., None], 1)
    b = np.tensordot(power_b, below / means_b[..., None], 1)
    if paired:
        variance = (a - b).var(axis=1, ddof=1) / a.shape[1]
    else:
        variance = a.var(axis=1, ddof=1) / a.shape[1] + b.var(axis=1, ddof=1) / b.shape[1]
    return value, np.sqrt(variance)


def log_slope(x: np.ndarray, y: np.ndarray) -> Estimate:
    """Slope of log(mean y) over log(mean x) by least squares, with its jackknife interval.

    Points of one replicate belong together (each picture grew out of the one before), so a
    replicate leaves all points at once.

    Parameters
    ----------
    x, y : ndarray, shape (points, S)
        Positive means.

    Returns
    -------
    Estimate
        NaN for fewer than two points, or where a mean is not positive.
    """
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    rest_x, rest_y = leave_one_out(x), leave_one_out(y)
    if len(x) < 2 or not ((rest_x > 0.0).all() and (rest_y > 0.0).all()):
        return Estimate(math.nan, math.nan, math.nan)
    count = x.shape[1]
    value = float(fit_slope(np.log(x.mean(axis=1)), np.log(y.mean(axis=1))))
    without = fit_slope(np.log(rest_x), np.log(rest_y))
    return Statistic(value, count * value - (count - 1) * without).interval()


def fit_slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Least-squares slopes of y over x along the first axis."""
    x = x - x.mean(axis=0)
    return (x * (y - y.mean(axis=0))).sum(axis=0) / (x * x).sum(axis=0)


def _t_interval(value: float, variance: float, dof: float) -> Estimate:
    width = quantile(dof) * math.sqrt(variance)
    return Estimate(value, value - width, value + width)


def quantile(dof: float) -> float:
    """Two-sided 95 % point of Student's t; degrees of freedom to two digits."""
    return _quantile(float(f"{min(dof, 1e7):.2g}"))


@lru_cache(maxsize=4096)
def _quantile(dof: float) -> float:
    return student_t_quantile((1.0 + LEVEL) / 2.0, dof)
