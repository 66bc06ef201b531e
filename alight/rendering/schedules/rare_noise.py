r"""Noise of light that paths find by chance, known before samples show it.

Light that adds m to a pixel, and that a sample meets with probability r, brings m / r there and
nothing elsewhere: a variance of about :math:`m^2 / r` a sample. Before it is met no replicate shows
it, and a few such samples show it badly. The pilot that has looked for this light knows m and r
(`alight.rendering.light_behind_glass`). The rest of the noise is that of the replicates without
samples of this size.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from alight.rendering.pilot_rays import POINTS
from alight.rendering.schedules.unseen import cell_sum, spread_over_pixels

#: The pilot knows this noise to about a quarter, and as well as so many samples that have met it:
#: more than for numbers of one size, because how bright their pixels are is not known either.
_PILOT_DOUBT, _PILOT_EVENTS = 0.25, 64.0

#: Light is rare if fewer replicates of a pixel than this share have met it.
_RARE = 0.1

#: What brings this share of the noise are samples of that light, and not smaller ones.
_MOST = 0.9


class RareNoise(NamedTuple):
    """Noise of rare light at the samples so far.

    Attributes
    ----------
    noise : float, default 0
        relMSE that it is expected to bring.
    unmet : float, default 0
        So much of that comes in samples larger than all that are expected to have been met.
    piloted : float, default 0
        So much of that is known better by the pilot than by the samples that have met it.
    size : float, default infinity
        The smallest of those samples, channels added.
    """

    noise: float = 0.0
    unmet: float = 0.0
    piloted: float = 0.0
    size: float = math.inf

    @property
    def doubt(self) -> float:
        """Standard deviation of the noise's logarithm, as far as the pilot tells it."""
        return _PILOT_DOUBT * math.sqrt(self.piloted / self.noise) if self.noise > 0.0 else 0.0


def rare_noise(means: np.ndarray, counts: np.ndarray, behind: np.ndarray | None) -> RareNoise:
    """Find the noise of rare light.

    How much of it the samples tell depends on how many of the picture's, half as large or larger,
    are expected among those so far.

    Parameters
    ----------
    means : ndarray, shape (h, w, R, 3)
    counts : ndarray of int, shape (h, w, R)
    behind : ndarray, shape (n, 7), or None
        `Film.rare_light`.
    """
    if behind is None:
        return RareNoise()
    n, replicates = counts.sum(axis=2), counts.shape[2]
    pixels, cells, light = cell_sum(np.ones(n.shape)), behind[:, 1].astype(int), behind[:, 2:5]
    spp = (cell_sum(n) / pixels).ravel()[cells]
    # The last column of tables of earlier versions is q. What no path finds brings no noise.
    rate = behind[:, -1]
    rows = (rate > 0.0) & (rate * spp < _RARE * replicates)
    if not light[rows].any():
        return RareNoise()
    points, cells, light = behind[rows, 0].astype(int), cells[rows], light[rows]
    spp, rate = spp[rows], rate[rows]
    sample = light.sum(axis=1) / rate
    order = np.argsort(-sample)
    most = np.cumsum((light.sum(axis=1) * sample)[order])
    least = float(sample[order[np.searchsorted(most, _MOST * most[-1])]])
    # Medians of a whole picture would take longer than all else at a look.
    shown = np.zeros(pixels.shape, bool)
    shown.flat[cells] = True
    there = spread_over_pixels(shown, *n.shape)
    rest = np.zeros((*n.shape, 3))
    rest[there] = without_samples(means[there][None], counts[there][None], least)[0].mean(
        axis=1, dtype=np.float64
    )
    # What samples have met of it is chance; what it adds on average is known.
    added = np.stack([np.bincount(points, part, POINTS) for part in light.T], axis=1)[points]
    brightness = (cell_sum(rest) / pixels[..., None]).reshape(-1, 3)[cells] + added
    epsilon = (0.1 * float(means.mean())) ** 2
    square = (light**2 / (brightness**2 + epsilon)).mean(axis=1)
    noise, size = square / (rate * np.maximum(spp, 1.0) * POINTS), np.sqrt(square) / rate
    order = np.argsort(-size)
    noise, rate, size = noise[order], rate[order], size[order]
    events = np.cumsum(rate) * float(n.sum()) / POINTS
    met = events[np.searchsorted(-size, -0.5 * size, side="right") - 1]
    return RareNoise(
        noise=float(noise.sum()),
        unmet=float((noise * np.exp(-met)).sum()),
        piloted=float((noise * _PILOT_EVENTS / (_PILOT_EVENTS + met)).sum()),
        size=least,
    )


def without_samples(means: np.ndarray, counts: np.ndarray, size: float) -> np.ndarray:
    """Replicates without samples of a size, half as large or larger, channels added.

    What has more than the median of a pixel's replicates by as much gets the mean of the others.

    Parameters
    ----------
    means : ndarray, shape (h, w, R, 3)
    counts : ndarray of int, shape (h, w, R)
    size : float
        Radiance of one sample, channels added.

    Returns
    -------
    ndarray, shape (h, w, R, 3)
    """
    total = means.sum(axis=3)
    more = (total - np.median(total, axis=2, keepdims=True)) * counts
    met = more > 0.5 * size
    others = np.maximum((~met).sum(axis=2), 1)[..., None]
    mean = np.where(met[..., None], 0.0, means).sum(axis=2) / others
    return np.where(met[..., None], mean[:, :, None], means).astype(means.dtype)
