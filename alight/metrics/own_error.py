r"""A picture's own error, from its replicates and without a reference, with an interval.

Let z_r be the errors of a pixel's R replicate means, independent and alike, e their mean (the error
that the picture has) and SE^2 the usual estimate of its square. Then exactly

.. math:: e^2 = SE^2 + \frac{1}{R (R - 1)} \sum_{i \ne j} z_i z_j

What the estimate lacks is a sum of products of *independent* errors: mean zero, and variance
2 R / (R - 1) SE^4 whatever the distribution; the kurtosis of heavy tails cancels. SE^4 is estimated
without bias by a product of two halves of the replicates.

relMSE divides by the brightness squared, and that is the harder part: one bright sample would
excuse its own error. So one half of the replicates tells the error and the other the brightness;
pixels that are mostly noise are judged together (`noisy_pixels`). `docs/known-error.md` has the
proof and how often the interval was right.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from alight.metrics import noisy_pixels
from alight.metrics.epsilon import LITERATURE_EPSILON
from alight.metrics.error_estimate import LEAST_FOR_INTERVAL, ErrorEstimate, Figure
from alight.metrics.few_pixels import FewPixels
from alight.metrics.large_pictures import ROWS, Loops
from alight.metrics.planes import weighted
from alight.metrics.shared_paths import SharedPaths
from alight.metrics.surroundings import CELL, by_cells, spread_out
from alight.metrics.survey import Survey, survey
from alight.metrics.unmet_light import unmet_light
from lanewise.simd import WIDEST

#: Normal quantile of the confidence that `unmet_light` has, 97.5 %.
_Z = 1.96

#: Least relMSE whose parts can be squared: the literature's is smaller in very dark pictures.
_FAINTEST = 1e-15

#: Above this number of pixels, one way to halve the replicates is enough, and machine code is worth
#: loading.
_LARGE = 2**16


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
    With fewer than 4 replicates the error and the brightness have to come from the same ones:
    bright samples excuse themselves, the estimate is too low, and there is no interval. Light that
    no sample has found yet is in no estimate.
    """
    return relmse_of(survey(means, counts), literature)


def relmse_of(seen: Survey, literature: bool = True) -> ErrorEstimate:
    """Estimate as `estimate_relmse`, from what has been seen of a picture."""
    known = float(seen.known.mean())
    figure = other = Figure(math.nan, math.nan, seen.replicates)
    if known > 0.0 and seen.epsilon > 0.0:
        figure = _figure(seen, seen.epsilon)
        other = _figure(seen, LITERATURE_EPSILON) if literature else other
    return ErrorEstimate(figure, other, seen.epsilon, known, shares_paths=seen.shares_paths)


def _figure(seen: Survey, epsilon: float) -> Figure:
    """Estimate relMSE with this epsilon."""
    replicates, large = seen.replicates, seen.known.size > _LARGE
    halvings = list(_halvings(replicates))
    if large:
        del halvings[1:]
    by_machine = large and replicates >= LEAST_FOR_INTERVAL and not seen.shares_paths
    by_machine = by_machine and seen.known.shape[1] >= WIDEST
    sums = Loops(seen, epsilon) if by_machine else _Sums(seen, epsilon, halvings)
    classes, precise, logs, pixels = sums.learn()
    size = len(halvings[0][0])
    # One pixel whose weight the surroundings miss by a factor of e stands for what is not known.
    unlike = max((1.0 + logs) / (1.0 + pixels), 0.0)
    believed = noisy_pixels.believe(classes, 3 * len(halvings), size, size, replicates, unlike)
    # Both halves of each way are estimates of the same.
    value = (precise + believed.value) / (2 * len(halvings))
    relmse = value / (3.0 * float(seen.known.sum()))
    if value <= 0.0:
        return Figure(0.0, math.inf, replicates)
    if replicates < LEAST_FOR_INTERVAL:
        return Figure(relmse, math.nan, replicates)
    few = FewPixels(replicates, size)
    spread = sums.multiply(believed.weights, few)
    spread = few.at_least(spread, value)
    total = precise + believed.value
    share, lowest = (believed.value / total) ** 2, (precise + believed.lowest) / total
    # Smaller squared errors have products that are no float32: then one pixel may carry them all.
    freedom = few.freedom(value, spread) if relmse > _FAINTEST else 1.0
    unmet = math.log1p(unmet_light(seen, epsilon) / relmse) / _Z
    return Figure(
        relmse,
        freedom,
        replicates,
        believed.variance * share,
        lowest,
        believed.rise * share + unmet * unmet,
    )


class _Sums:
    """Both passes over a picture: what noisy pixels say together, and products of errors."""

    def __init__(self, seen: Survey, epsilon: float, halvings: list[tuple[list[int], list[int]]]):
        self._seen, self._epsilon, self._halvings = seen, np.float32(epsilon), halvings
        self._weights: list[tuple[_Weights, _Weights]] = []

    def learn(self) -> tuple[np.ndarray, float, float, int]:
        """Add up noisy pixels by class, the others' error, their unlikeness and its number."""
        seen, known = self._seen, self._seen.known
        sums, groups = noisy_pixels.no_sums(), _groups(*known.shape)
        precise, unlike, pixels = 0.0, 0.0, 0
        for rows, m, k in seen.bands():
            q2 = seen.surroundings[:, rows] ** 2
            q2 += self._epsilon
            here = _Band(known[rows], q2, groups[rows], self._epsilon)
            for i, (a, b) in enumerate(_halves(m, k, self._halvings)):
                self._weights.append((_weigh(here, a, b, sums), _weigh(here, b, a, sums)))
                precise += sum(weight.value for weight in self._weights[-1])
                if i == 0:
                    found = _unlike(here, a, b, 1 if known.size <= _LARGE else ROWS)
                    unlike, pixels = unlike + found[0], pixels + found[1]
        return sums, precise, unlike, pixels

    def multiply(self, weights: np.ndarray, few: FewPixels) -> float:
        """Find the sum of sigma^4 by products of halves, given the weights of classes."""
        seen, known, spread, kept = self._seen, self._seen.known, 0.0, iter(self._weights)
        ways = len(self._halvings)
        shared = SharedPaths(seen.replicates) if seen.shares_paths else None
        for rows, m, k in seen.bands():
            # Worked out twice: kept, the halves of a large picture would take as much memory as
            # a film.
            both = np.zeros((3, 3, *known[rows].shape), np.float32)
            for a, b in _halves(m, k, self._halvings):
                weigh_a, weigh_b = next(kept)
                by_a, by_b = weigh_a.full(weights), weigh_b.full(weights)
                quiet_a = _quietly(by_a, weigh_a.classes, b, self._epsilon)
                quiet_b = _quietly(by_b, weigh_b.classes, a, self._epsilon)
                spread += _spread(known[rows], a, b, quiet_a, quiet_b, both)
                if shared:
                    shared.add(m, np.sqrt(by_a * by_b) * known[rows])
            few.add(both / np.float32(2 * ways))
        spread /= ways
        return max(spread, shared.spread / ways**2) if shared else spread


def _groups(height: int, width: int) -> np.ndarray:
    """Share out cells evenly over the groups of `noisy_pixels`; for each pixel its group."""
    y, x = np.mgrid[0 : -(-height // CELL), 0 : -(-width // CELL)]
    return spread_out((5 * y + x) % noisy_pixels.GROUPS, height, width)


class _Band(NamedTuple):
    """Some rows: known pixels, squared brightness around them with epsilon, groups, epsilon."""

    known: np.ndarray
    q2: np.ndarray
    groups: np.ndarray
    epsilon: np.float32


class _Half(NamedTuple):
    """What half of the replicates say of some rows, shapes (3, rows, w) and a list of planes.

    `error` is the variance of the whole picture's error, and `shared` the covariances of its
    channels 1 and 0, 2 and 0, 2 and 1; `brightness` and its `variance` are those of the half.
    """

    error: np.ndarray
    shared: list[np.ndarray]
    brightness: np.ndarray
    variance: np.ndarray

    def spread(self, c: int, d: int) -> np.ndarray:
        """Covariance of the whole picture's error in two channels, d <= c."""
        return self.error[c] if c == d else self.shared[c + d - 1]


class _Weights(NamedTuple):
    """What one half's squared error is multiplied by, shape (3, rows, w).

    Attributes
    ----------
    value : float
        Sum over the pixels that know their own brightness.
    plain : ndarray
        Their weight; elsewhere 1 / q^2.
    classes : ndarray of int
        Of the others; `noisy_pixels.CLASSES` for these.
    """

    value: float
    plain: np.ndarray
    classes: np.ndarray

    def full(self, weights: np.ndarray) -> np.ndarray:
        """The weight everywhere, given those of the classes."""
        factors = np.append(weights, 1.0).astype(np.float32)
        return factors.take(self.classes) * self.plain


def _weigh(here: _Band, a: _Half, b: _Half, sums: np.ndarray) -> _Weights:
    """Sort pixels by what half A says; those that are mostly noise are added to `sums`."""
    own = a.brightness * a.brightness
    own += here.epsilon
    brightness = np.maximum(b.brightness, np.float32(noisy_pixels.GUARD) * a.brightness)
    plain = _inverse_square(brightness, b.variance, here.epsilon)
    precise = a.error < np.float32(noisy_pixels.PRECISE) * np.maximum(own, here.q2)
    noisy: np.ndarray = np.flatnonzero(~precise)
    precise &= here.known
    value = float(np.vdot(a.error * plain, precise.astype(np.float32)))
    s, own, q2 = (plane.ravel().take(noisy) for plane in (a.error, own, here.q2))
    some = noisy_pixels.class_of(own, q2, s)
    inverse = 1.0 / q2
    classes = np.full(precise.shape, noisy_pixels.CLASSES, np.uint8)
    classes.ravel()[noisy] = some
    plain.ravel()[noisy] = inverse
    if not here.known.all():
        seen = np.broadcast_to(here.known, precise.shape).ravel().take(noisy)
        noisy, some, inverse, s, own = (each[seen] for each in (noisy, some, inverse, s, own))
    bright, noise = b.brightness.ravel().take(noisy), b.variance.ravel().take(noisy)
    noisy_pixels.gather(
        sums,
        some,
        here.groups.ravel().take(noisy % here.groups.size),
        s * inverse,
        bright * np.sqrt(inverse),
        (bright * bright - noise) * inverse,
        here.epsilon * inverse,
        own * inverse,
        noise * inverse,
    )
    return _Weights(value, plain, classes)


def _unlike(here: _Band, a: _Half, b: _Half, step: int) -> tuple[float, int]:
    """How unlike their surroundings precise pixels are: sum of log(weight * q^2)^2, and number.

    By two halves, one factor each: their noise is independent, and its square is in no product.
    Of `step` rows one is looked at.
    """
    q2, both, logs = here.q2[:, ::step], here.known[::step], []
    for half in (a, b):
        own = half.brightness[:, ::step] ** 2
        own += here.epsilon
        both = both & (
            half.error[:, ::step] < np.float32(noisy_pixels.PRECISE) * np.maximum(own, q2)
        )
        own /= q2
        logs.append(np.log(own, out=own))
    return float((logs[0] * logs[1]).sum(where=both)), int(both.sum())


def _halvings(replicates: int) -> Iterator[tuple[list[int], list[int]]]:
    """Ways to share out the replicates, each half large enough to have a spread.

    For R = 4 all three. One alone leaves out the products of its halves: the variance of the
    estimate is then 9/8 of that of all, which is not worth the time in a large picture.
    """
    everything = list(range(replicates))
    if replicates < LEAST_FOR_INTERVAL:
        yield everything, everything
        return
    size = replicates // 2
    yield everything[:size], everything[size:]
    yield everything[::2], everything[1::2]
    inner = everything[size // 2 : size // 2 + size]
    yield inner, [r for r in everything if r not in inner]


def _halves(
    m: np.ndarray, k: np.ndarray, halvings: list[tuple[list[int], list[int]]]
) -> Iterator[tuple[_Half, _Half]]:
    """Look at both halves of the replicates, for each way to share them out."""
    for first, second in halvings:
        yield _half(m, k, first), _half(m, k, second)


def _half(m: np.ndarray, k: np.ndarray, half: list[int]) -> _Half:
    """Look at some of the replicates."""
    n = np.maximum(k.sum(axis=0), np.float32(1.0))
    some = slice(half[0], half[-1] + 1) if half[-1] - half[0] == len(half) - 1 else half
    m, k = m[some], k[some]
    brightness = weighted(m, k)
    total, freedom = np.maximum(k.sum(axis=0), np.float32(1.0)), np.float32(len(half) - 1)
    if len(half) == 2:
        # Both deviations are parts of one difference.
        deviations, weights = m[:1] - m[1:], k[:1] * k[1:] / total
    else:
        deviations, weights = m - brightness, k
    scale = 1.0 / (n * freedom)
    weights = weights * scale
    error = np.empty_like(brightness)
    for c in range(3):
        _product(deviations[:, c], deviations[:, c], weights[:, 0], error[c])
    shared = [
        _product(deviations[:, c], deviations[:, d], weights[:, 0], np.empty_like(error[0]))
        for c, d in ((1, 0), (2, 0), (2, 1))
    ]
    return _Half(error, shared, brightness, error * (n / total))


def _product(a: np.ndarray, b: np.ndarray, weights: np.ndarray, result: np.ndarray) -> np.ndarray:
    """Weighted sum of products over axis 0."""
    np.multiply(a[0], b[0], out=result)
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


def _quietly(weights: np.ndarray, classes: np.ndarray, b: _Half, epsilon: np.float32) -> np.ndarray:
    """Weights for products of both halves' errors, where `b` gave the brightness itself.

    In these products B's error counts too, and a bright sample that makes it large makes B's
    brightness large, and so excuses itself. Without the error that brightness excuses nothing, but
    is too dark. The truth lies between: the geometric mean of both weights. Where B's error is
    small beside B's own brightness there is next to nothing to excuse.
    """
    own = b.brightness * b.brightness
    own += epsilon
    unsure = b.error >= np.float32(noisy_pixels.PRECISE) * own
    unsure &= classes == noisy_pixels.CLASSES
    some: np.ndarray = np.flatnonzero(unsure)
    if not some.size:
        return weights
    brightness, variance, as_is = (
        x.ravel().take(some) for x in (b.brightness, b.variance, weights)
    )
    quiet = np.maximum(brightness - np.sqrt(variance), 0.0)
    weights = weights.copy()
    # Roots first: of dark pictures the product would be infinite.
    mean = np.sqrt(as_is) / np.sqrt(quiet * quiet + epsilon)
    weights.ravel()[some] = np.maximum(mean, as_is)
    return weights


def _spread(
    known: np.ndarray,
    a: _Half,
    b: _Half,
    weights_a: np.ndarray,
    weights_b: np.ndarray,
    both: np.ndarray,
) -> float:
    """Sum over the known pixels of tr(W S_A W S_B), or the same pooled by cells where that is more.

    Rare spikes seldom meet in both halves of a pixel's replicates, but do in those of a cell. The
    matrices W (S_A + S_B) are added to `both`, shape (3, 3, rows, w), on and below the diagonal.
    """
    root = np.sqrt(np.sqrt(weights_a) * np.sqrt(weights_b) * known)
    crossed = pooled = 0.0
    # Channels of a pixel share their paths, so their covariance counts; pixels are independent.
    for c in range(3):
        for d in range(c + 1):
            twice, scale = (1.0 if c == d else 2.0), root[c] * root[d]
            left, right = a.spread(c, d) * scale, b.spread(c, d) * scale
            crossed += twice * float(np.vdot(left, right))
            pooled += twice * (by_cells(left) * by_cells(right))
            both[c, d] += left
            both[c, d] += right
    pixels = by_cells(known.astype(np.float32))
    return max(crossed, float((pooled / np.maximum(pixels, 1.0)).sum()))
