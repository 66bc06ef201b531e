r"""Error bars of single pixels, with heavy tails learnt from the pixels around.

R = 4 replicates say little of one pixel's variance, and nothing where the samples that carry it
have not come yet: a pixel without its bright sample is dark *and* agrees with itself. The pixels
around know better. With q the brightness around a pixel (`surroundings`), its relative variance
:math:`\mathrm{SE}^2 / q^2` is averaged over the 8x8 pixels of its cell: v. Half of a bar, squared,
is

.. math:: t^2\, \frac{(R - 1)\, \mathrm{SE}^2 + 5\, q^2 v}{R - 1 + 5}
    + q^2 \min(t^2, 9 \lambda) \max(V - v, 0)

with t of Student's distribution with R - 1 + 5 degrees of freedom. The second term is for bright
samples that came to the 5x5 cells around, whose average is V, but not here. If a share
:math:`\lambda` of the pixels has one, of size c, they bring :math:`V = \lambda c^2` and
:math:`\lambda c = \sqrt{\lambda V}` of light, which a pixel without any lacks: the bar has room for
three times that, or for t deviations where this is less.

How many pixels carry a variance is :math:`(\sum v)^2 / \sum v^2`. Where that is below 3 in 5x5
cells, there is no telling how much more may be missing: the bar is marked *unsure*.
"""

from __future__ import annotations

import math
import numbers
from typing import NamedTuple

import numpy as np

from alight.core.arguments import expect
from alight.core.errors import OptionError
from alight.metrics.statistics import student_t_quantile
from alight.metrics.surroundings import by_cells, neighbours, pixels_of_cells, spread_out
from alight.metrics.survey import Survey, survey

#: Degrees of freedom that the pooled variance counts as.
_POOLED = 5.0

#: Pixels that carry the variance of 5x5 cells, below which a bar is unsure.
_THIN = 3.0

#: How many times their mean contribution missing bright samples may have.
_MISSED = 3.0

#: Relative variance that is none (a picture's last bits differ by so much), and above which thin
#: evidence is told: errors of 1 %.
_NOTHING, _TOLD = 1e-9, 1e-4


class PixelBars(NamedTuple):
    """An interval for each pixel and channel.

    Attributes
    ----------
    low, high : ndarray of float32, shape (h, w, 3)
        Radiance; NaN means unknown.
    unsure : ndarray of bool, shape (h, w)
        Pixels whose bars may be too short: so few samples carry the noise around them that others,
        as bright, may be missing. Unknown pixels are unsure.
    """

    low: np.ndarray
    high: np.ndarray
    unsure: np.ndarray

    @property
    def unsure_share(self) -> float:
        """Share of the pixels whose bars are unsure."""
        return float(self.unsure.mean())


def pixel_bars(means: np.ndarray, counts: np.ndarray, confidence: float = 0.95) -> PixelBars:
    """Give every pixel an interval that holds the true one with a probability of `confidence`.

    Parameters
    ----------
    means : ndarray of float32, shape (h, w, R, 3)
        Of the samples of each replicate.
    counts : ndarray of int, shape (h, w, R)
    confidence : float, default 0.95
        In (0, 1).

    Raises
    ------
    OptionError
        If `confidence` is out of its range.

    Notes
    -----
    Meant for each pixel by itself: of 100 sure pixels about 5 lie outside. Light that no sample of
    the whole neighbourhood has met is in no bar.
    """
    return bars_of(survey(means, counts), confidence)


def bars_of(seen: Survey, confidence: float = 0.95) -> PixelBars:
    """Give intervals as `pixel_bars`, from what has been seen of a picture."""
    expect(confidence, numbers.Real, "confidence", "a number in (0, 1), as 0.95")
    if not 0.0 < confidence < 1.0:
        raise OptionError(f"must lie in (0, 1), as 0.95, got {confidence:.6g}", "confidence")
    own = np.float32(max(seen.replicates - 1, 1))
    t = np.float32(student_t_quantile(0.5 + 0.5 * confidence, float(own) + _POOLED))
    scale, pooled, rare, unsure = _pooled(seen, t)
    # Half of a bar, squared: what is the same in a cell is worked out once for it.
    part = t * t / (own + np.float32(_POOLED))
    bar = spread_out(np.float32(_POOLED) * part * pooled + rare, *seen.known.shape)
    bar *= scale
    bar += own * part * seen.variance
    half = np.sqrt(bar, out=bar)
    half[:, ~seen.known] = math.nan
    low, high = seen.picture - half, seen.picture + half
    return PixelBars(low.transpose(1, 2, 0), high.transpose(1, 2, 0), unsure)


def unsure_pixels(seen: Survey) -> np.ndarray:
    """Find the pixels that are unsure in `bars_of` at 95 %, without the bars."""
    t = np.float32(student_t_quantile(0.975, max(seen.replicates - 1, 1) + _POOLED))
    return _pooled(seen, t)[-1]


def _pooled(seen: Survey, t: np.float32) -> tuple[np.ndarray, ...]:
    """Brightness squared (3, h, w), what `_pool` finds, and unsure pixels (h, w)."""
    scale = seen.surroundings * seen.surroundings
    # A picture without light has no epsilon: its noise must still have a square.
    least = 1e-15 * float(seen.variance.max()) if seen.epsilon == 0.0 else 0.0
    scale += np.float32(max(seen.epsilon, least, 1e-30))
    pooled, rare, thin = _pool(seen.variance / scale, t)
    unsure = spread_out(thin, *seen.known.shape)
    unsure |= ~seen.known
    return scale, pooled, rare, unsure


def _pool(relative: np.ndarray, t: np.float32) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pool relative variances (3, h, w) over cells.

    Returns
    -------
    pooled, rare : ndarray, shape (3, cells_y, cells_x)
        Of the own cell; and what a bar, squared and over the brightness squared, has to be longer
        for bright samples that came to the cells around and not here.
    unsure : ndarray of bool, shape (cells_y, cells_x)
    """
    pixels, own = pixels_of_cells(*relative.shape[1:]), by_cells(relative)
    squares = neighbours(by_cells(relative * relative), 2)
    wide, wide_pixels = neighbours(own, 2), neighbours(pixels, 2)
    carriers = np.minimum(wide * wide / np.maximum(squares, np.float32(1e-30)), wide_pixels)
    own, wide = own / pixels, wide / wide_pixels
    rare = np.maximum(wide - own, 0.0)
    rare *= np.minimum(_MISSED**2 * carriers / wide_pixels, t * t)
    # A cell without any noise, such as a plain background, is exact.
    rare[own <= _NOTHING] = 0.0
    thin = (carriers < _THIN) & (own + rare > _TOLD)
    return own, rare, np.any(thin, axis=0)
