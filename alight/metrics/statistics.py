"""The few distributions and tests that judge pictures, without SciPy.

Student's t by the regularised incomplete beta function (NIST Digital Library of Mathematical
Functions, 8.17.22: continued fraction, evaluated by Lentz's method); relative error of the tail
below 1e-9 for 1 to 10^5 degrees of freedom (2e-8 at 10^6) and tails above 1e-250. Normal quantiles
are the standard library's (Wichura 1988, AS 241; relative error 1e-15).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

_NORMAL = NormalDist()

#: Smallest tail that is resolved: |z| stops at 37.
_SMALLEST_TAIL = 1e-300


def incomplete_beta(a: np.ndarray, b: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Regularised incomplete beta function I_x(a, b), elementwise.

    Parameters
    ----------
    a, b : ndarray of float
        > 0.
    x, y : ndarray of float
        x in [0, 1] and y = 1 - x: given apart so that neither end loses digits.
    """
    a, b, x, y = np.broadcast_arrays(*(np.asarray(v, np.float64) for v in (a, b, x, y)))
    # The fraction converges fast left of the mean of the distribution; right of it, mirror.
    mirrored = x > (a + 1.0) / (a + b + 2.0)
    p, q = np.where(mirrored, b, a), np.where(mirrored, a, b)
    u, v = np.where(mirrored, y, x), np.where(mirrored, x, y)
    log_gamma = np.vectorize(math.lgamma, otypes=[np.float64])
    with np.errstate(divide="ignore"):
        log_front = log_gamma(p + q) - log_gamma(p) - log_gamma(q) + p * np.log(u) + q * np.log(v)
    value = np.exp(log_front) * _beta_fraction(p, q, u) / p
    return np.where(mirrored, 1.0 - value, value)


def _beta_fraction(a: np.ndarray, b: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Evaluate the continued fraction 8.17.22 by Lentz's method; needs O(sqrt(max(a, b))) terms."""
    tiny = 1e-300
    terms = 200 + int(5.0 * math.sqrt(float(np.maximum(a, b).max(initial=1.0))))
    d = 1.0 / _not_zero(1.0 - (a + b) * x / (a + 1.0), tiny)
    c = np.ones_like(d)
    value = d.copy()
    for m in range(1, terms):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        for coefficient in (even, odd):
            d = 1.0 / _not_zero(1.0 + coefficient * d, tiny)
            c = _not_zero(1.0 + coefficient / c, tiny)
            value = value * c * d
        if np.all(np.abs(c * d - 1.0) < 1e-15):
            break
    return value


def _not_zero(x: np.ndarray, tiny: float) -> np.ndarray:
    return np.where(np.abs(x) < tiny, tiny, x)


def student_t_tail(t: np.ndarray | float, dof: np.ndarray | float) -> np.ndarray:
    """P(|T| > |t|) of Student's distribution (both tails), elementwise; infinite `dof` is normal.

    Parameters
    ----------
    t : ndarray of float
    dof : ndarray of float
        Degrees of freedom, > 0.
    """
    t, dof = np.broadcast_arrays(np.asarray(t, np.float64), np.asarray(dof, np.float64))
    # Above 10^7 the two distributions agree to 1e-6 of the tail, and the fraction grows long.
    normal = dof > 1e7
    nu, square = np.where(normal, 1.0, dof), np.where(np.isinf(t), 1e300, np.minimum(t * t, 1e300))
    tail = incomplete_beta(nu / 2.0, np.float64(0.5), nu / (nu + square), square / (nu + square))
    gauss = np.vectorize(lambda v: math.erfc(abs(v) / math.sqrt(2.0)), otypes=[np.float64])
    return np.where(normal, gauss(t), tail)


def student_t_quantile(p: float, dof: float) -> float:
    """Find the t with P(T <= t) = p, to the last bits.

    By Newton's method in the logarithms of t and of the tail, between which the tail's curve is
    straight far out; where a step leaves the bracket, it is halved.

    Raises
    ------
    ValueError
        If p does not lie in (0, 1) or `dof` is not positive.
    """
    if not (0.0 < p < 1.0 and dof > 0.0):
        raise ValueError(f"p must lie in (0, 1) and dof be > 0, got {p} and {dof}")
    tail = 2.0 * min(p, 1.0 - p)
    if tail == 1.0:
        return 0.0
    t, low, high = max(abs(_NORMAL.inv_cdf(0.5 * tail)), 1e-300), 0.0, 1e150
    front = math.lgamma(0.5 * dof + 0.5) - math.lgamma(0.5 * dof) - 0.5 * math.log(dof * math.pi)
    for _ in range(600):
        found = float(student_t_tail(t, dof))
        low, high = (t, high) if found > tail else (low, t)
        density = math.exp(front - 0.5 * (dof + 1.0) * math.log1p(t * (t / dof)))
        slope = 2.0 * t * density / found if found > 0.0 else 0.0
        step = math.log(found / tail) / slope if slope > 0.0 else math.inf
        following = t * math.exp(step) if abs(step) < 300.0 else 0.0
        if not low < following < high:
            if abs(step) < 1e-12:  # The tail is rounded: there is nothing left to halve.
                return math.copysign(t, p - 0.5)
            following = math.sqrt(low * high) if low > 0.0 else 0.5 * high
        if abs(following - t) <= 4e-16 * t:
            return math.copysign(following, p - 0.5)
        t = following
    return math.copysign(t, p - 0.5)


def f_quantile(p: float, dof1: float, dof2: float) -> float:
    """Find the x with P(F <= x) = p of Fisher's distribution F(dof1, dof2).

    By bisection; above 50 degrees of freedom by Paulson's approximation (Paulson 1942, "An
    approximate normalization of the analysis of variance distribution"): F^(1/3) is nearly a ratio
    of normal numbers. Relative error below 2e-3 there for tails above 1e-3.

    Raises
    ------
    ValueError
        If p does not lie in (0, 1) or a number of degrees of freedom is not positive.
    """
    if not (0.0 < p < 1.0 and dof1 > 0.0 and dof2 > 0.0):
        raise ValueError(f"p must lie in (0, 1) and dof be > 0, got {p}, {dof1} and {dof2}")
    if min(dof1, dof2) > 50.0:
        z, a, b = _NORMAL.inv_cdf(p), 2.0 / (9.0 * dof1), 2.0 / (9.0 * dof2)
        u, v = 1.0 - a, 1.0 - b
        root = math.sqrt(v * v * a + u * u * b - z * z * a * b)
        return ((u * v + z * root) / (v * v - z * z * b)) ** 3
    low, high = -700.0, 700.0
    while high - low > 1e-12 * max(1.0, abs(low)):
        middle = 0.5 * (low + high)
        ratio = dof1 / dof2 * math.exp(middle)
        x, y = np.float64(ratio / (1.0 + ratio)), np.float64(1.0 / (1.0 + ratio))
        below = incomplete_beta(np.float64(dof1 / 2.0), np.float64(dof2 / 2.0), x, y)
        low, high = (middle, high) if float(below) < p else (low, middle)
    return math.exp(0.5 * (low + high))


def upper_gamma(a: float, x: float) -> float:
    """Regularised upper incomplete gamma function Q(a, x); relative error below 1e-10.

    Source: NIST Digital Library of Mathematical Functions, 8.11.4 (series, left of the mean) and
    8.9.2 (continued fraction by Lentz's method, right of it).
    """
    if x <= 0.0:
        return 1.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1.0:
        term = total = 1.0 / a
        n = a
        while abs(term) > 1e-16 * abs(total):
            n += 1.0
            term *= x / n
            total += term
        return max(0.0, 1.0 - front * total)
    b = x + 1.0 - a
    c, d = 1e300, 1.0 / b
    value = d
    for i in range(1, 100_000):
        step = -i * (i - a)
        b += 2.0
        d = 1.0 / (step * d + b)
        c = b + step / c
        value *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return front * value


def chi_square_tail(statistic: float, dof: float) -> float:
    """P(X >= statistic) of the chi-square distribution."""
    return upper_gamma(0.5 * dof, 0.5 * statistic)


def sum_of_squares_tails(z: np.ndarray) -> tuple[float, float]:
    """P(X <= x) and P(X >= x) of the sum x of squares of n independent z of mean 0 and variance 1.

    By a gamma distribution with the mean n and the larger variance of chi-square's, 2 n, and of
    that which the squares show: rare large z, and z of few degrees of freedom, spread more.

    Parameters
    ----------
    z : ndarray of float, shape (n,)
        n >= 1.
    """
    squares = np.asarray(z, np.float64) ** 2
    seen = float(squares.var(ddof=1)) if len(squares) > 1 else 0.0
    scale = max(seen, 2.0) / 2.0
    above = chi_square_tail(float(squares.sum()) / scale, len(squares) / scale)
    return 1.0 - above, above


def normal_from_tail(tail: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Find the z of a two-sided tail probability and a sign."""
    half = np.clip(np.asarray(tail, np.float64), _SMALLEST_TAIL, 1.0) / 2.0
    size = np.vectorize(lambda p: -_NORMAL.inv_cdf(p), otypes=[np.float64])(half)
    return np.copysign(size, sign)


def t_to_z(t: np.ndarray, dof: np.ndarray) -> np.ndarray:
    """Find the z with the same tail as t: standard normal if t is Student's."""
    return normal_from_tail(student_t_tail(t, dof), t)


def welch(
    mean_a: np.ndarray,
    variance_a: np.ndarray,
    n_a: float,
    mean_b: np.ndarray,
    variance_b: np.ndarray,
    n_b: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Welch's t of two means and its degrees of freedom by Satterthwaite.

    Parameters
    ----------
    mean_a, mean_b : ndarray
    variance_a, variance_b : ndarray
        Unbiased variance of one observation.
    n_a, n_b : float
        Observations, at least 2; infinity for an exact value.

    Returns
    -------
    t, dof : ndarray
        Where neither side varies: t = 0 or an infinity, and dof = infinity.
    """
    a, b = np.asarray(variance_a) / n_a, np.asarray(variance_b) / n_b
    difference = np.asarray(mean_a, np.float64) - np.asarray(mean_b, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = difference / np.sqrt(a + b)
        # Shares, not squares of variances: those underflow for dark pixels.
        share = a / (a + b)
        dof = 1.0 / (share**2 / (n_a - 1.0) + (1.0 - share) ** 2 / (n_b - 1.0))
    still = (a + b) == 0.0
    t = np.where(still, np.where(difference == 0.0, 0.0, np.copysign(np.inf, difference)), t)
    return t, np.where(still, np.inf, dof)


def holm(p_values: Sequence[float], level: float) -> list[bool]:
    """Which hypotheses Holm's step-down test rejects at a family-wise level (Holm 1979)."""
    # NaN is rejected, never passed over.
    p_values = [0.0 if math.isnan(p) else p for p in p_values]
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    rejected = [False] * len(p_values)
    for rank, i in enumerate(order):
        if p_values[i] > level / (len(p_values) - rank):
            break
        rejected[i] = True
    return rejected
