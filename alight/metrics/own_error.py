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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alight.metrics.planes import (
    box,
    over_replicates,
    planes_of,
    same_everywhere,
    squares,
    weighted,
)
from alight.metrics.relmse import LITERATURE_EPSILON, Estimate
from alight.metrics.statistics import f_quantile

#: Half the picture's relative variance at which a pixel's own brightness counts half: noise of the
#: 3x3 pixels around it, and of the pixel itself.
_STEADY_AROUND, _STEADY_OWN = 0.4, 1.4

#: What the noise of the brightness adds to the deviation of log(relMSE): in proportion to what it
#: is without, per relRMSE; and, for the bias that is left, per relMSE.
_BRIGHTNESS_NOISE, _BRIGHTNESS_BIAS, _MOST_BIAS = 1.7, 0.7, 0.3

#: How soon the brightness for the spread is that of the pixels around, and no longer the own one.
_EARLY = 100.0

#: Rows that are worked on at a time: whole cells, and few enough to stay in the processor's cache.
_BAND = 32

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


def estimate_relmse(
    means: np.ndarray, counts: np.ndarray, literature: bool = True
) -> ErrorEstimate:
    """Estimate a picture's own relMSE from its replicates.

    Parameters
    ----------
    means : ndarray of float32, shape (h, w, R, 3)
        Of the samples of each replicate.
    counts : ndarray of int, shape (h, w, R)
        Pixels with an empty replicate are left out.
    literature : bool, default True
        Whether the figure for epsilon = 0.01 is wanted too; unknown otherwise.

    Notes
    -----
    The error and the brightness that it is divided by come from different replicates: one bright
    sample would else excuse its own error. Where a pixel is mostly noise, the mean of 3x3 pixels
    takes its place; what the noise of a brightness b does to 1 / (b^2 + epsilon) is divided out to
    second order. With fewer than 4 replicates they have to be the same, and the estimate is less
    sure than it says. Light that no sample has found yet is in no estimate.
    """
    size, replicates = counts.shape[:2], counts.shape[2]
    counts = same_everywhere(counts)
    known = np.zeros(size, bool)
    if replicates > 1:
        known[...] = over_replicates(counts, np.minimum) > 0
    mean = _mean_of(means, counts)
    epsilons = (0.01 * mean * mean, LITERATURE_EPSILON)
    unknown = Figure(math.nan, math.nan, replicates)
    if not known.any() or not epsilons[0] > 0.0:
        return ErrorEstimate(unknown, unknown, epsilons[0], float(known.mean()))
    wanted, halvings = epsilons[: 1 + literature], list(_halvings(replicates))
    totals = np.zeros((len(wanted), 2, 3))
    if known.size > _LARGE:
        del halvings[1:]
    for y in range(0, size[0], _BAND):
        low = max(y - 1, 0)
        rows = slice(low, y + _BAND + 1)
        inside = slice(y - low, y - low + _BAND)
        band = _Band(means[rows], counts[rows] if len(counts) > 1 else counts, known[rows], inside)
        totals += _totals_of(band, wanted, halvings)
    pixels = int(known.sum())
    figures = [*(_figure(rows, pixels, replicates) for rows in totals), unknown]
    return ErrorEstimate(figures[0], figures[1], epsilons[0], float(known.mean()))


def _mean_of(means: np.ndarray, counts: np.ndarray) -> float:
    """Mean of the picture, black where it is negative."""
    total = 0.0
    for y in range(0, len(means), _BAND):
        rows = slice(y, y + _BAND)
        picture = weighted(*planes_of(means[rows], counts[rows] if len(counts) > 1 else counts))
        total += float(np.maximum(picture, 0.0, out=picture).sum(dtype=np.float64))
    return total / (means.shape[0] * means.shape[1] * means.shape[3])


def _figure(rows: np.ndarray, pixels: int, replicates: int) -> Figure:
    """From the sums over pixels of relative SE^2, of relative SE^4, and of that by cells.

    `rows` has them for two brightnesses, shape (2, 3).
    """
    value, spread = float(rows[0, 0]), float(rows[:, 1:].max())
    if value <= 0.0:
        return Figure(0.0, math.inf, replicates)
    relmse = value / pixels
    # Rare spikes seldom meet in both halves of a pixel's replicates, but do in those of a cell.
    ratio = replicates / (replicates - 1)
    variance = 2.0 * ratio * spread / value**2
    variance *= (1.0 + _BRIGHTNESS_NOISE * math.sqrt(relmse)) ** 2
    variance += min(_BRIGHTNESS_BIAS * relmse, _MOST_BIAS) ** 2
    return Figure(relmse, 2.0 * ratio / variance, replicates)


class _Band:
    """Some rows of a picture, plane by plane, and one more row above and below.

    Attributes
    ----------
    m, k : ndarray, shapes (R, 3, h, w) and (R, 1, h, w) or (R, 1, 1, 1)
        Means and counts of the replicates.
    n : ndarray
        Sum of the counts, 1 at least.
    known : ndarray of float32, shape (rows, w)
        1 or 0, of the rows inside.
    """

    def __init__(
        self, means: np.ndarray, counts: np.ndarray, known: np.ndarray, inside: slice
    ) -> None:
        self.m, self.k = planes_of(means, counts)
        self.n = np.maximum(self.k.sum(axis=0), np.float32(1.0))
        self.known = known[inside].astype(np.float32)
        self._inside = inside

    def inside(self, planes: np.ndarray) -> np.ndarray:
        """Cut off the rows above and below."""
        return planes[..., self._inside, :] if planes.shape[-2] > 1 else planes


class _Half(NamedTuple):
    """What half of the replicates say of the rows inside, shapes (3, rows, w) and (3, 3, ...).

    `spread` is the channels' covariance of the whole picture's error; `brightness` and its
    `variance` are those of the half.
    """

    spread: list[list[np.ndarray]]
    brightness: np.ndarray
    variance: np.ndarray


def _totals_of(
    band: _Band, epsilons: tuple[float, ...], halvings: list[tuple[list[int], list[int]]]
) -> np.ndarray:
    """Sums over the known pixels of some rows: for each epsilon and two brightnesses, `_figure`'s.

    A bright sample lifts the brightness of its own pixel, and there hides a part of the spread that
    it stands for. Where a pixel is noisy, that of the eight around is not tied to it, but wrong at
    edges. `_figure` takes the larger of the spreads by both.
    """
    mean = weighted(band.m, band.k)
    replicates = len(band.m)
    variance = squares(band.m, band.k, mean)
    variance /= band.n * np.float32(replicates - 1)
    around = box(mean)
    smoothing = _smoothing(mean, around, variance, np.float32(epsilons[0]))
    # For the spread, the steadiest brightness: one of halves would hide large products.
    steady = band.inside(mean + smoothing * (around - mean))
    early = _EARLY * smoothing / (1.0 + (_EARLY - 1.0) * smoothing)
    others = band.inside(mean + early * np.float32(9.0 / 8.0) * (around - mean))
    totals = np.zeros((len(epsilons), 2, 3))
    for halving in halvings:
        halves = [_half(band, half, smoothing) for half in halving]
        for i, epsilon in enumerate(np.float32(epsilons)):
            totals[i, :, 0] += _value_over_pixels(band.known, halves, epsilon)
            for j, light in enumerate((steady, others)):
                totals[i, j, 1:] += _spread_over_pixels(band.known, halves, light, epsilon)
    if replicates < 4:
        # Both halves are the same: E[s^4] = sigma^4 (R + 1) / (R - 1) for normal noise.
        totals[:, :, 1:] *= (replicates - 1) / (replicates + 1)
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


def _smoothing(
    mean: np.ndarray, mean_around: np.ndarray, variance: np.ndarray, epsilon: np.float32
) -> np.ndarray:
    """Weight of the 3x3 pixels in a pixel's brightness: towards 1 where it is mostly noise."""
    tiny = np.float32(0.01) * epsilon
    around = box(variance)
    around /= mean_around * mean_around + tiny
    around *= np.float32(2.0 / _STEADY_AROUND)
    own = variance / (mean * mean + tiny)
    own *= np.float32(2.0 / _STEADY_OWN)
    own *= own
    own += around
    own /= 1.0 + own
    return own


def _half(band: _Band, half: list[int], smoothing: np.ndarray) -> _Half:
    """Look at some of the replicates."""
    some = slice(half[0], half[-1] + 1) if half[-1] - half[0] == len(half) - 1 else half
    m, k = band.m[some], band.k[some]
    own = weighted(m, k)
    total, freedom = np.maximum(k.sum(axis=0), np.float32(1.0)), np.float32(len(half) - 1)
    if len(half) == 2:
        # Both deviations are parts of one difference.
        deviations, weights = m[:1] - m[1:], k[:1] * k[1:] / total
    else:
        deviations, weights = m - own, k
    products = [
        [_product(deviations[:, c], deviations[:, d], weights[:, 0]) for d in range(c + 1)]
        for c in range(3)
    ]
    spread = np.stack([products[c][c] for c in range(3)])
    spread /= freedom * total
    rest = smoothing * np.float32(1.0 / 9.0)
    keep = 1.0 - smoothing
    # One pixel of the nine is the own one.
    variance = spread * keep
    variance *= keep
    rest *= 2.0 * keep + 9.0 * rest
    rest *= box(spread)
    variance += rest
    brightness = box(own)
    brightness -= own
    brightness *= smoothing
    brightness += own
    scale = 1.0 / (band.inside(band.n)[0] * freedom)
    covariance = [[band.inside(plane) * scale for plane in row] for row in products]
    return _Half(covariance, band.inside(brightness), band.inside(variance))


def _product(a: np.ndarray, b: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted sum of products over axis 0."""
    result = a[0] * b[0]
    result *= weights[0]
    for left, right, weight in zip(a[1:], b[1:], weights[1:], strict=True):
        result += left * right * weight
    return result


def _inverse_square(
    brightness: np.ndarray, variance: np.ndarray, epsilon: np.float32
) -> np.ndarray:
    """1 / (b^2 + epsilon) of the brightness behind the noise: f'' / f = 8 b^2 f^2 - 2 f."""
    square = brightness * brightness
    f = 1.0 / (square + epsilon)
    square *= np.float32(4.0) * f
    square -= 1.0
    square *= variance
    square *= f
    np.maximum(square, np.float32(-0.5), out=square)
    square += 1.0
    f /= square
    return f


def _value_over_pixels(known: np.ndarray, halves: Sequence[_Half], epsilon: np.float32) -> float:
    """Sum over the known pixels of tr(W S), W = diag(1 / (brightness^2 + epsilon)) / 3."""
    value = 0.0
    # Each half's error is divided by the brightness that the other half saw.
    for half, other in (halves, halves[::-1]):
        scale = _inverse_square(other.brightness, other.variance, epsilon)
        own = sum(half.spread[c][c] * scale[c] for c in range(3))
        value += float(np.vdot(own, known))
    return value / 6.0


def _spread_over_pixels(
    known: np.ndarray, halves: Sequence[_Half], light: np.ndarray, epsilon: np.float32
) -> tuple[float, float]:
    """Sums over the known pixels of tr(W S_A W S_B), and the same by cells; W by `light`."""
    root = np.sqrt(known * np.float32(1.0 / 3.0) / (light * light + epsilon))
    # A product with ones adds up rows faster than a sum over an axis does.
    heights = np.arange(known.shape[0]) // _CELL
    rows = (heights == np.arange(heights[-1] + 1)[:, None]).astype(np.float32)
    crossed = pooled = 0.0
    # Channels of a pixel share their paths, so their covariance counts; pixels are independent.
    for c in range(3):
        for d in range(c + 1):
            twice, scale = (1.0 if c == d else 2.0), root[c] * root[d]
            a, b = (half.spread[c][d] * scale for half in halves)
            crossed += twice * float(np.vdot(a, b))
            pooled += twice * (_by_cells(rows, a) * _by_cells(rows, b))
    pixels = _by_cells(rows, known)
    return crossed, float((pooled / np.maximum(pixels, 1.0)).sum())


def _by_cells(rows: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Add up 8x8 pixels (those of the picture's edge may be fewer)."""
    return np.add.reduceat(rows @ plane, range(0, plane.shape[1], _CELL), axis=1)
