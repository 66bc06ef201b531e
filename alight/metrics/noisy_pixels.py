r"""True brightness of noisy pixels, estimated from replicates pooled over similar pixels.

A pixel's squared error is estimated by one half of its replicates, A, and has to be divided by its
brightness squared. The other half, B, tells the brightness without a share in that error; but where
a pixel is mostly noise, B often holds no bright sample at all, and the quotient is off by orders of
magnitude. Then many pixels must be pooled. Let q be the brightness of the pixels around,
:math:`\rho = \mu / q` what is sought, and r = s / q^2 the squared error by A. Over a class of
pixels that look alike to A, with replicates k and l of B,

.. math:: \frac{\sum r \rho_k}{\sum r} \to \mathrm E_r[\rho], \qquad
    \frac{\sum r \rho_k \rho_l}{\sum r} \to \mathrm E_r[\rho^2]

without bias, because A and B are independent. With these two moments the class is taken as
log-normal, which gives :math:`\mathrm E_r[1 / (\rho^2 + \epsilon / q^2)]`. This is empirical Bayes
estimation by replicates (Robbins 1956; Ignatiadis, Saha, Sun and Muralidharan 2021, "Empirical
Bayes mean estimation with nonparametric errors via order statistic regression on replicated data").

Where hardly a bright sample would be expected in B if the pixels were as bright as their
surroundings, and none was seen, they are taken to be so: a gamma prior, whose weight is the
probability of so many samples or more. It says nothing about how much pixels differ among
themselves.

Filters with negative lobes, and glass that disperses light, give samples of both signs, and these
cancel: a pixel may be black and as noisy as a bright one, which no log-normal distribution knows. A
black pixel's B is negative half the time, whatever A saw, so twice the :math:`s / \epsilon` of all
pixels whose B is negative has the expectation of what black pixels add to the sum, or more, since
bright ones can be negative too. Anything from nothing to that may be missing: a uniform
distribution of log(value), whose mean square is a third of the square of its end.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from alight.metrics.statistics import student_t_quantile

#: Squared error of one half of the replicates, over the brightness squared, below which a pixel
#: knows its own brightness: it is not a noisy one.
PRECISE = 0.02

#: Least brightness of such a pixel by the other half, over that by the first.
GUARD = 0.5

#: A's own brightness over that of the surroundings, squared, at which one class ends.
EDGES = (0.5**2, 1.0, 2.0**2, 8.0**2, 64.0**2)

#: A's squared error over its brightness squared, above which one replicate of A holds nearly all of
#: its light (it is 1/2 if one does): such pixels have classes of their own, as few of them are as
#: bright as they look.
ALONE = 0.3

CLASSES = 2 * (len(EDGES) + 1)

#: Groups of cells, each left out once to see how sure the classes are.
GROUPS = 16

#: Largest variance of log(rho) that a class may have.
_WIDEST = 4.0

#: Two moments do not tell the shape of a distribution: standard deviation of log(value), in parts
#: of what the spread of the classes makes of it.
_SHAPE = 1.0 / 3.0

#: Degrees of freedom that the groups have in any case.
_LEAST_FREEDOM = 2.0

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
_WEIGHTS /= _WEIGHTS.sum()

#: What `gather` adds up over pixels: r, r rho, r rho^2, r epsilon / q^2, r^2, r^(3/2),
#: r log(A's brightness squared / q^2), r times the variance of rho, and r q^2 / epsilon where B's
#: brightness is negative.
_SUMS = 9


class Believed(NamedTuple):
    """What is known of noisy pixels.

    Attributes
    ----------
    weights : ndarray, shape (CLASSES,)
        E_r[1 / (rho^2 + epsilon / q^2)] of each class.
    value : float
        Sum of r times its weight over all gathered pixels.
    lowest : float
        The same if pixels of which B says nothing are as bright as A says.
    variance : float
        Of log(`value`): of single pixels within their classes, of what is known of the classes, and
        of their shape.
    rise : float
        Of log(`value`) too, but only upwards: pixels may differ by more than B can tell, and be
        black where their samples have both signs.
    """

    weights: np.ndarray
    value: float
    lowest: float
    variance: float
    rise: float


def class_of(brightness: np.ndarray, around: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Sort pixels by what A says of them; 0 to CLASSES - 1.

    Parameters
    ----------
    brightness, around, error : ndarray of float32
        A's own brightness, that of the surroundings, and A's error, all squared.
    """
    classes = np.zeros(brightness.shape, np.uint8)
    for edge in EDGES:
        classes += brightness > np.float32(edge) * around
    classes += np.uint8(CLASSES // 2) * (error > np.float32(ALONE) * brightness)
    return classes


def no_sums() -> np.ndarray:
    """Begin with nothing gathered, shape (9, CLASSES, GROUPS)."""
    return np.zeros((_SUMS, CLASSES, GROUPS))


def gather(
    sums: np.ndarray,
    classes: np.ndarray,
    groups: np.ndarray,
    r: np.ndarray,
    rho: np.ndarray,
    rho_squared: np.ndarray,
    floor: np.ndarray,
    ratio: np.ndarray,
    noise: np.ndarray,
) -> None:
    """Add pixels to the sums of their classes.

    Parameters
    ----------
    sums : ndarray, shape (9, CLASSES, GROUPS)
        As `no_sums`; changed.
    classes, groups : ndarray of int, shape (n,)
    r : ndarray, shape (n,)
        Squared error by A, over q^2.
    rho, rho_squared : ndarray, shape (n,)
        Estimates without bias of brightness over q, and its square, by B.
    floor : ndarray, shape (n,)
        epsilon / q^2.
    ratio : ndarray, shape (n,)
        A's brightness squared over q^2.
    noise : ndarray, shape (n,)
        Variance of `rho`.
    """
    # The square of a very bright sample's r is no float32.
    keys, r = classes.astype(np.int64) * GROUPS + groups, r.astype(np.float64)
    rows = (
        r, r * rho, r * rho_squared, r * floor, r * r, r * np.sqrt(r), r * np.log(ratio), r * noise,
    )  # fmt: skip
    for total, row in zip(sums, rows, strict=False):
        total += np.bincount(keys, row, CLASSES * GROUPS).reshape(CLASSES, GROUPS)
    negative: np.ndarray = np.flatnonzero(rho < 0.0)
    if negative.size:
        keys, r, floor = (each.take(negative) for each in (keys, r, floor))
        sums[-1] += np.bincount(keys, r / floor, CLASSES * GROUPS).reshape(CLASSES, GROUPS)


def believe(
    sums: np.ndarray, repeats: int, a: int, b: int, replicates: int, unevenness: float = 0.0
) -> Believed:
    """Work out the classes.

    Parameters
    ----------
    sums : ndarray, shape (9, CLASSES, GROUPS)
    repeats : int
        How often one bright sample was gathered: for three channels and each way of halving.
    a, b, replicates : int
        Replicates of A, of B, and of both.
    unevenness : float, default 0
        How wrong surroundings are about the weight of one of this picture's pixels: mean square of
        the logarithm of brightness squared, with epsilon, over q^2.
    """
    # A single bright replicate x of A brings r = x^2 / (a R): its size from r.
    size = math.sqrt(a * replicates)
    whole = sums.sum(axis=2)
    seen = whole[0] > 0.0
    weights = np.zeros(CLASSES)
    if not seen.any():
        return Believed(weights, 0.0, 0.0, 0.0, 0.0)
    sums, whole = sums[:, seen], whole[:, seen, None]
    # Classes as they are, and without each group: added up anew, as differences would be rounded.
    rest = sums @ (1.0 - np.eye(GROUPS))
    left = rest[0] / whole[0]
    found = _classes(
        np.concatenate([whole, np.where(left > 0.0, rest, whole)], axis=2),
        repeats, b, size, unevenness,
    )  # fmt: skip
    weights[seen] = found.weight[:, 0]
    own = whole[0, :, 0] * weights[seen]
    value, lowest = float(own.sum()), float(own @ found.lowest[:, 0])
    groups = left_out(whole[0] * (found.weight[:, 1:] - found.weight[:, :1]) / value, left)
    parts = (own / value) ** 2
    pixels = found.spread[:, 0] * parts
    # Groups tell how well the bright samples of B are known, but for those of one group.
    single = ((sums[0] / whole[0]) ** 2).sum(axis=1)
    given = float((found.unlike[:, 0] + found.few[:, 0] * single) @ parts)
    between, within = float(groups.sum()), float(pixels.sum())
    # Few groups or pixels can carry the sum: Student's distribution, by as many as really have a
    # part in it (Satterthwaite 1946).
    doubt = between**2 / max(effective(groups) - 1.0, _LEAST_FREEDOM)
    doubt += float((pixels**2 / np.maximum(found.pixels[:, 0], _LEAST_FREEDOM)).sum())
    freedom = (between + within) ** 2 / doubt if doubt > 0.0 else math.inf
    student = _student(freedom)
    shape = _SHAPE * float(found.shape[:, 0] @ own) / value
    variance = (math.log1p(within) + between) * student**2 + math.log1p(given) + shape**2
    rise = math.log1p(float(((found.lift[:, 0] * own / value) ** 2).sum()))
    rise += math.log1p(2.0 * float(sums[-1].sum()) / value) ** 2 / 3.0
    return Believed(weights, value, lowest, variance, rise)


def _student(freedom: float) -> float:
    """Student's quantile for 95 %, over 1.96."""
    if freedom < 30.0:
        return student_t_quantile(0.975, freedom) / 1.96
    # Abramowitz and Stegun 26.7.5, relative error 1e-6: the quantile itself takes milliseconds.
    z2 = 1.96**2
    series = (3.0 * z2**3 + 19.0 * z2**2 + 17.0 * z2 - 15.0) / (384.0 * freedom)
    series = (series + (5.0 * z2**2 + 16.0 * z2 + 3.0) / 96.0) / freedom
    return 1.0 + (series + 0.25 * (z2 + 1.0)) / freedom


def left_out(moves: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Jackknife over groups of any size.

    Without a part p of its weight a mean moves by p / (1 - p) times its variance, squared: times
    1 - p, all groups add up to the variance, however unequal they are (compare Busing, Meijer and
    van der Leeden 1999, "Delete-m jackknife for unequal m"). A group that vanishes has no say.

    Parameters
    ----------
    moves : ndarray, shape (classes, groups)
        How the value of each class changes without each group, over the value of all classes.
    left : ndarray, shape (classes, groups)
        What part of a class is left without a group, 0 to 1.

    Returns
    -------
    ndarray, shape (groups,)
        Terms of the variance of log(value).
    """
    return np.log1p((moves * np.sqrt(left)).sum(axis=0)) ** 2


class _Classes(NamedTuple):
    """What classes say, arrays of one shape.

    Attributes
    ----------
    weight, spread : ndarray
        E_r[1 / (rho^2 + epsilon / q^2)], and its relative variance by single pixels.
    unlike, few : ndarray
        Variance of log(weight) because surroundings say little about single pixels, and because B
        holds few bright samples.
    shape : ndarray
        log(weight) less what it were if all pixels were alike.
    lowest : ndarray
        The least that the weight may be for lack of evidence, over itself.
    pixels : ndarray
        How many there really are.
    lift : ndarray
        What the weight may grow by if pixels differ by more than B can tell, over itself.
    """

    weight: np.ndarray
    spread: np.ndarray
    unlike: np.ndarray
    few: np.ndarray
    shape: np.ndarray
    lowest: np.ndarray
    pixels: np.ndarray
    lift: np.ndarray


def _classes(sums: np.ndarray, repeats: int, b: int, size: float, unevenness: float) -> _Classes:
    """Work out classes of any shape from what `gather` added up, shape (9, ...)."""
    total, first, second, floor, squares, roots, ratio, noise, _ = sums
    pixels = total * total / (squares * repeats)
    # Bright samples that B would hold if the pixels were as bright as their surroundings; and does.
    expected = b * pixels * total / (size * roots)
    seen = np.maximum(expected * first / total, 0.0)
    prior = np.ones(seen.shape)
    for at in zip(*np.nonzero(seen > 0.5), strict=True):
        prior[at] = poisson_tail(math.ceil(seen[at]), float(expected[at]))
    mean = (seen + prior) / (expected + prior)
    share = prior / (expected + prior)
    square = np.maximum((1.0 - share) * second / total + share * mean * mean, mean * mean)
    weight, spread = _log_normal(mean, square - mean * mean, floor / total)
    shape = np.log(weight * (square + floor / total))
    # That two replicates of B are bright in one pixel tells how much pixels differ: log(square) is
    # known to 1 / sqrt(pairs). No n pixels differ by more than if one had all the light.
    known = mean * mean / np.maximum(b * noise / total, 1e-12 * mean * mean)
    pairs = 0.5 * b * (b - 1) * pixels * known * known
    most = np.maximum(square, mean * mean * pixels)
    differing = np.minimum(square * np.exp(np.minimum(1.0 / np.sqrt(pairs), 99.0)), most)
    lift = _log_normal(mean, differing - mean * mean, floor / total)[0] / weight - 1.0
    # As far as the prior speaks, the truth may be anything from the surroundings to what A saw.
    far = np.maximum(ratio / total - np.log(np.maximum(mean * mean, 1.0)), 0.0)
    lowest = np.exp(-far * share)
    # As far as the prior speaks, a pixel is as unlike its surroundings as pixels of this picture
    # are; as far as B does, log(rho) is known as the logarithm of a rate is from its events.
    unlike = unevenness * share**2 / np.maximum(pixels, 0.1)
    slope = 2.0 * mean * mean / (mean * mean + floor / total)
    few = (slope * (1.0 - share)) ** 2 * _variance_of_log_rate(seen)
    spread = spread / np.maximum(pixels, 0.1)
    return _Classes(
        weight=weight,
        spread=spread,
        unlike=unlike,
        few=few,
        shape=shape,
        lowest=lowest,
        pixels=pixels,
        lift=np.maximum(lift, 0.0),
    )


def _variance_of_log_rate(events: np.ndarray) -> np.ndarray:
    """Variance of log(x), x with the gamma distribution of shape events + 1: trigamma, to 1 %."""
    x = 1.0 / (events + 1.0)
    # Abramowitz and Stegun 6.4.12.
    return x * (1.0 + x * (0.5 + x * (1.0 / 6.0 - x * x / 30.0)))


def _log_normal(
    mean: np.ndarray, variance: np.ndarray, floor: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """E[1 / (rho^2 + floor)] and its relative variance, rho log-normal, by quadrature."""
    mean = np.maximum(mean, 1e-12)
    v = np.minimum(np.log1p(variance / mean**2), _WIDEST)[..., None]
    rho = np.exp(np.log(mean)[..., None] - 0.5 * v + np.sqrt(v) * _NODES)
    x = 1.0 / (rho * rho + floor[..., None])
    first = x @ _WEIGHTS
    return first, np.maximum((x * x) @ _WEIGHTS / first**2 - 1.0, 0.0)


def effective(terms: np.ndarray) -> float:
    """Count the terms that a sum really has: (sum x)^2 / sum x^2; infinity if all are 0."""
    squares = float((terms * terms).sum())
    return float(terms.sum()) ** 2 / squares if squares > 0.0 else math.inf


def poisson_tail(k: int, mean: float) -> float:
    """P(X >= k) of a Poisson distribution; normal where the mean is above 50."""
    if k <= 0:
        return 1.0
    if mean > 50.0:
        return 0.5 * math.erfc((k - 0.5 - mean) / math.sqrt(2.0 * mean))
    term = below = math.exp(-mean)
    for i in range(1, min(k, 400)):
        term *= mean / i
        below += term
    return max(1.0 - below, 0.0)
