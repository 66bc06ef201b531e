"""The table of an environment's picture: rotation, bands of latitude, texels and their weights.

For a picture of w x h texels it takes 16 w h bytes, and 4 (w + 1) h more for the choice of
directions: 10.5 MB for 1024 x 512.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.distributions import cumulative_2d
from alight.core.field_types import Triple
from alight.core.vec import luminance
from lanewise.vec3 import Vec3

# The table starts with the rotation from the world to the map, row by row.
COLUMNS, ROWS = 9, 10  # of cells: rows is one less than the picture's
LEFT_OUT = 11  # share of the light that the weights leave to BSDF sampling
FIRST_BAND, BAND = 12, 2  # after the header: numbers of each row of cells
TEXEL = 4  # finally: red, green, blue and weight, row by row of the picture

#: What scenes without a map hold.
EMPTY = np.zeros(FIRST_BAND, np.float32)


class EnvironmentMap(NamedTuple):
    """What kernels read of an environment.

    Attributes
    ----------
    table : (n,) float32
        As laid out above.
    cdf : (m,) float32
        Choice of the cell, see `alight.core.distributions.cumulative_2d`.
    mean : (float, float, float)
        Mean radiance over all directions, W/(m^2 sr).
    """

    table: NDArray[np.float32]
    cdf: NDArray[np.float32]
    mean: Triple


def environment_map(
    pixels: NDArray[np.float32], to_map: NDArray[np.float64], sampling: str, compensated: bool
) -> EnvironmentMap:
    """Make the table of a picture.

    Parameters
    ----------
    pixels : (h, w, 3) float32
        Radiance, not negative.
    to_map : (3, 3) float64
        Rotation from the world to the space of the map.
    sampling : {"importance", "uniform"}
    compensated : bool
        Take the mean off the weights.
    """
    left_out = 0.0
    if len(pixels) == 1:
        pixels = np.repeat(pixels, 2, axis=0)
    height, width = pixels.shape[:2]
    rows = height - 1
    bands = _bands(rows)
    # Solid angles of the cells of each row, as shares of the sphere.
    share = np.abs(bands[:, 1:]) / width
    texels = np.ones((height, width, TEXEL), np.float32)
    texels[:, :, :3] = pixels
    mean = [float((share * _cell_means(pixels[:, :, k].astype(float))).sum()) for k in range(3)]
    weights = np.ones((height, width))
    brightness = float(luminance(Vec3(*mean)))
    if sampling == "importance" and brightness > 0.0:
        weights = luminance(Vec3(*np.moveaxis(pixels.astype(float), 2, 0))) / brightness
        darker = np.maximum(weights - 1.0, 0.0)
        # Of a map of one value nothing would be left.
        if compensated and darker.max() > 1e-3:
            left_out = 1.0 - float((share * _cell_means(darker)).sum())
            weights = darker
    texels[:, :, 3] = weights
    header = np.concatenate([np.ravel(to_map), [width, rows, left_out]])
    table = np.concatenate([header, bands.ravel(), texels.ravel()]).astype(np.float32)
    # Weights as the kernels see them: what rounds to 0 there must not be drawn.
    seen = _cell_means(texels[:, :, 3].astype(float))
    return EnvironmentMap(table, cumulative_2d(share * seen), (mean[0], mean[1], mean[2]))


def _cell_means(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means over the corners of the cells between texels; the last column meets the first."""
    pairs = values + np.roll(values, -1, axis=1)
    return 0.25 * (pairs[:-1] + pairs[1:])


def _bands(rows: int) -> NDArray[np.float64]:
    """(q at the upper edge, difference to the lower edge) of each row of cells.

    q is sin^2(theta / 2), in the lower half cos^2(theta / 2); the rows' differences add up to 1,
    and so do their shares of the sphere's solid angle.
    """
    half = np.arange(rows + 1) * (0.5 * np.pi / rows)
    lower = 2 * np.arange(rows) + 1 > rows
    # sin^2 b - sin^2 a = sin(b + a) sin(b - a).
    size = np.sin(half[1:] + half[:-1]) * np.sin(half[1:] - half[:-1])
    edge = np.where(lower, np.cos(half[:-1]), np.sin(half[:-1])) ** 2
    return np.stack([edge, np.where(lower, -size, size)], axis=1)
