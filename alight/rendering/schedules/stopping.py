r"""Stopping at an error: the promise, the looks, and the final verdict.

A look at a film asks for the error that the true one does not exceed. Looks may be as many as they
like, because the error falls while one waits: a render can only be ended too early by a look that
comes before the error is reached, and the earlier it comes, the more wrong it has to be. Each look
holds the samples of those before it, so looks are alike, too: squared errors of sums of n and m > n
independent parts correlate by n / m.

The law behind the doubt of one look is that of sums of normal noise, in whose pictures the true
relMSE over the estimate is F(nu, (R - 1) nu). Of renders that end at their first look with
:math:`\hat e^2 F_{1-p} \le a^2`, the part with :math:`e^2 > a^2` is at most p from nu = 5 on, at
any confidence, and grows with the deviation sigma of log(relRMSE) where fewer pixels carry the
error: to 1.1, 1.3 and 2.2 p at nu = 3, 2 and 1 (sigma = 0.52, 0.66 and 1.07) at 95 %, and to 3.9 p
at nu = 1 and 99.9 %. So every look may be wrong with the whole doubt of the promise up to
:math:`\sigma = 0.35`, and with :math:`(0.35 / \sigma)^{5/4}` of it beyond that.
`tests/known_error/test_laws_of_promises.py` walks such renders.

Under the metric "pixel" a look is wrong if fewer of the pixels than estimated happen to be within
the error; that may have half of the doubt.

Light that has hardly been seen yet is in no error estimate, so there is a second figure, the unseen
energy, which has to be as small. `docs/known-error.md` has how often the promise was kept.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from statistics import NormalDist
from typing import Any, Literal, NamedTuple

import numpy as np

from alight.films import Film
from alight.metrics.error_estimate import LARGEST_TOLD
from alight.metrics.own_error import estimate_relmse
from alight.options.render import PromiseOptions
from alight.rendering.schedules.rare_noise import rare_noise
from alight.rendering.schedules.unseen import cell_sum, spread_over_pixels, unseen_error

#: Samples per pixel at the first look.
FIRST_LOOK = 16

#: Their growth from look to look, on average: there are four looks from one power of two of samples
#: of a replicate to the next, which is where the points of a sequence are most even.
GROWTH = 2.0**0.25

#: A pixel's own variance has R - 1 degrees of freedom; that of its cell counts as so many more, so
#: that R = 4 gives Student's distribution with 8.
_CELL_FREEDOM = 5.0

#: Deviation of log(relRMSE) up to which a look may be wrong as often as the promise.
WHOLE_DOUBT = 0.35

_NORMAL = NormalDist()

#: Multiple of the samples so far from which on no number is given.
_FAR = 1e4


@dataclass(frozen=True)
class Promise:
    """What a picture shall be when its render ends.

    Parameters
    ----------
    error : float
        Largest relRMSE, or under "pixel" the largest error of a pixel over max(pixel, 0.1 times
        the mean of the picture); in (0, 10].
    confidence : float, default 0.95
        Of the statement that it is.
    metric : {"relrmse", "pixel"}
    share : float, default 0.95
        Of the pixels (and channels) that are expected to be within `error`, under "pixel".

    Raises
    ------
    OptionError
        If a number is out of its range, or the metric is unknown.
    """

    error: float
    confidence: float = 0.95
    metric: Literal["relrmse", "pixel"] = "relrmse"
    share: float = 0.95

    def __post_init__(self) -> None:
        for name, one in PromiseOptions.options().items():
            object.__setattr__(self, name, one.check(getattr(self, name)))

    @property
    def doubt(self) -> float:
        """Probability that the promise may be broken."""
        return 1.0 - self.confidence

    def state(self) -> dict[str, Any]:
        """Copy the fields."""
        return asdict(self)


class Judgement(NamedTuple):
    """What one look says.

    Attributes
    ----------
    achieved : float
        The error that is not exceeded, with the confidence of this look, light behind glass that is
        expected to be missing among it; NaN means unknown.
    share : float
        Of the pixels within the error, at least, with the confidence of this look; NaN under
        "relrmse".
    unseen : float
        relRMSE that events may add which no sample has met yet: see `Unseen.figure`.
    doubtful : float
        Share of the 8x8 cells in which those events alone exceed the error.
    bound : float
        `Unseen.bound`, a bound of the same; NaN where there is none.
    within, met : bool
        Whether the estimated error is small enough; and the unseen energy, too.
    factor : float
        Times the samples so far that the promise needs; 1 if it is kept, infinite where the error
        has no useful bound, or light found by chance has none, so that nobody can tell.
    doubted : bool, default False
        Whether only the brightness of noisy pixels, of which too little is known, stands between
        the estimated error and the promise.
    value : float, default NaN
        The estimated relRMSE.
    """

    achieved: float
    share: float
    unseen: float
    doubtful: float
    bound: float
    within: bool
    met: bool
    factor: float
    doubted: bool = False
    value: float = math.nan

    @property
    def bounded(self) -> bool:
        """Whether the error has a bound of use."""
        return self.achieved <= LARGEST_TOLD


def look_doubt(doubt: float, deviation: float) -> float:
    """Probability that one look may be wrong, so that the first one that says "met" keeps a doubt.

    Parameters
    ----------
    doubt : float
        Of the promise, in (0, 0.5].
    deviation : float
        Of the logarithm of the estimated relRMSE.
    """
    return doubt * (WHOLE_DOUBT / max(deviation, WHOLE_DOUBT)) ** 1.25


def first_look(replicates: int) -> int:
    """Samples per pixel at the first look: whole rounds of the replicates."""
    return replicates * max(math.ceil(FIRST_LOOK / replicates), 2)


def next_look(spp: int, replicates: int) -> int:
    """Samples per pixel at the look after `spp`: 4, 5, 6 or 7 times a power of two a replicate."""
    rounds = spp // replicates
    step = 2 ** max(rounds.bit_length() - 3, 0)
    return replicates * step * (rounds // step + 1)


def judge(film: Film, promise: Promise) -> Judgement:
    """Look at a film whose pixels hold whole rounds of all replicates.

    Parameters
    ----------
    film : Film
    promise : Promise
    """
    known = film.largest_sample, film.by_chance, film.rare_light
    return judge_means(*film.replicate_means(), promise, *known)


def judge_means(
    means: np.ndarray,
    counts: np.ndarray,
    promise: Promise,
    largest: float | None = None,
    by_chance: bool = False,
    behind: np.ndarray | None = None,
) -> Judgement:
    """Judge as `judge`, from means (h, w, R, 3) and counts (h, w, R) of a film's replicates.

    `largest` bounds the value of a sample, if that is known; `by_chance` is whether no path was led
    to a light, `behind` what was seen behind glass.
    """
    estimate = estimate_relmse(means, counts, literature=False)
    if math.isnan(estimate.relmse.high):
        return Judgement(
            achieved=math.nan,
            share=math.nan,
            unseen=math.nan,
            doubtful=1.0,
            bound=math.nan,
            within=False,
            met=False,
            factor=math.inf,
        )
    sure = 1.0 - look_doubt(promise.doubt, estimate.figure.deviation)
    achieved = estimate.relrmse_below(sure)
    unseen = unseen_error(means, counts, promise.error, largest, by_chance, behind)
    if unseen.figure <= promise.error:
        # Noise, and light that is expected to be missing: each may be small enough, and not both.
        achieved = math.hypot(achieved, unseen.hidden)
    share, doubted = math.nan, False
    if promise.metric == "relrmse":
        within = achieved <= promise.error
        known = estimate.figure._replace(brightness=0.0, rise=0.0).quantile(sure)
        doubted = not within and known <= promise.error**2
        # Light that no sample has met adds its noise as soon as one does.
        unmet = rare_noise(means, counts, behind).unmet
        factor = (achieved**2 + unmet) / promise.error**2
        if achieved > LARGEST_TOLD:
            factor = math.inf
    else:
        doubt = 0.5 * promise.doubt
        share = share_within(means, counts, promise.error, doubt)
        within = share >= promise.share
        # The samples at which errors smaller by their root would be within.
        factor = 1.0
        while factor < 1e9 and promise.share > share_within(
            means, counts, promise.error * math.sqrt(factor), doubt
        ):
            factor *= 1.1
        if factor >= 1e9:
            factor = math.inf
    met = within and unseen.figure <= promise.error
    # What is unseen falls with the samples, not with their root.
    factor = 1.0 if met else max(factor, unseen.figure / promise.error, unseen.factor)
    return Judgement(
        achieved=achieved,
        share=share,
        unseen=unseen.figure,
        doubtful=unseen.doubtful,
        bound=unseen.bound,
        within=within,
        met=met,
        factor=factor,
        doubted=doubted,
        value=math.sqrt(estimate.figure.value),
    )


def share_within(means: np.ndarray, counts: np.ndarray, error: float, doubt: float) -> float:
    """Find the share of the pixels that are within an error, but for a probability of `doubt`.

    Each pixel's variance is its own with R - 1 degrees of freedom, joined with the relative
    variance of its cell, which counts as 5 more: one pixel's few replicates can agree by chance.
    How many of the pixels are within varies by no more than the binomial distribution of the
    expected share does (Hoeffding 1956).

    Parameters
    ----------
    means : ndarray, shape (h, w, R, 3)
    counts : ndarray of int, shape (h, w, R)
    error : float
        Allowed, over max(pixel, 0.1 times the mean of the picture).
    doubt : float
        Probability that the share is smaller, in (0, 0.5].
    """
    h, w, replicates, _ = means.shape
    n = np.maximum(counts.sum(axis=2), 1)[..., None]
    mean = (means * counts[..., None]).sum(axis=2) / n
    deviations = counts[..., None] * (means - mean[:, :, None]) ** 2
    squares = deviations.sum(axis=2) / max(replicates - 1, 1) / n
    scale = np.maximum(mean, 0.1 * float(mean.mean()))
    relative = squares / scale**2
    pixels = cell_sum(np.ones((h, w)))[..., None]
    pooled = spread_over_pixels(cell_sum(relative) / pixels, h, w)
    own = replicates - 1.0
    joined = (own * relative + _CELL_FREEDOM * pooled) / (own + _CELL_FREEDOM)
    with np.errstate(divide="ignore"):
        t = np.where(joined > 0.0, error / np.sqrt(joined), np.inf)
    share = float(_inside(t).mean())
    z = -_NORMAL.inv_cdf(doubt)
    return share - z * math.sqrt(max(share * (1.0 - share), 0.0) / (h * w))


def _inside(t: np.ndarray) -> np.ndarray:
    """P(|T| <= t) of Student's distribution with 8 degrees of freedom (A&S 26.7.4)."""
    cosine2 = 1.0 / (1.0 + t * t / 8.0)
    series = 1.0 + cosine2 * (0.5 + cosine2 * (0.375 + cosine2 * 0.3125))
    return np.sqrt(1.0 - cosine2) * series


def line_of(
    word: str, judgement: Judgement, promise: Promise, spp: float, seconds: float | None = None
) -> str:
    """Write the one line that a render ends with.

    Parameters
    ----------
    word : {"met", "not met", "not certifiable"}
    judgement : Judgement
    promise : Promise
    spp : float
        Samples per pixel so far.
    seconds : float, optional
        Spent on them.
    """
    asked = f"{100 * promise.error:.4g} %"
    sure = f"{100 * promise.confidence:.4g} % confidence"
    if promise.metric == "relrmse":
        reached = f"relRMSE at most {100 * judgement.achieved:.3g} %" if judgement.bounded else (
            f"relRMSE about {100 * judgement.value:.3g} %, but without a useful bound"
        )  # fmt: skip
    else:
        reached = f"{100 * judgement.share:.3g} % of the pixels within {asked}"
    if word == "met":
        bounded = judgement.bound <= promise.error
        kind = "bound" if bounded else "indicator"
        figure = judgement.bound if bounded else judgement.unseen
        unseen = f"unseen light {100 * figure:.2g} % ({kind})"
        return f"met: {reached} ({sure}, {spp:.4g} spp), {unseen}"
    if word == "not met":
        more = (judgement.factor - 1.0) * (spp if seconds is None else seconds)
        unit = "spp" if seconds is None else "s"
        if math.isinf(judgement.factor):
            return f"not met: {reached}, asked {asked}; how many samples it takes is unknown"
        if judgement.factor > _FAR:
            return f"not met: {reached}, asked {asked}; far more samples are needed"
        return f"not met: {reached}, asked {asked}; about {_told(more)} {unit} more are needed"
    if math.isnan(judgement.achieved):
        return "not certifiable: no light has been seen, or there is a single replicate"
    if judgement.doubted:
        return (
            f"not certifiable: relRMSE about {100 * judgement.value:.3g} %, asked {asked}, but too "
            "little is known of the brightness of the noisiest pixels"
        )
    return (
        f"not certifiable: {reached}, but in {100 * judgement.doubtful:.3g} % of the picture rare "
        f"bright samples may hide more than {asked}"
    )


def early_line(judgement: Judgement, promise: Promise, look: int) -> str:
    """Write the line of a render whose time ended between two looks, with an error within reach."""
    return (
        f"not met: the time ended before the look at {look} spp; relRMSE about "
        f"{100 * judgement.value:.3g} % so far, asked {100 * promise.error:.4g} %"
    )


def _told(number: float) -> str:
    """Three digits, never as a power of ten."""
    return f"{number:.3g}" if number < 100.0 else f"{float(f'{number:.3g}'):,.0f}"


def word_of(judgement: Judgement) -> str:
    """Name the end of a render whose budget is spent."""
    if judgement.met:
        return "met"
    if judgement.within or judgement.doubted or math.isnan(judgement.achieved):
        return "not certifiable"
    return "not met"
