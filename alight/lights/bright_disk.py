"""The brightest part of a picture of the surroundings, if it is as small as a sun."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.field_types import Triple
from alight.core.vec import luminance
from lanewise.vec3 import Vec3

#: What is not as bright as this part of the brightest texel lies outside.
LEAST = 0.1
#: Larger ones are no suns, radians; nor are those that send less than this part of all light.
WIDEST, LEAST_SHARE = 0.15, 0.05


class Disk(NamedTuple):
    """Directions around one.

    Attributes
    ----------
    axis : (3,) float64
        Unit vector to its middle, in world space.
    half_angle : float, radians
    mean : triple
        Its radiance over all directions, without the light's colour.
    """

    axis: NDArray[np.float64]
    half_angle: float
    mean: Triple


def brightest_disk(pixels: NDArray[np.float32], to_map: NDArray[np.float64]) -> Disk | None:
    """The disk around what is nearly as bright as the brightest texel of a picture.

    Parameters
    ----------
    pixels : (h, w, 3) float32
        Latitudes and longitudes, as of `alight.lights.environment`.
    to_map : (3, 3) float64
        Rotation from the world to the space of the picture.
    """
    bright = np.asarray(luminance(Vec3(*np.moveaxis(pixels.astype(float), 2, 0))))
    rows, columns = bright.shape
    if rows < 2 or bright.max() <= 0.0:
        return None
    theta = np.arange(rows) * (np.pi / (rows - 1))
    phi = (np.arange(columns) + 0.5) * (2.0 * np.pi / columns)
    # Of texels: of the poles' rows, half a row.
    edges = np.clip(np.append(theta[0] - 1.0, theta) + 0.5 * theta[1], 0.0, np.pi)
    share = (np.cos(edges[:-1]) - np.cos(edges[1:])) / (2.0 * columns)
    row, column = np.nonzero(bright >= LEAST * bright.max())
    sine = np.sin(theta[row])
    d = np.stack([sine * np.sin(phi[column]), np.cos(theta[row]), -sine * np.cos(phi[column])], 1)
    weights = bright[row, column] * share[row]
    axis = (weights[:, None] * d).sum(axis=0)
    norm = float(np.linalg.norm(axis))
    if norm == 0.0:
        return None
    axis /= norm
    # The radiance between two texels falls to that of the next one.
    texel = float(np.hypot(theta[1], 2.0 * np.pi / columns))
    half_angle = float(np.arccos(np.clip(d @ axis, -1.0, 1.0)).max()) + texel
    light = float(weights.sum())
    if half_angle > WIDEST or light < LEAST_SHARE * float((bright.sum(axis=1) * share).sum()):
        return None
    red, green, blue = (pixels[row, column].astype(float) * share[row, None]).sum(axis=0)
    return Disk(to_map.T @ axis, half_angle, (float(red), float(green), float(blue)))
