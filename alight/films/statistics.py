"""Mean and standard error of a picture from its sums by replicate.

Samples of quasi-Monte-Carlo sequences are not independent, so their own spread says nothing about
the error. The R replicates are: each has its own scramble. With n_r samples of sum s_r in replicate
r, m_r = s_r / n_r, n = sum n_r and m = sum s_r / n::

    SE^2 = sum_r n_r^2 (m_r - m)^2 / (n^2 - sum_r n_r^2)

which for equal n_r is the variance of the R means divided by R (Owen 2013, "Monte Carlo theory,
methods and examples", section 17.5). For unequal ones it is unbiased if samples are independent,
as n_r^2 (m_r - m)^2 then has the mean v (n_r - n_r^2 / n); where the variance of a replicate falls
faster than 1 / n_r, it is too large. One pixel's error has R - 1 degrees of freedom; it is
*unknown* (NaN) while a replicate is empty, and never 0 for lack of data.
"""

from __future__ import annotations

import numpy as np

from alight.films.fixed_point import MAX_SAMPLES, carry, to_float, total


def pixel_mean(sums: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Mean over all samples; 0 in pixels that have none.

    Parameters
    ----------
    sums : ndarray of int64, shape (h, w, R, C, 2)
        Canonical fixed point.
    counts : ndarray of int64, shape (h, w, R)

    Returns
    -------
    ndarray of float64, shape (h, w, C)
        Within 3 units in the last place.
    """
    n = counts.sum(axis=2)[..., None]
    if n.max(initial=0) > MAX_SAMPLES:
        return total(sums, axis=2) / np.maximum(n, 1)
    # So few samples cannot overflow an int64 even together; the value is the same to the bit.
    together = sums.sum(axis=2)
    carry(together)
    return to_float(together) / np.maximum(n, 1)


def replicate_means(sums: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Mean of each replicate; 0 in those that are empty.

    Parameters
    ----------
    sums : ndarray of int64, shape (h, w, R, C, 2)
        Canonical fixed point.
    counts : ndarray of int64, shape (h, w, R)

    Returns
    -------
    ndarray of float64, shape (h, w, R, C)
    """
    return to_float(sums) / np.maximum(counts, 1)[..., None]


def mean_and_error(sums: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean of every pixel and its standard error, NaN where that is unknown.

    Parameters
    ----------
    sums : ndarray of int64, shape (h, w, R, C, 2)
        Canonical fixed point.
    counts : ndarray of int64, shape (h, w, R)

    Returns
    -------
    mean, standard_error : ndarray of float64, shape (h, w, C)
        The mean as `pixel_mean` up to the last bits.
    """
    replicates = counts.shape[2]
    # A loop over the few replicates: planes of one replicate stay in the processor's cache.
    values = [to_float(sums[:, :, r]) for r in range(replicates)]
    n = np.maximum(counts.sum(axis=2), 1)[..., None]
    mean = sum(values[1:], values[0]) / n
    if replicates < 2:
        return mean, np.full_like(mean, np.nan)
    squares, own = np.zeros_like(mean), np.zeros(n.shape)
    for r, value in enumerate(values):
        # n_r (m_r - m) = s_r - n_r m
        count = counts[:, :, r, None].astype(np.float64)
        squares += (value - count * mean) ** 2
        own += count * count
    whole = n.astype(np.float64) ** 2
    error = np.sqrt(squares * (whole / np.maximum(whole - own, 1.0))) / n
    known = counts.min(axis=2) > 0
    return mean, np.where(known[..., None], error, np.nan)
