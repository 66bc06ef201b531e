r"""A picture's own error, from its replicates and without a reference, with an interval.

Let z_r be the errors of a pixel's R replicate means, independent and alike, e their mean (the error
that the picture has) and SE^2 the usual estimate of its square. Then exactly

.. math:: e^2 = SE^2 + \frac{1}{R (R - 1)} \sum_{i \ne j} z_i z_j

What the estimate lacks is a sum of products of *independent* errors: mean zero, and variance
2 R / (R - 1) SE^4 whatever the distribution; the kurtosis of heavy tails cancels. SE^4 is estimated
without bias by a product of two halves of the replicates. `docs/known-error.md` has the proof, what
is done about the brightness in the denominator, and how often the interval was right.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alight.metrics.relmse import LITERATURE_EPSILON, Estimate
from alight.metrics.statistics import f_quantile

#: Half the picture's relative variance at which a pixel's own brightness counts half: noise of the
#: 3x3 pixels around it, and of the pixel itself.
_STEADY_AROUND, _STEADY_OWN = 0.4, 1.4

#: What the noise of the brightness leaves: standard deviation of log(relMSE), per relRMSE.
_BRIGHTNESS_DOUBT, _MOST_DOUBT = 0.25, 0.5

#: Rows that are worked on at a time, to bound the memory that this takes: whole cells.
_BAND = 64

#: Above so many pixels one way to halve the replicates is enough.
_LARGE = 2**16

#: Side of the cells over which the spread is also pooled.
_CELL = 8


class Figure(NamedTuple):
    """An estimated relMSE and how sure it is.

    Attributes
    ----------
    value : float
    freedom : float
        The true relMSE over `value` has the distribution F(freedom, (R - 1) freedom).
    replicates : int
    """

    value: float
    freedom: float
    replicates: int

    def quantile(self, p: float) -> float:
        """Find the relMSE below which the true one lies with probability p."""
        if math.isnan(self.value) or self.value == 0.0:
            return self.value
        return self.value * f_quantile(p, self.freedom, (self.replicates - 1) * self.freedom)

    def interval(self, confidence: float = 0.95) -> Estimate:
        """Give the value with its two-sided interval."""
        tail = 0.5 * (1.0 - confidence)
        return Estimate(self.value, self.quantile(tail), self.quantile(1.0 - tail))


@dataclass(frozen=True)
class ErrorEstimate:
    """A picture's own error, estimated without a reference.

    Attributes
    ----------
    figure, figure_literature : Figure
        relMSE with the exposure-free `epsilon`, and with epsilon = 0.01.
    epsilon : float
        (0.1 times the mean of the picture) squared.
    known : float
        Share of the pixels whose standard error is known; the others are left out.
    """

    figure: Figure
    figure_literature: Figure
    epsilon: float
    known: float

    @property
    def relmse(self) -> Estimate:
        """With the exposure-free `epsilon`, and its 95 % interval."""
        return self.figure.interval()

    @property
    def relmse_literature(self) -> Estimate:
        """With epsilon = 0.01, and its 95 % interval."""
        return self.figure_literature.interval()

    @property
    def relrmse(self) -> Estimate:
        """Square root of `relmse`."""
        return Estimate(*(math.sqrt(v) for v in self.relmse))

    def relrmse_below(self, confidence: float) -> float:
        """Find the relRMSE that the true one does not exceed, with this confidence."""
        return math.sqrt(self.figure.quantile(confidence))


def estimate_relmse(means: np.ndarray, counts: np.ndarray) -> ErrorEstimate:
    """Estimate a picture's own relMSE from its replicates.

    Parameters
    ----------
    means : ndarray of float32, shape (h, w, R, 3)
        Of the samples of each replicate.
    counts : ndarray of int, shape (h, w, R)
        Pixels with an empty replicate are left out.

    Notes
    -----
    The error and the brightness that it is divided by come from different replicates: one bright
    sample would else excuse its own error. Where a pixel is mostly noise, the mean of 3x3 pixels
    takes its place; what the noise of a brightness b does to 1 / (b^2 + epsilon) is divided out to
    second order. With fewer than 4 replicates they have to be the same, and the estimate is less
    sure than it says. Light that no sample has found yet is in no estimate.
    """
    replicates = counts.shape[2]
    n = counts.sum(axis=2)
    known = counts.min(axis=2) > 0 if replicates > 1 else np.zeros(n.shape, bool)
    mean = _mean_of(means, counts)
    epsilons = (0.01 * mean * mean, LITERATURE_EPSILON)
    if not known.any() or not epsilons[0] > 0.0:
        unknown = Figure(math.nan, math.nan, replicates)
        return ErrorEstimate(unknown, unknown, epsilons[0], float(known.mean()))
    totals, halvings = np.zeros((2, 3)), list(_halvings(replicates))
    if known.size > _LARGE:
        del halvings[1:]
    for y in range(0, len(n), _BAND):
        low = max(y - 1, 0)
        rows = slice(low, y + _BAND + 1)
        inside = slice(y - low, y - low + _BAND)
        totals += _totals_of(means[rows], counts[rows], known[rows], inside, epsilons, halvings)
    pixels = int(known.sum())
    figures = [_figure(row[0], row[1], row[2], pixels, replicates) for row in totals]
    return ErrorEstimate(figures[0], figures[1], epsilons[0], float(known.mean()))


def _mean_of(means: np.ndarray, counts: np.ndarray) -> float:
    """Mean of the picture, black where it is negative."""
    total = 0.0
    for y in range(0, len(means), _BAND):
        weights = counts[y : y + _BAND, :, :, None]
        picture = (means[y : y + _BAND] * weights).sum(axis=2) / np.maximum(weights.sum(axis=2), 1)
        total += float(np.maximum(picture, 0.0).sum(dtype=np.float64))
    return total / (means.shape[0] * means.shape[1] * means.shape[3])


def _figure(value: float, own: float, pooled: float, pixels: int, replicates: int) -> Figure:
    """From the sums over pixels of relative SE^2, of relative SE^4, and of that by cells."""
    if value <= 0.0:
        return Figure(0.0, math.inf, replicates)
    relmse = value / pixels
    # Rare spikes seldom meet in both halves of a pixel's replicates, but do in those of a cell.
    ratio = replicates / (replicates - 1)
    variance = 2.0 * ratio * max(own, pooled) / value**2
    variance += min(_BRIGHTNESS_DOUBT * math.sqrt(relmse), _MOST_DOUBT) ** 2
    return Figure(relmse, 2.0 * ratio / variance, replicates)


def _totals_of(
    means: np.ndarray,
    counts: np.ndarray,
    known: np.ndarray,
    inside: slice,
    epsilons: tuple[float, float],
    halvings: list[tuple[list[int], list[int]]],
) -> np.ndarray:
    """Sums over the known pixels of some rows, for each epsilon: see `_figure`."""
    weights = counts.astype(np.float32)[..., None]
    n = np.maximum(weights.sum(axis=2), 1.0)
    mean = (means * weights).sum(axis=2) / n
    replicates = means.shape[2]
    squares = (weights * (means - mean[:, :, None]) ** 2).sum(axis=2) / (replicates - 1) / n
    smoothing = _smoothing(mean, squares, np.float32(epsilons[0]))
    totals = np.zeros((2, 3))
    # For the spread, the steadiest brightness: one of halves would hide large products.
    steady = (mean + smoothing * (_box(mean) - mean))[inside]
    for first, second in halvings:
        halves = [_deviations(means, weights, n, half)[inside] for half in (first, second)]
        # Each half's error is divided by the brightness that the other half saw.
        seen = [_brightness(means, weights, half, smoothing) for half in (second, first)]
        for i, epsilon in enumerate(epsilons):
            scales = [_inverse_square(*light, np.float32(epsilon))[inside] for light in seen]
            common = 1.0 / (steady**2 + np.float32(epsilon))
            totals[i] += _sums_over_pixels(halves, scales, common, known[inside])
    if replicates < 4:
        # Both halves are the same: E[s^4] = sigma^4 (R + 1) / (R - 1) for normal noise.
        totals[:, 1:] *= (replicates - 1) / (replicates + 1)
    return totals / len(halvings)


def _halvings(replicates: int) -> Iterator[tuple[list[int], list[int]]]:
    """Ways to share out the replicates, each half large enough to have a spread.

    For R = 4 all three. One alone leaves out the products of its halves: the variance of the
    estimate is then 9/8 of that of all, which is not worth the time in a large picture.
    """
    everything = list(range(replicates))
    if replicates < 4:
        yield everything, everything
        return
    size = replicates // 2
    yield everything[:size], everything[size:]
    yield everything[::2], everything[1::2]
    inner = everything[size // 2 : size // 2 + size]
    yield inner, [r for r in everything if r not in inner]


def _smoothing(mean: np.ndarray, squares: np.ndarray, epsilon: np.float32) -> np.ndarray:
    """Weight of the 3x3 pixels in a pixel's brightness: towards 1 where it is mostly noise."""
    tiny = np.float32(0.01) * epsilon
    around = 2.0 * _box(squares) / (_box(mean) ** 2 + tiny) / np.float32(_STEADY_AROUND)
    own = (2.0 * squares / (mean**2 + tiny) / np.float32(_STEADY_OWN)) ** 2
    ratio = around + own
    return ratio / (1.0 + ratio)


def _deviations(
    means: np.ndarray, weights: np.ndarray, n: np.ndarray, half: list[int]
) -> np.ndarray:
    """Deviations within a half, shape (h, w, replicates, 3), whose squares add up to SE^2."""
    m, k = means[:, :, half], weights[:, :, half]
    centre = (m * k).sum(axis=2) / np.maximum(k.sum(axis=2), 1.0)
    return (m - centre[:, :, None]) * np.sqrt(k / (n[:, :, None] * np.float32(len(half) - 1)))


def _brightness(
    means: np.ndarray, weights: np.ndarray, half: list[int], smoothing: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Brightness by a half of the replicates, and its variance."""
    m, k = means[:, :, half], weights[:, :, half]
    total = np.maximum(k.sum(axis=2), 1.0)
    own = (m * k).sum(axis=2) / total
    spread = (k * (m - own[:, :, None]) ** 2).sum(axis=2) / np.float32(len(half) - 1) / total
    # One pixel of the nine is the own one.
    rest = smoothing * np.float32(1.0 / 9.0)
    variance = spread * (1.0 - smoothing) ** 2
    variance += _box(spread) * (2.0 * (1.0 - smoothing) * rest + 9.0 * rest**2)
    return own + smoothing * (_box(own) - own), variance


def _inverse_square(
    brightness: np.ndarray, variance: np.ndarray, epsilon: np.float32
) -> np.ndarray:
    """1 / (b^2 + epsilon) of the brightness behind the noise: f'' / f = 8 b^2 f^2 - 2 f."""
    f = 1.0 / (brightness**2 + epsilon)
    bias = variance * (4.0 * (brightness * f) ** 2 - f)
    return f / (1.0 + np.maximum(bias, np.float32(-0.5)))


def _sums_over_pixels(
    halves: list[np.ndarray], scales: list[np.ndarray], common: np.ndarray, known: np.ndarray
) -> np.ndarray:
    """Sums of tr(W S), of tr(W S_A W S_B), and of the latter by cells.

    W = diag(scale) / 3, with the scale for each half, and a common one for the products.
    """
    third = np.float32(1.0 / 3.0)
    own = np.sum(
        [(d**2 * f[:, :, None]).sum(axis=(2, 3)) for d, f in zip(halves, scales, strict=True)],
        axis=0,
    )
    root = np.sqrt(common * third)[:, :, None]
    a, b = (np.where(known[..., None, None], d * root, 0.0) for d in halves)
    crossed = np.einsum("yxic,yxjc->yxij", a, b) ** 2
    # Channels of a pixel share their paths, so their covariance counts; pixels are independent.
    pooled = (
        _by_cells(np.einsum("yxic,yxid->yxcd", a, a)),
        _by_cells(np.einsum("yxic,yxid->yxcd", b, b)),
    )
    pixels = _by_cells(known.astype(np.float64))
    by_cells = (pooled[0] * pooled[1]).sum(axis=(2, 3)) / np.maximum(pixels, 1.0)
    value = float(own[known].sum(dtype=np.float64)) * 0.5 * third
    return np.array([value, float(crossed.sum(dtype=np.float64)), float(by_cells.sum())])


def _by_cells(plane: np.ndarray) -> np.ndarray:
    """Add up 8x8 pixels (those of the picture's edge may be fewer), float64."""
    y, x = range(0, plane.shape[0], _CELL), range(0, plane.shape[1], _CELL)
    return np.add.reduceat(np.add.reduceat(plane, y, axis=0, dtype=np.float64), x, axis=1)


def _box(plane: np.ndarray) -> np.ndarray:
    """Average over 3x3 pixels, the border repeated."""
    h, w = plane.shape[:2]
    padded = np.pad(plane, ((1, 1), (1, 1), (0, 0)), mode="edge")
    rows = padded[:h] + padded[1 : h + 1] + padded[2:]
    return (rows[:, :w] + rows[:, 1 : w + 1] + rows[:, 2:]) / np.float32(9.0)
