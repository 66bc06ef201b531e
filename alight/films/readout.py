"""Reading a film: pictures and replicate means from its exact sums, band of rows by band.

In large films compiled loops pass once over the sums; NumPy needs several passes over integers of
which every second belongs to another limb, five times the time. Small films do not wait for machine
code. Both give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from alight.films import statistics
from alight.films.fixed_point import HIGH_UNIT, LOW_BITS, LOW_MASK, LOW_UNIT, MAX_SAMPLES
from lanewise.jit import StockKernel, instantiate, kernel
from lanewise.machine_code import MachineCode
from lanewise.view import View

if TYPE_CHECKING:
    from alight.films.film import Film

#: Rows that are worked on at a time: bounds scratch memory, and how long tiles wait for the lock.
BAND = 16

#: Sums of replicates from which on machine code is worth loading.
_LARGE = 2**16


class Extent(NamedTuple):
    """How many pixels a band has, replicates a pixel, and channels a replicate."""

    pixels: int
    replicates: int
    channels: int


@kernel(strict=True)
def read_replicates(sums, counts, means, start, plane, extent):
    """Means of the replicates of a band of pixels, one plane for each replicate and channel.

    Parameters
    ----------
    sums, counts : View of int64
        Of these pixels.
    extent : Extent
    means : View of float32
        ``means[(3 * replicate + channel) * plane + start + pixel]``.
    """
    pixels, replicates, channels = extent
    for p in range(pixels):
        for r in range(replicates):
            n = max(counts[p * replicates + r], 1)
            at = (p * replicates + r) * channels * 2
            for c in range(3):
                value = sums[at + 2 * c] * HIGH_UNIT + sums[at + 2 * c + 1] * LOW_UNIT
                means[(3 * r + c) * plane + start + p] = value / n


@kernel(strict=True)
def read_image(sums, counts, image, start, extent):
    """Means of a band of pixels over all samples, at most `MAX_SAMPLES` each.

    Parameters
    ----------
    sums, counts : View of int64
        Of these pixels.
    image : View of float32
        ``image[3 * (start + pixel) + channel]``.
    extent : Extent
    """
    pixels, replicates, channels = extent
    for p in range(pixels):
        n = 0
        for r in range(replicates):
            n += counts[p * replicates + r]
        n = max(n, 1)
        for c in range(3):
            high, low = 0, 0
            for r in range(replicates):
                at = ((p * replicates + r) * channels + c) * 2
                high += sums[at]
                low += sums[at + 1]
            value = (high + (low >> LOW_BITS)) * HIGH_UNIT + (low & LOW_MASK) * LOW_UNIT
            image[3 * (start + p) + c] = value / n


@lru_cache(maxsize=2)
def _compiled(text: Callable) -> Callable:
    """Machine code; it is the same for all films, and so are the types that it is given."""
    kernel = instantiate(text)
    assert isinstance(kernel, MachineCode | StockKernel)
    return kernel.fixed()


def by_bands(film: Film, statistic: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
    """Work out a statistic of sums and counts; the lock is held only to copy a band."""
    result: np.ndarray | None = None
    for y in range(0, film.crop[3], BAND):
        with film.lock:
            sums, counts = film.sums[y : y + BAND].copy(), film.counts[y : y + BAND].copy()
        band = statistic(sums, counts)
        if result is None:
            result = np.zeros((film.crop[3], *band.shape[1:]), band.dtype)
        result[y : y + BAND] = band
    assert result is not None
    return result


def image_of(film: Film) -> np.ndarray:
    """Mean over all samples, float32, shape (h, w, 3)."""
    h, w, replicates = film.counts.shape
    room = int(film.counts.max(initial=0)) * replicates <= MAX_SAMPLES
    if film.counts.size < _LARGE or not room:
        return by_bands(film, lambda s, n: statistics.pixel_mean(s, n)[..., :3].astype(np.float32))
    image, channels = np.zeros((h, w, 3), np.float32), len(film.channels)
    read, target = _compiled(read_image), View(image)
    for y in range(0, h, BAND):
        with film.lock:
            counts = film.counts[y : y + BAND]
            extent = Extent(counts.shape[0] * w, replicates, channels)
            sums = View(film.sums[y : y + BAND])
            read(sums, View(counts), target, y * w, extent)
    return image


def mean_of(film: Film) -> np.ndarray:
    """Mean of every channel, float64, shape (h, w, C)."""
    return by_bands(film, statistics.pixel_mean)


def error_of(film: Film) -> np.ndarray:
    """Standard error of the picture, float32, shape (h, w, 3); NaN where it is unknown."""
    return by_bands(
        film, lambda s, n: statistics.mean_and_error(s, n)[1][..., :3].astype(np.float32)
    )


def replicates_of(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Mean of each replicate, float32, shape (h, w, R, 3), and the counts (h, w, R)."""
    h, w, replicates = film.counts.shape
    if film.counts.size < _LARGE:
        # Counts are exact in float32: they are below 2^19.
        both = by_bands(film, _means_and_counts)
        return both[..., :3], both[..., 3].astype(np.int64)
    # One plane after the other, as the estimates of the error want them.
    planes, channels = np.zeros((replicates, 3, h, w), np.float32), len(film.channels)
    held = np.zeros((h, w, replicates), np.int64)
    read, target = _compiled(read_replicates), View(planes)
    for y in range(0, h, BAND):
        with film.lock:
            counts = film.counts[y : y + BAND]
            held[y : y + BAND] = counts
            extent = Extent(counts.shape[0] * w, replicates, channels)
            sums = View(film.sums[y : y + BAND])
            read(sums, View(counts), target, y * w, h * w, extent)
    return planes.transpose(2, 3, 0, 1), held


def _means_and_counts(sums: np.ndarray, counts: np.ndarray) -> Any:
    means = statistics.replicate_means(sums[:, :, :, :3], counts)
    return np.concatenate([means, counts[..., None]], axis=-1).astype(np.float32)


def alpha_of(film: Film) -> np.ndarray | None:
    """Alpha of each pixel, float32, shape (h, w); None where the picture has a background."""
    covered, shadow = cover_of(film)
    return covered if covered is None or shadow is None else covered + shadow


def cover_of(film: Film) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Coverage of each pixel, and what shadows add to it; None for what the picture has not."""
    # With a background in it the picture has no alpha, whatever layers there are.
    if "alpha" not in film.aov_sums or not film.options.get("hide_emitters"):
        return None, None
    shadow = film.aov("shadow")[..., 0] if "shadow" in film.aov_sums else None
    return film.aov("alpha")[..., 0], shadow


def alpha_error_of(film: Film) -> np.ndarray | None:
    """Standard error of alpha, float32, shape (h, w), as of independent samples.

    That of samples that are spread evenly is smaller. None where alpha is, NaN below two samples;
    too small for filters with negative lobes, unless shadows are caught.
    """
    alpha = alpha_of(film)
    if alpha is None:
        return None
    # A sample that is covered, or not, has its weight as its square where filters have one sign.
    square = film.aov("shadow")[..., 1] if "shadow" in film.aov_sums else alpha
    n = film.sample_count.astype(np.float64)
    variance = np.maximum(square - alpha.astype(np.float64) ** 2, 0.0)
    return np.sqrt(variance / np.where(n > 1, n - 1.0, np.nan)).astype(np.float32)
