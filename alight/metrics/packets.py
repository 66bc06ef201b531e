"""What packets of pixels say by some of their replicates: kernels that loops share."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from alight.metrics.noisy_pixels import ALONE, CLASSES, EDGES
from alight.metrics.survey import Survey
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_u32, load_lanes, maximum, minimum, store_lanes, where
from lanewise.view import View

_EDGE_0, _EDGE_1, _EDGE_2, _EDGE_3, _EDGE_4 = EDGES


class Picture(NamedTuple):
    """What loops read of a picture.

    Attributes
    ----------
    means, around : View of float32
        Planes, ``means[(3 * replicate + channel) * height * width + y * width + x]``; `around` is
        the brightness around a pixel.
    counts : View of float32
        ``counts[replicate * counts_plane + y * counts_row + x]``: where all pixels have the same,
        there is one row.
    channels : int
        3; no constant, so that loops over them stay short and compile fast.
    """

    means: View
    counts: View
    around: View
    height: int
    width: int
    replicates: int
    counts_plane: int
    counts_row: int
    epsilon: float
    channels: int = 3


def picture_of(seen: Survey, epsilon: float) -> Picture:
    """Lay a survey out for loops; replicates that lie plane by plane are not copied."""
    h, w, replicates, _ = seen.means.shape
    planes = np.ascontiguousarray(seen.means.transpose(2, 3, 0, 1), np.float32)
    uniform = len(seen.counts) < h or seen.counts.shape[1] < w
    shape = (replicates, 1, w) if uniform else (replicates, h, w)
    counts = np.broadcast_to(seen.counts.transpose(2, 0, 1), shape)
    counts = np.ascontiguousarray(counts, np.float32)
    return Picture(
        means=View(planes),
        counts=View(counts),
        around=View(seen.surroundings),
        height=h,
        width=w,
        replicates=replicates,
        counts_plane=counts[0].size,
        counts_row=0 if uniform else w,
        epsilon=epsilon,
    )


class Place(NamedTuple):
    """Where a packet of pixels is: its first one's row and column, and index in a plane."""

    y: int
    x: int
    at: int


class Half(NamedTuple):
    """What some replicates say of a channel: samples, brightness, variance of one sample."""

    samples: Any
    brightness: Any
    scatter: Any


@kernel(strict=True)
def samples_of(picture, place, replicate):
    """Samples of a replicate."""
    at = replicate * picture.counts_plane + place.y * picture.counts_row + place.x
    return load_lanes(picture.counts, at)


@kernel(strict=True)
def mean_of(picture, place, replicate, channel):
    """Mean of the samples of a replicate."""
    plane = picture.height * picture.width
    return load_lanes(picture.means, (3 * replicate + channel) * plane + place.at)


@kernel(strict=True)
def known_of(picture, place):
    """Which pixels have no empty replicate."""
    fewest = samples_of(picture, place, 0)
    for r in range(1, picture.replicates):
        fewest = minimum(fewest, samples_of(picture, place, r))
    return fewest > 0.0


@kernel(strict=True)
def half_of(picture, place, channel, first, last):
    """Look at the replicates from the first one to before the last one."""
    total, light = lanes(0.0), lanes(0.0)
    for r in range(first, last):
        n = samples_of(picture, place, r)
        total = total + n
        light = light + mean_of(picture, place, r, channel) * n
    total = maximum(total, 1.0)
    brightness, scatter = light / total, lanes(0.0)
    for r in range(first, last):
        deviation = mean_of(picture, place, r, channel) - brightness
        scatter = scatter + deviation * deviation * samples_of(picture, place, r)
    return Half(total, brightness, scatter * (1.0 / (last - first - 1)))


@kernel(strict=True)
def class_of_pixels(own, q2, error):
    """`noisy_pixels.class_of` of a packet, u32."""
    ratio, found = own / q2, lanes_u32(0)
    found = where(ratio > _EDGE_0, found + 1, found)
    found = where(ratio > _EDGE_1, found + 1, found)
    found = where(ratio > _EDGE_2, found + 1, found)
    found = where(ratio > _EDGE_3, found + 1, found)
    found = where(ratio > _EDGE_4, found + 1, found)
    return where(error > ALONE * own, found + CLASSES // 2, found)


@kernel(strict=True)
def inverse_square(brightness, variance, epsilon):
    """1 / (b^2 + epsilon) of the brightness behind the noise, to the second order."""
    square = brightness * brightness
    f = 1.0 / (square + epsilon)
    return f / (1.0 + maximum((4.0 * square * f - 1.0) * variance * f, -0.5))


@kernel(strict=True)
def around_of(picture, place, channel):
    """Squared brightness around, with epsilon."""
    q = load_lanes(picture.around, channel * picture.height * picture.width + place.at)
    return q * q + picture.epsilon


@kernel(strict=True)
def add_to(view, at, values):
    """Add to lanes in memory."""
    store_lanes(view, at, load_lanes(view, at) + values)
